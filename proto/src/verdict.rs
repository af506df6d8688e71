//! Verdicts: what the operator has decided about finds, gossiped by all participants.
//!
//! A verdict is evidence of the operator. It is a number that is added to the log-odds of its cell beside the readings, so that
//! readings count as before and undoing it restores what they say. Of two verdicts on one cell the newer one counts.
//! Merging is commutative and idempotent: equal readings and equal verdicts give equal beliefs, in any order of arrival.
//!
//! Every participant that knows a verdict publishes all that it knows beside its heartbeats, so that they also reach
//! robots without a connection to the coordinator, robots that join late, and a restarted coordinator. What a robot
//! publishes acknowledges what it has received.

use std::collections::BTreeMap;

use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::{CellEvidence, UNITS};

use crate::directive::MOST_AHEAD;

/// A decision of the operator about a find. Of two simultaneous ones the greater counts: a find that one operator
/// confirms is not lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Decision {
    /// An earlier decision is withdrawn: the readings alone count.
    Undone,
    /// No object is there.
    Dismissed,
    /// An object is there.
    Confirmed,
}

impl Decision {
    /// All decisions.
    pub const ALL: [Self; 3] = [Self::Undone, Self::Dismissed, Self::Confirmed];

    /// Its number in messages.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Undone => 0,
            Self::Dismissed => 1,
            Self::Confirmed => 2,
        }
    }

    /// The decision with this number in messages, if there is one.
    #[must_use]
    pub fn numbered(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|decision| decision.number() == number)
    }

    /// The decision in one word; `None` if it is undone.
    #[must_use]
    pub const fn word(self) -> Option<&'static str> {
        match self {
            Self::Undone => None,
            Self::Dismissed => Some("dismissed"),
            Self::Confirmed => Some("confirmed"),
        }
    }
}

/// The operator's last decision about a find. The order of its fields is the order in which verdicts count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Verdict {
    /// When it was made: nanoseconds of mission time, or one more than that of the verdict before if the coordinator's
    /// clock is behind.
    pub number: u64,
    /// The decision.
    pub decision: Decision,
    /// What it adds to the log-odds of its cell, units of 1/65,536 nats: see [`Verdict::allows`].
    pub log_odds_units: i64,
}

impl Verdict {
    /// What a confirmation adds. A reading adds less than 2^46, so that only tens of thousands of the most extreme
    /// readings could withdraw the find.
    pub const CONFIRMED_UNITS: i64 = 1 << 61;
    /// A dismissed cell is this much less likely to hold an object than before the search, nats: its odds are 3000 times
    /// lower, as after a search that misses one object in 3000.
    pub const DISMISSED_NATS: f64 = 8.0;

    /// Whether a decision may add this: nothing if it is undone, [`Verdict::CONFIRMED_UNITS`] for a confirmation, and at
    /// most as much in the other direction for a dismissal.
    #[must_use]
    pub fn allows(decision: Decision, log_odds_units: i64) -> bool {
        match decision {
            Decision::Undone => log_odds_units == 0,
            Decision::Dismissed => (-Self::CONFIRMED_UNITS..0).contains(&log_odds_units),
            Decision::Confirmed => log_odds_units == Self::CONFIRMED_UNITS,
        }
    }

    /// When it was made.
    #[must_use]
    pub const fn time(self) -> MissionTime {
        MissionTime(self.number)
    }
}

/// The verdicts that a participant knows, by cell. The default contains none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Verdicts(BTreeMap<Cell, Verdict>);

impl Verdicts {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The number of verdicts, undone ones included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// All verdicts, by cell.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Cell, Verdict)> + '_ {
        self.0.iter().map(|(&cell, &verdict)| (cell, verdict))
    }

    /// The verdict on a cell, if there is one.
    #[must_use]
    pub fn of(&self, cell: Cell) -> Option<Verdict> {
        self.0.get(&cell).copied()
    }

    /// The decision about a cell, unless it was undone.
    #[must_use]
    pub fn decision(&self, cell: Cell) -> Option<Decision> {
        self.of(cell).map(|verdict| verdict.decision).filter(|&decision| decision != Decision::Undone)
    }

    /// Whether this verdict, or a newer one on its cell, is known.
    #[must_use]
    pub fn includes(&self, cell: Cell, verdict: Verdict) -> bool {
        self.of(cell).is_some_and(|known| known >= verdict)
    }

    /// These verdicts and, as of a time in nanoseconds, a new one. `belief` is the belief with these verdicts: a dismissed
    /// object is as unlikely as [`Verdict::DISMISSED_NATS`] says, however much the readings so far spoke for it.
    #[must_use]
    pub fn with(&self, time_ns: u64, cell: Cell, decision: Decision, belief: &Belief) -> Self {
        let known = self.of(cell);
        let log_odds_units = match decision {
            Decision::Undone => 0,
            Decision::Dismissed => dismissal_units(cell, belief, known),
            Decision::Confirmed => Verdict::CONFIRMED_UNITS,
        };
        let number = time_ns.max(known.map_or(0, |known| known.number.saturating_add(1)));
        let mut verdicts = self.clone();
        verdicts.0.insert(cell, Verdict { number, decision, log_odds_units });
        verdicts
    }

    /// Merges the verdicts of another participant, and adds the changes to the belief; returns the cells with a new
    /// verdict. One dated too far ahead of its reception counts as dated earlier, as in
    /// [`crate::directive::Directive::merge`].
    pub fn merge(&mut self, now: MissionTime, other: &Self, belief: &mut Belief) -> Vec<Cell> {
        let most = (now + MOST_AHEAD).0;
        self.take(
            other.iter().map(|(cell, it)| (cell, Verdict { number: it.number.min(most), ..it })),
            belief,
        )
    }

    /// Merges verdicts that another participant has already merged, as in a recording; see [`Verdicts::merge`].
    pub fn take(
        &mut self,
        other: impl IntoIterator<Item = (Cell, Verdict)>,
        belief: &mut Belief,
    ) -> Vec<Cell> {
        let mut changed = Vec::new();
        for (cell, verdict) in other {
            if self.includes(cell, verdict) {
                continue;
            }
            let before = self.0.insert(cell, verdict).map_or(0, |before| before.log_odds_units);
            let weighted_sum = verdict.log_odds_units - before;
            belief.add_evidence(cell, CellEvidence { precision: 0, weighted_sum });
            changed.push(cell);
        }
        changed
    }
}

impl FromIterator<(Cell, Verdict)> for Verdicts {
    fn from_iter<I: IntoIterator<Item = (Cell, Verdict)>>(verdicts: I) -> Self {
        Self(verdicts.into_iter().collect())
    }
}

/// What leaves the log-odds of a cell at the prior less [`Verdict::DISMISSED_NATS`]. A prior above even odds, which alone
/// could declare an object, counts as even odds; readings against the object stay.
#[expect(clippy::cast_possible_truncation, reason = "saturates, and is clamped")]
fn dismissal_units(cell: Cell, belief: &Belief, known: Option<Verdict>) -> i64 {
    let mut readings = belief.evidence().of(cell);
    readings.weighted_sum =
        readings.weighted_sum.saturating_sub(known.map_or(0, |known| known.log_odds_units));
    let against = readings.log_likelihood_ratio_nats().max(0.0) + belief.prior_log_odds_nats(cell).max(0.0);
    let units = (against + Verdict::DISMISSED_NATS) * UNITS;
    -(units.ceil() as i64).min(Verdict::CONFIRMED_UNITS)
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;
    use dragnet_search::evidence::Reading;
    use dragnet_search::terrain::Terrain;
    use proptest::prelude::*;

    use super::*;

    const TAU: f64 = 0.95;

    fn cell(number: u32) -> Cell {
        Grid::new(1, 4).unwrap().cell_numbered(number).unwrap()
    }

    fn belief() -> Belief {
        Belief::uniform(&Terrain::from_ascii("....", 1.0).unwrap(), 0.1).unwrap()
    }

    fn reading(value: f32) -> Reading {
        Reading { cell: cell(1), value, variance: 0.05 }
    }

    /// The belief of an operator, and verdicts as they are given.
    #[derive(Clone)]
    struct Desk {
        belief: Belief,
        verdicts: Verdicts,
        now: MissionTime,
    }

    impl Desk {
        fn new() -> Self {
            Self { belief: belief(), verdicts: Verdicts::default(), now: MissionTime(9) }
        }

        fn give(&mut self, time_ns: u64, cell: Cell, decision: Decision) {
            let verdicts = self.verdicts.with(time_ns, cell, decision, &self.belief);
            self.receive(&verdicts);
        }

        fn receive(&mut self, verdicts: &Verdicts) -> Vec<Cell> {
            self.now = MissionTime(self.now.0 + 1);
            self.verdicts.merge(self.now, verdicts, &mut self.belief)
        }

        fn nats(&self) -> f64 {
            self.belief.log_odds_nats(cell(1))
        }
    }

    #[test]
    fn a_confirmed_find_stays_and_a_dismissed_one_needs_new_evidence() {
        let mut desk = Desk::new();
        let prior = desk.nats();
        desk.belief.add(&reading(1.0));
        let read = desk.nats();
        assert!(desk.belief.is_found(cell(1), TAU));

        desk.give(1, cell(1), Decision::Confirmed);
        (0..1000).for_each(|_| desk.belief.add(&reading(0.0)));
        assert!(desk.belief.is_found(cell(1), TAU), "no readings withdraw it");
        (0..1000).for_each(|_| desk.belief.add(&reading(1.0)));

        desk.give(2, cell(1), Decision::Dismissed);
        assert!((desk.nats() - (prior - Verdict::DISMISSED_NATS)).abs() < 1e-4, "{}", desk.nats());
        desk.belief.add(&reading(1.0));
        assert!(!desk.belief.is_found(cell(1), TAU));
        desk.belief.add(&reading(1.0));
        assert!(desk.belief.is_found(cell(1), TAU), "new evidence warrants it");
        (0..2).for_each(|_| desk.belief.add(&reading(0.0)));

        desk.give(3, cell(1), Decision::Undone);
        assert!((desk.nats() - read).abs() < 1e-9, "what the readings say");
        assert_eq!(desk.verdicts.decision(cell(1)), None);
    }

    #[test]
    fn a_find_that_was_likely_from_the_start_can_be_dismissed_again_and_again() {
        let mut desk = Desk::new();
        desk.belief = Belief::uniform(&Terrain::from_ascii("....", 1.0).unwrap(), 1.0 - 1e-12).unwrap();
        for time in 1..4 {
            desk.give(time, cell(1), Decision::Dismissed);
            assert!((desk.nats() + Verdict::DISMISSED_NATS).abs() < 1e-4, "{}", desk.nats());
            desk.belief.add(&reading(1.0));
            desk.belief.add(&reading(1.0));
            assert!(desk.belief.is_found(cell(1), TAU));
        }
    }

    #[test]
    fn a_verdict_of_a_coordinator_whose_clock_is_behind_counts_all_the_same() {
        let mut first = Desk::new();
        first.give(1000, cell(0), Decision::Confirmed);
        let mut second = Desk::new();
        second.receive(&first.verdicts);
        second.give(7, cell(0), Decision::Undone);
        assert_eq!(first.receive(&second.verdicts), [cell(0)]);
        assert_eq!(first.belief.digest(), belief().digest());
    }

    #[test]
    fn a_verdict_from_the_end_of_time_can_be_followed_by_another() {
        let last = Verdict {
            number: u64::MAX,
            decision: Decision::Confirmed,
            log_odds_units: Verdict::CONFIRMED_UNITS,
        };
        let mut desk = Desk::new();
        desk.receive(&[(cell(0), last)].into_iter().collect());
        desk.give(1, cell(0), Decision::Dismissed);
        assert_eq!(desk.verdicts.decision(cell(0)), Some(Decision::Dismissed));
    }

    #[test]
    fn a_decision_adds_only_what_it_may() {
        let most = Verdict::CONFIRMED_UNITS;
        let allowed = Decision::ALL.map(|decision| {
            [i64::MIN, -most - 1, -most, -1, 0, 1, most, most + 1]
                .into_iter()
                .filter(|&units| Verdict::allows(decision, units))
                .collect::<Vec<_>>()
        });
        assert_eq!(allowed, [vec![0], vec![-most, -1], vec![most]]);
    }

    proptest! {
        #[test]
        fn any_order_of_arrival_gives_the_same_verdicts_and_belief(
            given in prop::collection::vec((0_u32..4, 0_usize..3, 0_u64..6, any::<bool>()), 1..12),
            seed: u64,
        ) {
            // Two operators, who do not always know of each other.
            let mut desks = [Desk::new(), Desk::new()];
            let mut published = Vec::new();
            for (at, (number, decision, time, is_first)) in (1_u32..).zip(given) {
                let desk = &mut desks[usize::from(is_first)];
                desk.belief.add(&Reading { value: at as f32 / 4.0, ..reading(1.0) });
                desk.give(time, cell(number), Decision::ALL[decision]);
                published.push(desk.verdicts.clone());
            }
            let mut expected = Desk::new();
            for verdicts in &published {
                expected.receive(verdicts);
            }
            let mut other = Desk::new();
            let start = usize::try_from(seed % 100).unwrap() % published.len();
            published.rotate_left(start);
            for verdicts in published.iter().rev() {
                other.receive(verdicts);
            }
            prop_assert!(published.iter().all(|it| other.receive(it).is_empty()), "nothing is news twice");
            prop_assert_eq!(&other.verdicts, &expected.verdicts);
            prop_assert_eq!(other.belief.digest(), expected.belief.digest());
        }
    }
}
