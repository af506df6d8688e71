//! Commands of the operator to a running mission, given at the coordinator.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::observation::RobotId;

use crate::directive::TeamOrder;
use crate::orders::RobotOrder;
use crate::verdict::Decision;
use crate::zones::Zone;

/// A command of the operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// An order to all robots.
    Team(TeamOrder),
    /// An order to one robot.
    Robot(RobotId, RobotOrder),
    /// Mark a cell.
    Mark(Mark, Cell),
    /// Add these cells to the search area.
    Search(Vec<Cell>),
    /// Take these cells out of the search, or open them again.
    Zone(Zone, Vec<Cell>),
    /// Decide about the find in a cell.
    Judge(Decision, Cell),
}

/// An operator's mark of a cell. It counts as one reading of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Searched without a find: the log-odds fall by [`Mark::STRENGTH_NATS`].
    Searched,
    /// A clue to an object: they rise by as much.
    Clue,
}

impl Mark {
    /// All marks.
    pub const ALL: [Self; 2] = [Self::Searched, Self::Clue];

    /// How far one mark moves the log-odds of its cell, nats: the odds change by a factor of 55.
    pub const STRENGTH_NATS: f64 = 4.0;
    /// A reading of 0 or 1 moves the log-odds by `1 / (2 variance)`.
    const VARIANCE: f32 = 0.125;

    /// The mark as a reading of its cell.
    #[must_use]
    pub const fn reading(self, cell: Cell) -> Reading {
        let value = match self {
            Self::Searched => 0.0,
            Self::Clue => 1.0,
        };
        Reading { cell, value, variance: Self::VARIANCE }
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::*;

    #[test]
    fn a_mark_moves_the_log_odds_by_its_strength() {
        let cell = Grid::new(1, 1).unwrap().cells().next().unwrap();
        for (mark, expected) in [(Mark::Searched, -Mark::STRENGTH_NATS), (Mark::Clue, Mark::STRENGTH_NATS)] {
            let reading = mark.reading(cell);
            assert!(reading.is_valid());
            let moved = reading.evidence().log_likelihood_ratio_nats();
            assert!((moved - expected).abs() < 1e-9, "{mark:?} {moved}");
        }
    }
}
