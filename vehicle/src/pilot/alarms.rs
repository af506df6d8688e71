//! Alarms with hysteresis: a fault raises an alarm at once, and the alarm ends only after a time without faults.
//!
//! Otherwise a source that alternates between good and bad would stop and start its vehicle, and fill its log, with
//! every message. Such a source has one continuous alarm, and one of its causes is reported in each such time.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// Current and recent faults. `K` names a subject.
#[derive(Clone, Debug)]
pub struct Alarms<K> {
    /// Time without a fault after which an alarm ends, and after which another cause is reported. Nanoseconds.
    recovery_ns: u64,
    standing: BTreeMap<K, Alarm>,
}

#[derive(Clone, Debug)]
struct Alarm {
    /// The last reported cause, a word or a sentence.
    cause: Cow<'static, str>,
    reported_ns: u64,
    /// Since when there is no fault; `None` during a fault.
    good_since_ns: Option<u64>,
}

impl<K: Ord + Clone> Alarms<K> {
    /// No alarms.
    #[must_use]
    pub const fn new(recovery_ns: u64) -> Self {
        Self { recovery_ns, standing: BTreeMap::new() }
    }

    /// Records a fault of a subject; returns whether it is to be reported.
    pub fn raise(&mut self, now_ns: u64, subject: K, cause: impl Into<Cow<'static, str>>) -> bool {
        let cause = cause.into();
        let Some(alarm) = self.standing.get_mut(&subject) else {
            self.standing.insert(subject, Alarm { cause, reported_ns: now_ns, good_since_ns: None });
            return true;
        };
        alarm.good_since_ns = None;
        // The clock may have been set back.
        alarm.reported_ns = alarm.reported_ns.min(now_ns);
        let is_news = alarm.cause != cause && now_ns - alarm.reported_ns >= self.recovery_ns;
        if is_news {
            (alarm.cause, alarm.reported_ns) = (cause, now_ns);
        }
        is_news
    }

    /// Records that a subject has no fault now.
    pub fn ease(&mut self, now_ns: u64, subject: &K) {
        if let Some(alarm) = self.standing.get_mut(subject) {
            alarm.good_since_ns.get_or_insert(now_ns);
        }
    }

    /// Ends the alarms of subjects that have had no fault for the recovery time; returns these subjects, in order.
    pub fn settle(&mut self, now_ns: u64) -> Vec<K> {
        for alarm in self.standing.values_mut() {
            alarm.good_since_ns = alarm.good_since_ns.map(|since_ns| since_ns.min(now_ns));
        }
        let is_over =
            |alarm: &Alarm| alarm.good_since_ns.is_some_and(|since| now_ns - since >= self.recovery_ns);
        let over: Vec<K> = self
            .standing
            .iter()
            .filter(|(_, alarm)| is_over(alarm))
            .map(|(subject, _)| subject.clone())
            .collect();
        for subject in &over {
            self.standing.remove(subject);
        }
        over
    }

    /// Ends the alarm of a subject that is known to have had no fault for long enough; returns whether there was an
    /// alarm.
    pub fn end(&mut self, subject: &K) -> bool {
        self.standing.remove(subject).is_some()
    }

    /// Whether a subject has a fault now.
    #[must_use]
    pub fn is_bad(&self, subject: &K) -> bool {
        self.standing.get(subject).is_some_and(|alarm| alarm.good_since_ns.is_none())
    }

    /// Subjects with an alarm, in order.
    pub fn standing(&self) -> impl Iterator<Item = &K> {
        self.standing.keys()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECOVERY: u64 = 3000;

    /// The reports of a subject with these causes, one every 25 units of time; an empty one is none.
    fn reported(causes: impl IntoIterator<Item = &'static str>) -> Vec<(u64, String)> {
        let mut alarms = Alarms::new(RECOVERY);
        let mut reported = Vec::new();
        for (now, cause) in (0..).step_by(25).zip(causes) {
            if cause.is_empty() {
                alarms.ease(now, &"pose");
            } else if alarms.raise(now, "pose", cause) {
                reported.push((now, cause.to_owned()));
            }
            reported
                .extend(alarms.settle(now).into_iter().map(|subject| (now, format!("{subject} is well"))));
        }
        reported
    }

    fn expect(expected: &[(u64, &str)]) -> Vec<(u64, String)> {
        expected.iter().map(|&(now, what)| (now, what.to_owned())).collect()
    }

    #[test]
    fn a_source_that_is_bad_and_good_in_turn_is_one_alarm() {
        let turns = ["silent", ""].into_iter().cycle().take(2000);
        assert_eq!(
            reported(turns.chain([""; 200])),
            expect(&[(0, "silent"), (1999 * 25 + RECOVERY, "pose is well")])
        );
    }

    #[test]
    fn a_fault_is_reported_at_once_and_again_after_it_was_over() {
        let causes = ["", "jump", "", "", "jump"].into_iter().chain([""; 150]).chain(["jump"]);
        let over = 5 * 25 + RECOVERY;
        assert_eq!(reported(causes), expect(&[(25, "jump"), (over, "pose is well"), (155 * 25, "jump")]));
    }

    #[test]
    fn of_two_alternating_causes_one_is_reported_in_each_recovery_time() {
        let reported = reported(["late", "early"].into_iter().cycle().take(600));
        let gaps: Vec<u64> = reported.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        assert!(gaps.len() > 3 && gaps.iter().all(|&gap| gap >= RECOVERY), "{reported:?}");
    }

    #[test]
    fn a_clock_that_is_set_back_keeps_no_alarm_for_ever() {
        let mut alarms = Alarms::new(RECOVERY);
        assert!(alarms.raise(1_000_000, "pose", "jump"));
        alarms.ease(1_000_000, &"pose");
        assert!(alarms.settle(10).is_empty());
        assert_eq!(alarms.settle(10 + RECOVERY), ["pose"]);
        assert!(alarms.raise(1_000_000, "pose", "jump") && !alarms.raise(20, "pose", "late"));
        assert!(alarms.raise(20 + RECOVERY, "pose", "late"));
    }
}
