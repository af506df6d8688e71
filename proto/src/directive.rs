//! The directive: all commands of the operator so far except marks, gossiped by all participants.
//!
//! Every status of the coordinator and every heartbeat carries it, so that it also reaches robots without a connection
//! to the coordinator, and a restarted coordinator receives it from the robots. Merging is commutative and idempotent:
//! the newest pause or resumption counts, and added cells are never removed.

use std::collections::BTreeSet;
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;

/// An order dated later than this after its reception counts as dated so. No correct clock is as far ahead, and no
/// later order could follow one at the end of time.
pub(crate) const MOST_AHEAD: Duration = Duration::from_hours(365 * 24);

/// The operator's latest pause or resumption, and all added cells. The default contains neither.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Directive {
    /// When the search was last paused or resumed: nanoseconds of mission time, or one more than the number before if
    /// the coordinator's clock is behind; 0 if never.
    pub number: u64,
    /// Whether the robots are paused.
    pub is_paused: bool,
    /// Cells that the operator added to the search area.
    pub added: BTreeSet<Cell>,
}

impl Directive {
    /// Merges another participant's directive; returns whether anything changed.
    pub fn merge(&mut self, now: MissionTime, other: &Self) -> bool {
        if self == other {
            return false;
        }
        let order = (other.number.min((now + MOST_AHEAD).0), other.is_paused);
        let is_newer = order > self.order();
        if is_newer {
            (self.number, self.is_paused) = order;
        }
        let before = self.added.len();
        self.added.extend(&other.added);
        is_newer || self.added.len() > before
    }

    /// Pauses or resumes the search, as of a time in nanoseconds.
    pub fn order_pause(&mut self, time_ns: u64, is_paused: bool) {
        self.number = time_ns.max(self.number.saturating_add(1));
        self.is_paused = is_paused;
    }

    /// Of two simultaneous orders, the pause wins.
    const fn order(&self) -> (u64, bool) {
        (self.number, self.is_paused)
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

    use super::*;

    fn directive(number: u64, is_paused: bool, added: impl IntoIterator<Item = u32>) -> Directive {
        let grid = Grid::new(1, 9).unwrap();
        let added = added.into_iter().map(|number| grid.cell_numbered(number).unwrap()).collect();
        Directive { number, is_paused, added }
    }

    #[test]
    fn any_order_of_arrival_gives_the_same_directive() {
        let reported = [directive(5, true, 0..2), directive(5, false, 4..6), directive(3, false, 1..3)];
        let expected = directive(5, true, [0, 1, 2, 4, 5]);
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
        let mut known = directive(1_000, true, []);
        known.order_pause(7, false);
        assert!(directive(1_000, true, []).merge(MissionTime(7), &known));
        assert!(!known.is_paused);
    }

    #[test]
    fn an_order_at_the_end_of_time_can_be_followed_by_another() {
        let last = directive(u64::MAX, true, []);
        let [mut coordinator, mut robot] = [Directive::default(), Directive::default()];
        assert!(coordinator.merge(MissionTime(5), &last) && robot.merge(MissionTime(3), &last));
        assert!(coordinator.is_paused && robot.is_paused);
        coordinator.order_pause(7, false);
        assert!(robot.merge(MissionTime(9), &coordinator));
        assert!(!robot.is_paused);
    }

    #[test]
    fn at_the_end_of_time_itself_no_number_follows() {
        let mut known = directive(u64::MAX, true, []);
        known.order_pause(u64::MAX, false);
        assert_eq!(known, directive(u64::MAX, false, []));
    }
}
