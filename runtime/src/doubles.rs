//! Two processes that say that they are one: copied settings, or a robot that somebody started a second time.
//!
//! Each process draws an identity when it starts, which its liveliness token and all that it says bear, and says for how
//! long it has run. Of two processes of one robot the younger one stands, and says nothing, as long as the older one is
//! there; every participant tells of both. The token of a process that has died stands until the lease of its session
//! ends, and does not keep the one that is started in its place from moving for longer than [`SETTLING`].

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_proto::sender::Process;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;

use crate::log_limit::PERIOD;

/// A process that has died is known to be gone within this time: longer than the lease of Zenoh's sessions, ten seconds
/// unless the settings say otherwise.
pub(crate) const SETTLING: Duration = Duration::from_secs(12);
/// Whoever has been on the network for longer than this meets no token of a process that has died before it: it is there
/// already when a process starts.
const MEETING: Duration = Duration::from_secs(2);
/// Who has run for longer than another by less than this, as far as is heard, is not known to be older.
const MARGIN_MS: u64 = 1_000;

/// What one participant knows of such processes. Times are since it started.
#[derive(Debug, Default)]
pub(crate) struct Doubles {
    /// Processes of this participant's own number that are older than this one.
    elders: BTreeSet<u64>,
    /// How long this process had been on the network when it met each other one of its number.
    met: BTreeMap<u64, Duration>,
    /// Since when there are two of somebody, and when it was told last.
    told: BTreeMap<Participant, (Duration, Option<Duration>)>,
}

/// What to tell of two processes of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum News {
    /// There are two: one may have died, and started again.
    Two,
    /// Both are there for longer than one that has died would be; told again and again.
    Both,
    /// There is one again.
    One,
}

impl Doubles {
    /// Another process of this one's own number has spoken.
    pub(crate) fn hear(&mut self, own: Process, rival: Process) {
        if is_older(rival, own) {
            self.elders.insert(rival.identity);
        }
    }

    /// Whether this process is to stand, as it is one of several of its number: the others, whose tokens are there.
    pub(crate) fn must_stand(&mut self, own: Process, others: &[u64]) -> bool {
        let age = Duration::from_millis(own.age_ms);
        self.met.retain(|other, _| others.contains(other));
        let may_have_died =
            |met: &mut Self, other| *met.met.entry(other).or_insert(age) < MEETING && age < SETTLING;
        others.iter().any(|&other| may_have_died(self, other) || self.elders.contains(&other))
    }

    /// When there is something to tell of those that are there, if nobody comes or leaves.
    pub(crate) fn due(&self) -> Option<Duration> {
        self.told.values().map(|&(since, told)| told.map_or(since + SETTLING, |told| told + PERIOD)).min()
    }

    /// Those that have several processes for longer than one that has died would be among them.
    pub(crate) fn lasting(&self, now: Duration) -> BTreeSet<RobotId> {
        let lasting = self.told.iter().filter(|(_, (since, _))| now >= *since + SETTLING);
        lasting
            .filter_map(|(&who, _)| match who {
                Participant::Robot(robot) => Some(robot),
                Participant::Coordinator => None,
            })
            .collect()
    }

    /// What is to be told, where these have several processes now.
    pub(crate) fn tell(
        &mut self,
        now: Duration,
        doubled: &BTreeSet<Participant>,
    ) -> Vec<(Participant, News)> {
        let mut news = Vec::new();
        for &who in doubled {
            let (since, told) = self.told.entry(who).or_insert_with(|| {
                news.push((who, News::Two));
                (now, None)
            });
            if now >= *since + SETTLING && told.is_none_or(|told| now >= told + PERIOD) {
                *told = Some(now);
                news.push((who, News::Both));
            }
        }
        self.told.retain(|who, _| {
            let is_double = doubled.contains(who);
            if !is_double {
                news.push((*who, News::One));
            }
            is_double
        });
        news
    }
}

/// Of two that started together the one of the larger identity counts as older, for both.
fn is_older(one: Process, other: Process) -> bool {
    if one.age_ms.abs_diff(other.age_ms) >= MARGIN_MS {
        one.age_ms > other.age_ms
    } else {
        one.identity > other.identity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn process(identity: u64, age_seconds: u64) -> Process {
        Process { identity, age_ms: age_seconds * 1000 }
    }

    #[test]
    fn of_two_the_younger_one_stands_until_the_older_one_is_gone() {
        let (old, young) = (7, 3);
        let mut doubles = [Doubles::default(), Doubles::default()];
        doubles[0].hear(process(old, 300), process(young, 20));
        doubles[1].hear(process(young, 20), process(old, 300));
        assert!(!doubles[0].must_stand(process(old, 300), &[young]));
        assert!(doubles[1].must_stand(process(young, 900), &[old]));
        assert!(!doubles[1].must_stand(process(young, 901), &[]));
        assert!(!doubles[1].must_stand(process(young, 902), &[9]), "another one that is younger");
    }

    #[test]
    fn whoever_starts_waits_no_longer_for_a_process_than_a_dead_ones_token_stands() {
        let mut doubles = Doubles::default();
        assert!(doubles.must_stand(process(3, 1), &[7]));
        assert!(doubles.must_stand(process(3, 11), &[7]));
        assert!(!doubles.must_stand(process(3, 12), &[7]));
    }

    #[test]
    fn whoever_comes_while_a_process_runs_stops_it_only_by_being_older() {
        let mut doubles = Doubles::default();
        assert!(!doubles.must_stand(process(3, 4), &[7]), "it may be younger");
        doubles.hear(process(3, 5), process(7, 1));
        assert!(!doubles.must_stand(process(3, 5), &[7]));
        assert!(!doubles.must_stand(process(3, 6), &[7, 9]));
        doubles.hear(process(3, 7), process(9, 300));
        assert!(doubles.must_stand(process(3, 7), &[7, 9]));
    }

    #[test]
    fn of_two_that_start_together_one_goes() {
        let stands = |own: u64, other: u64| {
            let mut doubles = Doubles::default();
            doubles.hear(process(own, 20), process(other, 20));
            doubles.must_stand(process(own, 20), &[other])
        };
        assert_ne!(stands(3, 7), stands(7, 3));
        assert!(!stands(u64::MAX, 3));
    }

    #[test]
    fn it_is_time_to_tell_again_when_something_is_told() {
        let two = BTreeSet::from([Participant::Robot(RobotId::new(2).unwrap())]);
        let (mut doubles, second) = (Doubles::default(), Duration::from_secs(1));
        assert_eq!(doubles.due(), None);
        doubles.tell(second, &two);
        for _ in 0..3 {
            let due = doubles.due().unwrap();
            assert!(doubles.tell(due.saturating_sub(second), &two).is_empty());
            assert_eq!(doubles.tell(due, &two).len(), 1);
        }
    }

    #[test]
    fn only_two_that_stay_are_lasting() {
        let (robot, mut doubles) = (RobotId::new(2).unwrap(), Doubles::default());
        let two = BTreeSet::from([Participant::Robot(robot)]);
        let mut at = |seconds, doubled| {
            let now = Duration::from_secs(seconds);
            doubles.tell(now, doubled);
            doubles.lasting(now)
        };
        assert_eq!(at(5, &two), BTreeSet::new());
        assert_eq!(at(16, &two), BTreeSet::new());
        assert_eq!(at(17, &two), BTreeSet::from([robot]));
        assert_eq!(at(18, &BTreeSet::new()), BTreeSet::new());
    }

    #[test]
    fn whoever_is_to_take_over_is_older_than_all_that_have_run() {
        assert!(is_older(Process { identity: 1, age_ms: u64::MAX }, process(9, 1 << 40)));
    }

    #[test]
    fn two_are_told_at_once_then_that_neither_was_dead_each_minute_and_that_one_is_left() {
        let who = Participant::Robot(RobotId::new(2).unwrap());
        let (mut doubles, two, none) = (Doubles::default(), BTreeSet::from([who]), BTreeSet::new());
        let mut at = |seconds, doubled| doubles.tell(Duration::from_secs(seconds), doubled);
        assert_eq!(at(5, &none), []);
        assert_eq!(at(6, &two), [(who, News::Two)]);
        assert_eq!(at(17, &two), []);
        assert_eq!(at(18, &two), [(who, News::Both)]);
        assert_eq!(at(77, &two), []);
        assert_eq!(at(78, &two), [(who, News::Both)]);
        assert_eq!(at(79, &none), [(who, News::One)]);
        assert_eq!(at(80, &none), []);
    }
}
