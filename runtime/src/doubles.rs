//! Reports of two processes with one participant's number: copied settings, or a robot that was started twice.
//!
//! Every participant sees their liveliness tokens, and reports them. Which of them goes on is decided in
//! [`crate::contender`]. The token of a process that has died stays until the lease of its session ends: only two that
//! are there for longer than that are two robots of one number.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;

use crate::log_limit::PERIOD;

/// Time within which the death of a process is detected: longer than the lease of Zenoh's sessions, ten seconds by
/// default.
const SETTLING: Duration = Duration::from_secs(12);

/// One participant's knowledge of such processes. Times are since it started.
#[derive(Debug, Default)]
pub(crate) struct Doubles {
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

#[cfg(test)]
mod tests {
    use super::*;

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
