//! Checks whether the clocks of a mission agree.
//!
//! The mission times in messages ([`dragnet_proto::clock`]) are compared with each other, and with the time at which
//! the robot itself would continue by its journal. Dates of computers are not compared: no message contains one, and
//! nothing in the search depends on it.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;

use super::Finding;

/// Time below which the rate of a clock cannot be measured.
const SPAN: Duration = Duration::from_secs(2);
/// Factor by which the rate of a clock may seem wrong because of network delays.
const FACTOR: f64 = 3.0;

/// A received mission time, and when: since listening began.
#[derive(Clone, Copy, Debug)]
struct Moment {
    at: Duration,
    time: MissionTime,
}

/// The received mission times.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    /// The first and the last of each participant.
    reported: BTreeMap<Participant, [Moment; 2]>,
}

/// The expected values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// The robot of the settings.
    pub(super) me: Participant,
    /// The time at which it would have continued when listening began, by its journal, if that is not in use.
    pub(super) resumed: Option<MissionTime>,
    /// Mission seconds per second.
    pub(super) real_time_factor: f64,
    /// The allowed clock skew.
    pub(super) tolerance: Duration,
}

impl Clocks {
    /// A participant has sent a time. Delayed messages are ignored.
    pub(super) fn receive(&mut self, participant: Participant, at: Duration, time: MissionTime) {
        let moment = Moment { at, time };
        let [_, last] = self.reported.entry(participant).or_insert([moment; 2]);
        if time >= last.time {
            *last = moment;
        }
    }

    /// Whether no time was received.
    pub(super) fn is_empty(&self) -> bool {
        self.reported.is_empty()
    }

    pub(super) fn findings(&self, expected: Expected) -> Vec<Finding> {
        let Some(oldest) = self.oldest(expected.real_time_factor) else { return Vec::new() };
        let paces = self.reported.iter().filter_map(|(&participant, &moments)| {
            real_time_factor(participant, moments, expected.real_time_factor)
        });
        paces.chain(self.apart(expected)).chain([own(oldest, expected)].into_iter().flatten()).collect()
    }

    /// Mission time when listening began, by the last message of each.
    fn begun(&self, real_time_factor: f64) -> impl Iterator<Item = (Participant, f64)> + '_ {
        let begun =
            move |moment: Moment| moment.time.as_seconds() - real_time_factor * moment.at.as_secs_f64();
        self.reported.iter().map(move |(&participant, &[_, last])| (participant, begun(last)))
    }

    /// The participant with the longest time.
    fn oldest(&self, real_time_factor: f64) -> Option<(Participant, f64)> {
        self.begun(real_time_factor).max_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// All connected participants have the same time; observations that one dates in another's future are not accepted
    /// yet.
    fn apart(&self, expected: Expected) -> Option<Finding> {
        if self.reported.len() < 2 {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        self.begun(expected.real_time_factor)
            .for_each(|(_, seconds)| (low, high) = (low.min(seconds), high.max(seconds)));
        let (apart, tolerance) = (high - low, expected.tolerance_seconds());
        let names: Vec<String> = self.reported.keys().map(ToString::to_string).collect();
        let found = format!("those of {} are {apart:.1} s apart; {tolerance:.0} s will do", names.join(", "));
        Some(if apart <= tolerance {
            Finding::pass("clocks", found)
        } else {
            let advice = "they agree as soon as they are connected: check that each pair has a connection";
            Finding::fail("clocks", found, advice)
        })
    }
}

impl Expected {
    /// A message's delay corresponds to more mission time if that passes faster.
    fn tolerance_seconds(self) -> f64 {
        self.tolerance.as_secs_f64() * self.real_time_factor.max(1.0)
    }
}

/// A participant with another real-time factor soon has another time, even if it is adjusted often.
fn real_time_factor(
    participant: Participant,
    [first, last]: [Moment; 2],
    real_time_factor: f64,
) -> Option<Finding> {
    let span = last.at.saturating_sub(first.at);
    let passed = last.time.since(first.time).as_secs_f64();
    let rate = passed / span.as_secs_f64();
    // Before a mission begins its time stands still.
    if span < SPAN || passed == 0.0 || (real_time_factor / FACTOR..=real_time_factor * FACTOR).contains(&rate)
    {
        return None;
    }
    let span = span.as_secs_f64();
    let found = format!(
        "of {participant} {passed:.0} s passed in {span:.1} s; by `common.real_time_factor` here it is {real_time_factor} s a second"
    );
    let advice =
        "give all the same real_time_factor; a clock that was just set forward is well when you ask again";
    Some(Finding::fail("clocks", found, advice))
}

/// Compares the time at which the robot would continue with that of the participant with the longest time: a shorter
/// one is set forward with the first message; a longer one would set forward all others.
fn own((participant, begun): (Participant, f64), expected: Expected) -> Option<Finding> {
    let Expected { me, resumed, .. } = expected;
    if participant == me {
        return None;
    }
    let Some(resumed) = resumed else {
        let found =
            format!("the mission is {begun:.0} s old by the clock of {participant}, which {me} adopts");
        return Some(Finding::pass("clocks", found));
    };
    let resumed = resumed.as_seconds();
    let found = format!(
        "by the journal of {me} the mission is {resumed:.0} s old, by the clock of {participant} {begun:.0} s"
    );
    if resumed <= begun + expected.tolerance_seconds() {
        let set = begun - resumed;
        let set = if set < 1.0 { String::new() } else { format!("; it is set {set:.0} s forward at once") };
        return Some(Finding::pass("clocks", format!("{found}{set}")));
    }
    let advice = "the others would set their clocks forward to it: if the journal is of an earlier search, move it away";
    Some(Finding::fail("clocks", found, advice))
}

#[cfg(test)]
mod tests {
    use dragnet_search::observation::RobotId;

    use super::*;
    use crate::mentions::assert_mentions;

    const ME: Participant = Participant::Robot(RobotId::FIRST);
    const MATE: Participant = Participant::Robot(RobotId::new(2).unwrap());

    const fn expected(resumed: Option<u64>) -> Expected {
        let resumed = match resumed {
            Some(seconds) => Some(MissionTime(seconds * 1_000_000_000)),
            None => None,
        };
        Expected { me: ME, resumed, real_time_factor: 1.0, tolerance: Duration::from_mins(1) }
    }

    fn check(reported: &[(Participant, u64, u64)], expected: Expected, lines: &[&str]) {
        let mut clocks = Clocks::default();
        for &(participant, at, seconds) in reported {
            clocks.receive(participant, Duration::from_secs(at), MissionTime(seconds * 1_000_000_000));
        }
        let found: Vec<String> = clocks.findings(expected).iter().map(ToString::to_string).collect();
        assert_eq!(found.len(), lines.len(), "{found:?}");
        for (found, line) in found.iter().zip(lines) {
            assert_mentions(found, line);
        }
    }

    #[test]
    fn a_journal_is_held_against_the_only_one_that_is_there() {
        let reported = [(MATE, 3, 503)];
        check(&[], expected(Some(500)), &[]);
        check(&reported, expected(None), &["pass .. clocks .. 500 s .. robot 2"]);
        check(&reported, expected(Some(560)), &["pass .. clocks .. journal of robot 1"]);
        check(&reported, expected(Some(561)), &["FAIL .. clocks .. journal of robot 1 .. 561 s"]);
        let behind = "pass .. clocks .. journal of robot 1 .. 100 s .. robot 2 .. 500 s .. 400 s";
        check(&reported, expected(Some(100)), &[behind]);
    }

    #[test]
    fn participants_are_compared_with_the_others_and_the_robot_itself_if_it_runs() {
        let other = Participant::Coordinator;
        let agree = "pass .. clocks .. robot 1, robot 2 .. 1.0 s .. 60 s";
        check(&[(ME, 1, 401), (MATE, 2, 401)], expected(None), &[agree]);
        let apart = "FAIL .. clocks .. robot 2, the coordinator .. 390.0 s";
        let own = "pass .. clocks .. 400 s .. the coordinator";
        check(&[(MATE, 1, 11), (other, 1, 401)], expected(None), &[apart, own]);
    }

    #[test]
    fn another_real_time_factor_is_reported_and_a_standing_time_is_none() {
        let own = "pass .. clocks";
        check(&[(MATE, 0, 7), (MATE, 4, 7)], expected(None), &[own]);
        check(&[(MATE, 0, 7), (MATE, 4, 12)], expected(None), &[own]);
        check(&[(MATE, 0, 7), (MATE, 1, 107)], expected(None), &[own]);
        check(
            &[(MATE, 0, 7), (MATE, 4, 407)],
            expected(None),
            &["FAIL .. clocks .. robot 2 .. 400 s .. 4.0 s", own],
        );
        check(
            &[(MATE, 0, 7), (MATE, 9, 9)],
            expected(None),
            &["FAIL .. clocks .. robot 2 .. 2 s .. 9.0 s", own],
        );
    }
}
