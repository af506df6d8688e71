//! Do the clocks of a mission agree?
//!
//! What is compared is the mission's time, which every message tells ([`dragnet_proto::clock`]): that of each who is there
//! with that of the others, and with the time that the robot itself would go on at by its journal. Dates of computers are
//! not: no message tells one, and nothing in the search depends on it.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;

use super::Finding;

/// Over less than this nobody knows how fast somebody's time passes.
const SPAN: Duration = Duration::from_secs(2);
/// By such a factor a time that is heard over a network may seem to pass faster or slower.
const FACTOR: f64 = 3.0;

/// A mission time that was told, and when: since somebody began to listen.
#[derive(Clone, Copy, Debug)]
struct Moment {
    at: Duration,
    time: MissionTime,
}

/// What was heard of the mission's time.
#[derive(Debug, Default)]
pub(super) struct Clocks {
    /// Of each the first moment and the last.
    told: BTreeMap<Participant, [Moment; 2]>,
}

/// By what it is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    /// The robot whose settings they are.
    pub(super) me: Participant,
    /// The time that it would have gone on at when listening began, by its journal, if it has one that it does not hold.
    pub(super) resumed: Option<MissionTime>,
    /// Mission seconds a second.
    pub(super) real_time_factor: f64,
    /// So far apart they may be.
    pub(super) tolerance: Duration,
}

impl Clocks {
    /// Somebody has told the time. What comes late tells nothing.
    pub(super) fn hear(&mut self, who: Participant, at: Duration, time: MissionTime) {
        let moment = Moment { at, time };
        let [_, last] = self.told.entry(who).or_insert([moment; 2]);
        if time >= last.time {
            *last = moment;
        }
    }

    /// Whether nobody has told the time.
    pub(super) fn is_empty(&self) -> bool {
        self.told.is_empty()
    }

    pub(super) fn findings(&self, expected: Expected) -> Vec<Finding> {
        let Some(oldest) = self.oldest(expected.real_time_factor) else { return Vec::new() };
        let paces = self
            .told
            .iter()
            .filter_map(|(&who, &moments)| real_time_factor(who, moments, expected.real_time_factor));
        paces.chain(self.apart(expected)).chain([own(oldest, expected)].into_iter().flatten()).collect()
    }

    /// Seconds into the mission when listening began, by what each has told last.
    fn begun(&self, real_time_factor: f64) -> impl Iterator<Item = (Participant, f64)> + '_ {
        let begun =
            move |moment: Moment| moment.time.as_seconds() - real_time_factor * moment.at.as_secs_f64();
        self.told.iter().map(move |(&who, &[_, last])| (who, begun(last)))
    }

    /// Who counts the longest time.
    fn oldest(&self, real_time_factor: f64) -> Option<(Participant, f64)> {
        self.begun(real_time_factor).max_by(|one, other| one.1.total_cmp(&other.1))
    }

    /// All who hear each other count the same time; what one dates in another's future is not taken yet.
    fn apart(&self, expected: Expected) -> Option<Finding> {
        if self.told.len() < 2 {
            return None;
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        self.begun(expected.real_time_factor)
            .for_each(|(_, seconds)| (low, high) = (low.min(seconds), high.max(seconds)));
        let (apart, tolerance) = (high - low, expected.tolerance_seconds());
        let names: Vec<String> = self.told.keys().map(ToString::to_string).collect();
        let found = format!("those of {} are {apart:.1} s apart; {tolerance:.0} s will do", names.join(", "));
        Some(if apart <= tolerance {
            Finding::pass("clocks", found)
        } else {
            let advice = "they agree as soon as they hear each other: see that each pair has a connection";
            Finding::fail("clocks", found, advice)
        })
    }
}

impl Expected {
    /// What is on its way for a moment is old by more, where time passes faster.
    fn tolerance_seconds(self) -> f64 {
        self.tolerance.as_secs_f64() * self.real_time_factor.max(1.0)
    }
}

/// A participant with another real-time factor is in another time soon, however often it is told the right one.
fn real_time_factor(who: Participant, [first, last]: [Moment; 2], real_time_factor: f64) -> Option<Finding> {
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
        "of {who} {passed:.0} s passed in {span:.1} s; by `common.real_time_factor` here it is {real_time_factor} s a second"
    );
    let advice =
        "give all the same real_time_factor; a clock that was just set forward is well when you ask again";
    Some(Finding::fail("clocks", found, advice))
}

/// The time that the robot would go on at, beside that of the one who counts the longest: a shorter one is set forward
/// with the first message; a longer one would set forward all others.
fn own((who, begun): (Participant, f64), expected: Expected) -> Option<Finding> {
    let Expected { me, resumed, .. } = expected;
    if who == me {
        return None;
    }
    let Some(resumed) = resumed else {
        let found = format!("the mission is {begun:.0} s old, as {who} says, and {me} takes that up");
        return Some(Finding::pass("clocks", found));
    };
    let resumed = resumed.as_seconds();
    let found =
        format!("by the journal of {me} the mission is {resumed:.0} s old, as {who} says {begun:.0} s");
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

    const ME: Participant = Participant::Robot(RobotId::FIRST);
    const MATE: Participant = Participant::Robot(RobotId::new(2).unwrap());

    const fn expected(resumed: Option<u64>) -> Expected {
        let resumed = match resumed {
            Some(seconds) => Some(MissionTime(seconds * 1_000_000_000)),
            None => None,
        };
        Expected { me: ME, resumed, real_time_factor: 1.0, tolerance: Duration::from_mins(1) }
    }

    fn check(told: &[(Participant, u64, u64)], expected: Expected, lines: &[&str]) {
        let mut clocks = Clocks::default();
        for &(who, at, seconds) in told {
            clocks.hear(who, Duration::from_secs(at), MissionTime(seconds * 1_000_000_000));
        }
        let found: Vec<String> = clocks.findings(expected).iter().map(ToString::to_string).collect();
        assert_eq!(found.len(), lines.len(), "{found:?}");
        assert!(found.iter().zip(lines).all(|(found, line)| found.starts_with(line)), "{found:?}");
    }

    #[test]
    fn a_journal_is_held_against_the_only_one_that_is_there() {
        let told = [(MATE, 3, 503)];
        check(&[], expected(Some(500)), &[]);
        check(&told, expected(None), &["pass  clocks: the mission is 500 s old, as robot 2 says"]);
        check(&told, expected(Some(560)), &["pass  clocks: by the journal of robot 1"]);
        check(
            &told,
            expected(Some(561)),
            &["FAIL  clocks: by the journal of robot 1 the mission is 561 s old"],
        );
        let behind = "pass  clocks: by the journal of robot 1 the mission is 100 s old, as robot 2 says 500 s; it is set 400 s";
        check(&told, expected(Some(100)), &[behind]);
    }

    #[test]
    fn whoever_is_there_is_held_against_the_others_and_the_robot_itself_if_it_runs() {
        let other = Participant::Coordinator;
        let agree = "pass  clocks: those of robot 1, robot 2 are 1.0 s apart; 60 s will do";
        check(&[(ME, 1, 401), (MATE, 2, 401)], expected(None), &[agree]);
        let apart = "FAIL  clocks: those of robot 2, the coordinator are 390.0 s apart";
        let own = "pass  clocks: the mission is 400 s old, as the coordinator says";
        check(&[(MATE, 1, 11), (other, 1, 401)], expected(None), &[apart, own]);
    }

    #[test]
    fn another_pace_is_told_and_a_time_that_stands_still_is_none() {
        let own = "pass  clocks: the mission is";
        check(&[(MATE, 0, 7), (MATE, 4, 7)], expected(None), &[own]);
        check(&[(MATE, 0, 7), (MATE, 4, 12)], expected(None), &[own]);
        check(&[(MATE, 0, 7), (MATE, 1, 107)], expected(None), &[own]);
        check(
            &[(MATE, 0, 7), (MATE, 4, 407)],
            expected(None),
            &["FAIL  clocks: of robot 2 400 s passed in 4.0 s", own],
        );
        check(
            &[(MATE, 0, 7), (MATE, 9, 9)],
            expected(None),
            &["FAIL  clocks: of robot 2 2 s passed in 9.0 s", own],
        );
    }
}
