//! Two processes with one participant's number: copied settings, or a robot that was started twice.
//!
//! Each process draws a random identity when it starts, which is part of its liveliness token and all its messages,
//! together with its age. Of two processes of one robot the younger one stops, and publishes nothing, as long as the
//! older one is present; every participant reports both. The token of a process that has died stays until the lease of
//! its session ends, and does not stop the process that replaces it for longer than [`SETTLING`].

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_proto::sender::Process;
use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;

use crate::log_limit::PERIOD;

/// Time within which the death of a process is detected: longer than the lease of Zenoh's sessions, ten seconds by
/// default.
pub(crate) const SETTLING: Duration = Duration::from_secs(12);
/// A process that has been on the network for longer than this meets no old tokens: those are there already when a
/// process starts.
const MEETING: Duration = Duration::from_secs(2);
/// Difference in age, as received, below which no process counts as older.
const MARGIN_MS: u64 = 1_000;

/// One participant's knowledge of such processes. Times are since it started.
#[derive(Debug, Default)]
pub(crate) struct Doubles {
    /// Older processes of this participant's own number.
    elders: BTreeSet<u64>,
    /// How long this process had been on the network when it met each other one of its number.
    met: BTreeMap<u64, Duration>,
    /// Since when a participant has two processes, and when that was last reported.
    reported: BTreeMap<Participant, (Duration, Option<Duration>)>,
}

/// A report about two processes of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum News {
    /// There are two: one may have died, and been restarted.
    Two,
    /// Both have been there for longer than a dead one would be; reported repeatedly.
    Both,
    /// There is one again.
    One,
}

impl Doubles {
    /// A message of another process of this one's own number has arrived.
    pub(crate) fn receive(&mut self, own: Process, rival: Process) {
        if is_older(rival, own) {
            self.elders.insert(rival.identity);
        }
    }

    /// Whether this process is to stop, as one of several of its number: `others` are those whose tokens are there.
    pub(crate) fn must_stand(&mut self, own: Process, others: &[u64]) -> bool {
        let age = Duration::from_millis(own.age_ms);
        self.met.retain(|other, _| others.contains(other));
        let may_have_died =
            |met: &mut Self, other| *met.met.entry(other).or_insert(age) < MEETING && age < SETTLING;
        others.iter().any(|&other| may_have_died(self, other) || self.elders.contains(&other))
    }

    /// When the next report is due, if no process joins or leaves.
    pub(crate) fn due(&self) -> Option<Duration> {
        self.reported
            .values()
            .map(|&(since, reported)| reported.map_or(since + SETTLING, |reported| reported + PERIOD))
            .min()
    }

    /// Robots that have had several processes for longer than a dead one would be among them.
    pub(crate) fn lasting(&self, now: Duration) -> BTreeSet<RobotId> {
        let lasting = self.reported.iter().filter(|(_, (since, _))| now >= *since + SETTLING);
        lasting
            .filter_map(|(&participant, _)| match participant {
                Participant::Robot(robot) => Some(robot),
                Participant::Coordinator => None,
            })
            .collect()
    }

    /// The reports that are due, given the participants with several processes now.
    pub(crate) fn tell(
        &mut self,
        now: Duration,
        doubled: &BTreeSet<Participant>,
    ) -> Vec<(Participant, News)> {
        let mut news = Vec::new();
        for &participant in doubled {
            let (since, reported) = self.reported.entry(participant).or_insert_with(|| {
                news.push((participant, News::Two));
                (now, None)
            });
            if now >= *since + SETTLING && reported.is_none_or(|reported| now >= reported + PERIOD) {
                *reported = Some(now);
                news.push((participant, News::Both));
            }
        }
        self.reported.retain(|participant, _| {
            let is_double = doubled.contains(participant);
            if !is_double {
                news.push((*participant, News::One));
            }
            is_double
        });
        news
    }
}

/// Of two processes that started together the one with the larger identity counts as older, for both.
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
        doubles[0].receive(process(old, 300), process(young, 20));
        doubles[1].receive(process(young, 20), process(old, 300));
        assert!(!doubles[0].must_stand(process(old, 300), &[young]));
        assert!(doubles[1].must_stand(process(young, 900), &[old]));
        assert!(!doubles[1].must_stand(process(young, 901), &[]));
        assert!(!doubles[1].must_stand(process(young, 902), &[9]), "another one that is younger");
    }

    #[test]
    fn a_new_process_waits_no_longer_than_the_token_of_a_dead_one_stands() {
        let mut doubles = Doubles::default();
        assert!(doubles.must_stand(process(3, 1), &[7]));
        assert!(doubles.must_stand(process(3, 11), &[7]));
        assert!(!doubles.must_stand(process(3, 12), &[7]));
    }

    #[test]
    fn a_later_process_stops_a_running_one_only_if_older() {
        let mut doubles = Doubles::default();
        assert!(!doubles.must_stand(process(3, 4), &[7]), "it may be younger");
        doubles.receive(process(3, 5), process(7, 1));
        assert!(!doubles.must_stand(process(3, 5), &[7]));
        assert!(!doubles.must_stand(process(3, 6), &[7, 9]));
        doubles.receive(process(3, 7), process(9, 300));
        assert!(doubles.must_stand(process(3, 7), &[7, 9]));
    }

    #[test]
    fn of_two_that_start_together_one_goes() {
        let stands = |own: u64, other: u64| {
            let mut doubles = Doubles::default();
            doubles.receive(process(own, 20), process(other, 20));
            doubles.must_stand(process(own, 20), &[other])
        };
        assert_ne!(stands(3, 7), stands(7, 3));
        assert!(!stands(u64::MAX, 3));
    }

    #[test]
    fn counts_are_due_after_suppressed_lines() {
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
    fn a_process_that_takes_over_is_older_than_all_others() {
        assert!(is_older(Process { identity: 1, age_ms: u64::MAX }, process(9, 1 << 40)));
    }

    #[test]
    fn two_processes_are_reported_at_once_then_each_minute_and_when_one_is_left() {
        let participant = Participant::Robot(RobotId::new(2).unwrap());
        let (mut doubles, two, none) = (Doubles::default(), BTreeSet::from([participant]), BTreeSet::new());
        let mut at = |seconds, doubled| doubles.tell(Duration::from_secs(seconds), doubled);
        assert_eq!(at(5, &none), []);
        assert_eq!(at(6, &two), [(participant, News::Two)]);
        assert_eq!(at(17, &two), []);
        assert_eq!(at(18, &two), [(participant, News::Both)]);
        assert_eq!(at(77, &two), []);
        assert_eq!(at(78, &two), [(participant, News::Both)]);
        assert_eq!(at(79, &none), [(participant, News::One)]);
        assert_eq!(at(80, &none), []);
    }
}
