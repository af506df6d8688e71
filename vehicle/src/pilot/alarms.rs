//! Alarms with hysteresis: a fault is an alarm at once, and it is over only after nothing was wrong for a while.
//!
//! A source that is good and bad in turn would otherwise stop and start its vehicle, and fill its log, as often as it
//! sends. So such a source is one alarm that stands, and of the causes of an alarm one is told in each such while.

use std::borrow::Cow;
use std::collections::BTreeMap;

/// What is wrong now, or was a moment ago. `K` names a subject.
#[derive(Clone, Debug)]
pub struct Alarms<K> {
    /// An alarm is over after so long without a fault; another cause of it is news after so long. Nanoseconds.
    recovery_ns: u64,
    standing: BTreeMap<K, Alarm>,
}

#[derive(Clone, Debug)]
struct Alarm {
    /// The cause that was told last, in a word or a sentence.
    cause: Cow<'static, str>,
    told_ns: u64,
    /// Since when nothing is wrong; none while something is.
    good_since_ns: Option<u64>,
}

impl<K: Ord + Clone> Alarms<K> {
    /// No alarm yet.
    #[must_use]
    pub const fn new(recovery_ns: u64) -> Self {
        Self { recovery_ns, standing: BTreeMap::new() }
    }

    /// Something is wrong with a subject; whether that is to be told.
    pub fn raise(&mut self, now_ns: u64, subject: K, cause: impl Into<Cow<'static, str>>) -> bool {
        let cause = cause.into();
        let Some(alarm) = self.standing.get_mut(&subject) else {
            self.standing.insert(subject, Alarm { cause, told_ns: now_ns, good_since_ns: None });
            return true;
        };
        alarm.good_since_ns = None;
        // The clock may have been set back.
        alarm.told_ns = alarm.told_ns.min(now_ns);
        let is_news = alarm.cause != cause && now_ns - alarm.told_ns >= self.recovery_ns;
        if is_news {
            (alarm.cause, alarm.told_ns) = (cause, now_ns);
        }
        is_news
    }

    /// Nothing is wrong with a subject now.
    pub fn ease(&mut self, now_ns: u64, subject: &K) {
        if let Some(alarm) = self.standing.get_mut(subject) {
            alarm.good_since_ns.get_or_insert(now_ns);
        }
    }

    /// Ends the alarms of subjects with which nothing was wrong for long enough; which these are, in order.
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

    /// Ends the alarm of a subject that is known to be good for long enough; whether there was one.
    pub fn end(&mut self, subject: &K) -> bool {
        self.standing.remove(subject).is_some()
    }

    /// Whether something is wrong with a subject right now.
    #[must_use]
    pub fn is_bad(&self, subject: &K) -> bool {
        self.standing.get(subject).is_some_and(|alarm| alarm.good_since_ns.is_none())
    }

    /// Subjects whose alarm stands, in order.
    pub fn standing(&self) -> impl Iterator<Item = &K> {
        self.standing.keys()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RECOVERY: u64 = 3000;

    /// What is told of a subject that has these causes, one every 25 units of time; an empty one is none.
    fn told(causes: impl IntoIterator<Item = &'static str>) -> Vec<(u64, String)> {
        let mut alarms = Alarms::new(RECOVERY);
        let mut told = Vec::new();
        for (now, cause) in (0..).step_by(25).zip(causes) {
            if cause.is_empty() {
                alarms.ease(now, &"pose");
            } else if alarms.raise(now, "pose", cause) {
                told.push((now, cause.to_owned()));
            }
            told.extend(alarms.settle(now).into_iter().map(|subject| (now, format!("{subject} is well"))));
        }
        told
    }

    fn expect(expected: &[(u64, &str)]) -> Vec<(u64, String)> {
        expected.iter().map(|&(now, what)| (now, what.to_owned())).collect()
    }

    #[test]
    fn a_source_that_is_bad_and_good_in_turn_is_one_alarm() {
        let turns = ["silent", ""].into_iter().cycle().take(2000);
        assert_eq!(
            told(turns.chain([""; 200])),
            expect(&[(0, "silent"), (1999 * 25 + RECOVERY, "pose is well")])
        );
    }

    #[test]
    fn a_fault_is_told_at_once_and_again_after_it_was_over() {
        let causes = ["", "jump", "", "", "jump"].into_iter().chain([""; 150]).chain(["jump"]);
        let over = 5 * 25 + RECOVERY;
        assert_eq!(told(causes), expect(&[(25, "jump"), (over, "pose is well"), (155 * 25, "jump")]));
    }

    #[test]
    fn of_two_causes_that_alternate_one_is_told_in_each_while() {
        let told = told(["late", "early"].into_iter().cycle().take(600));
        let gaps: Vec<u64> = told.windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
        assert!(gaps.len() > 3 && gaps.iter().all(|&gap| gap >= RECOVERY), "{told:?}");
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
