//! The directive: all commands of the operator so far except marks, gossiped by all participants.
//!
//! Every status of the coordinator and every heartbeat carries it, so that it also reaches robots without a connection
//! to the coordinator, and a restarted coordinator receives it from the robots. Merging is commutative and idempotent:
//! the newest order counts, and added cells are never removed.

use std::collections::BTreeSet;
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;

/// An order dated later than this after its reception counts as dated so. No correct clock is as far ahead, and no
/// later order could follow one at the end of time.
pub(crate) const MOST_AHEAD: Duration = Duration::from_hours(365 * 24);

/// What the operator wants of all robots. Of two simultaneous orders the later one here wins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum TeamOrder {
    /// They search.
    #[default]
    Search,
    /// They return to their bases, and rest there.
    Return,
    /// The mission ends: they return to their bases, and rest there.
    End,
    /// They stay where they are.
    Pause,
}

/// The operator's latest order to all robots, and all added cells. The default contains neither.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Directive {
    /// When the order was given: nanoseconds of mission time, or one more than the number before if the coordinator's clock
    /// is behind; 0 if never.
    pub number: u64,
    /// The order.
    pub order: TeamOrder,
    /// Cells that the operator added to the search area.
    pub added: BTreeSet<Cell>,
}

impl Directive {
    /// Merges another participant's directive; returns whether anything changed.
    pub fn merge(&mut self, now: MissionTime, other: &Self) -> bool {
        if self == other {
            return false;
        }
        let numbered = (other.number.min((now + MOST_AHEAD).0), other.order);
        let is_newer = numbered > self.numbered_order();
        if is_newer {
            (self.number, self.order) = numbered;
        }
        let before = self.added.len();
        self.added.extend(&other.added);
        is_newer || self.added.len() > before
    }

    /// Gives all robots an order, as of a time in nanoseconds.
    pub fn give(&mut self, time_ns: u64, order: TeamOrder) {
        self.number = time_ns.max(self.number.saturating_add(1));
        self.order = order;
    }

    /// The order with its number: the greater of two counts.
    #[must_use]
    pub const fn numbered_order(&self) -> (u64, TeamOrder) {
        (self.number, self.order)
    }
}

/// Prior probability of an object in a cell that the operator adds: the mean over the cells that the scenario searches,
/// clamped to 0.001 to 0.999, so that readings can change it.
#[must_use]
pub fn added_prior(prior: &Belief, terrain: &Terrain) -> f64 {
    prior.mean_prior(terrain).clamp(0.001, 0.999)
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::TeamOrder::{Pause, Return, Search};
    use super::*;

    fn directive(number: u64, order: TeamOrder, added: impl IntoIterator<Item = u32>) -> Directive {
        let grid = Grid::new(1, 9).unwrap();
        let added = added.into_iter().map(|number| grid.cell_numbered(number).unwrap()).collect();
        Directive { number, order, added }
    }

    #[test]
    fn any_order_of_arrival_gives_the_same_directive() {
        let reported = [directive(5, Pause, 0..2), directive(5, Return, 4..6), directive(3, Search, 1..3)];
        let expected = directive(5, Pause, [0, 1, 2, 4, 5]);
        for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut known = Directive::default();
            for index in order {
                known.merge(MissionTime::START, &reported[index]);
            }
            assert_eq!(known, expected, "{order:?}");
            assert!(reported.iter().all(|old| !known.merge(MissionTime(9), old)), "nothing is news twice");
        }
    }

    #[test]
    fn orders_of_a_coordinator_whose_clock_is_behind_count_all_the_same() {
        let mut known = directive(1_000, Pause, []);
        known.give(7, Search);
        assert!(directive(1_000, Pause, []).merge(MissionTime(7), &known));
        assert_eq!(known.order, Search);
    }

    #[test]
    fn an_order_at_the_end_of_time_can_be_followed_by_another() {
        let last = directive(u64::MAX, Pause, []);
        let [mut coordinator, mut robot] = [Directive::default(), Directive::default()];
        assert!(coordinator.merge(MissionTime(5), &last) && robot.merge(MissionTime(3), &last));
        assert_eq!([coordinator.order, robot.order], [Pause; 2]);
        coordinator.give(7, Search);
        assert!(robot.merge(MissionTime(9), &coordinator));
        assert_eq!(robot.order, Search);
    }

    #[test]
    fn at_the_end_of_time_itself_no_number_follows() {
        let mut known = directive(u64::MAX, Pause, []);
        known.give(u64::MAX, Search);
        assert_eq!(known, directive(u64::MAX, Search, []));
    }
}
