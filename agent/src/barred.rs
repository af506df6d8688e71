//! Cells that the robot's vehicle could not enter although the map says that it can: too narrow for it, or with something
//! in the way.
//!
//! The robot plans as if they were closed. What is in the way may leave, so after a while such a cell is open again; each
//! time it could not be entered that is twice as long. They are the robot's own: other vehicles may find a way.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::terrain::{Ground, Terrain};

/// How long a cell is closed at first.
const FIRST: Duration = Duration::from_mins(1);
/// The longest time for which one is closed.
const LONGEST: Duration = Duration::from_hours(24);

/// Cells that could not be entered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Barred {
    cells: BTreeMap<Cell, Bar>,
}

/// How long a cell is closed.
#[derive(Clone, Copy, Debug)]
struct Bar {
    /// `None`: it is open again.
    until: Option<MissionTime>,
    next: Duration,
}

impl Barred {
    /// A cell could not be entered.
    pub(crate) fn add(&mut self, now: MissionTime, cell: Cell) {
        let bar = self.cells.entry(cell).or_insert(Bar { until: None, next: FIRST });
        bar.until = Some(now + bar.next);
        bar.next = (2 * bar.next).min(LONGEST);
    }

    /// Opens the cells whose time is over; returns whether there are any.
    pub(crate) fn open(&mut self, now: MissionTime) -> bool {
        let over = self.cells.values_mut().filter(|bar| bar.until.is_some_and(|until| until <= now));
        over.map(|bar| bar.until = None).count() > 0
    }

    /// A map as the robot plans on it: what is closed may still be seen from beside it.
    pub(crate) fn on(&self, terrain: &Terrain) -> Terrain {
        let closed = self.cells.iter().filter(|(_, bar)| bar.until.is_some());
        terrain.with_ground(
            closed.map(|(&cell, _)| (cell, Ground { traversable: false, ..terrain.ground(cell) })),
        )
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.cells.values().all(|bar| bar.until.is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_closed_for_a_minute_and_then_for_twice_as_long_each_time() {
        let terrain = Terrain::from_ascii("...", 1.0).unwrap();
        let cell = terrain.grid().cell_numbered(1).unwrap();
        let mut barred = Barred::default();
        let at = |seconds| MissionTime::START + Duration::from_secs(seconds);
        let drawn = |barred: &mut Barred, seconds| {
            let has_opened = barred.open(at(seconds));
            (has_opened, barred.on(&terrain) == Terrain::from_ascii(".~.", 1.0).unwrap())
        };
        barred.add(at(10), cell);
        assert_eq!(drawn(&mut barred, 69), (false, true));
        assert_eq!(drawn(&mut barred, 70), (true, false));
        assert!(barred.is_empty());
        barred.add(at(80), cell);
        assert_eq!(drawn(&mut barred, 199), (false, true));
        assert_eq!(drawn(&mut barred, 200), (true, false));
        assert_eq!(drawn(&mut barred, 201), (false, false));
    }
}
