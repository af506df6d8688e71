//! The published diagnostics of a vehicle.

use std::borrow::Cow;
use std::collections::BTreeMap;

use dragnet_ros2::name::TopicName;
use dragnet_ros2::output::{Diagnostic, Level};
use dragnet_scenario::time::MissionTime;
use dragnet_vehicle::pilot::alarms::Alarms;
use dragnet_vehicle::pilot::diagnostic::{Diagnostic as PilotDiagnostic, Level as Degree};

/// Maximum number of subjects: their names come from settings and from the pilot, so there are few.
const MOST: usize = 256;
/// Time without a fault after which it ends, nanoseconds.
const RECOVERY_NS: u64 = 3_000_000_000;

/// The last diagnostic of each subject.
#[derive(Debug)]
pub(super) struct DiagnosticsAggregator {
    entries: BTreeMap<String, Diagnostic>,
    /// Alarms of all but the pilot, which has its own.
    alarms: Alarms<String>,
    /// Diagnostics to be logged once.
    news: Vec<Diagnostic>,
    refused: BTreeMap<TopicName, RefusedInput>,
}

/// Invalid messages on a topic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RefusedInput {
    pub(crate) count: u64,
    /// The reason of the last one.
    pub(crate) reason: String,
}

impl Default for DiagnosticsAggregator {
    fn default() -> Self {
        Self {
            entries: BTreeMap::new(),
            alarms: Alarms::new(RECOVERY_NS),
            news: Vec::new(),
            refused: BTreeMap::new(),
        }
    }
}

impl DiagnosticsAggregator {
    /// Adds a diagnostic of the pilot.
    pub(super) fn pin(&mut self, pilot_diagnostic: &PilotDiagnostic) {
        let level = match pilot_diagnostic.level {
            Degree::Ok => Level::Ok,
            Degree::Warning => Level::Warning,
            Degree::Error => Level::Error,
        };
        let values =
            pilot_diagnostic.numbers.iter().map(|(name, value)| ((*name).to_owned(), value.to_string()));
        self.put(name(&pilot_diagnostic.name), level, &pilot_diagnostic.message, values.collect());
    }

    /// Raises a fault of a subject.
    pub(super) fn note(&mut self, now: MissionTime, subject: &str, message: &str) {
        self.note_as(now, subject, message.to_owned(), message);
    }

    /// The same with a message that holds numbers: faults of one kind are reported once.
    pub(super) fn note_as(
        &mut self,
        now: MissionTime,
        subject: &str,
        kind: impl Into<Cow<'static, str>>,
        message: &str,
    ) {
        let name = name(subject);
        if self.alarms.raise(now.0, name.clone(), kind) {
            self.put(name, Level::Warning, message, Vec::new());
        }
    }

    /// Shows a state that is no news.
    pub(super) fn show(&mut self, diagnostic: Diagnostic) {
        let name = name(&diagnostic.name);
        self.entries.insert(name.clone(), Diagnostic { name, ..diagnostic });
    }

    /// A subject has no fault now.
    pub(super) fn well(&mut self, now: MissionTime, subject: &str) {
        self.alarms.ease(now.0, &name(subject));
    }

    /// A message on a topic is invalid, for a reason that is reported only here: the first is logged, the others are
    /// only counted.
    pub(super) fn refuse(&mut self, now: MissionTime, topic: &TopicName, reason: &str) {
        self.count(topic, reason);
        let name = name(&topic.to_string());
        if self.alarms.raise(now.0, name.clone(), "refused") {
            self.put(name, Level::Warning, reason, Vec::new());
        } else if let Some(entry) = self.entries.get_mut(&name) {
            reason.clone_into(&mut entry.message);
        }
    }

    /// A message on a topic is invalid, for a reason that is reported elsewhere.
    pub(super) fn count(&mut self, topic: &TopicName, reason: &str) {
        if let Some(refused) = self.refused.get_mut(topic) {
            refused.count += 1;
            reason.clone_into(&mut refused.reason);
        } else if self.refused.len() < MOST {
            self.refused.insert(topic.clone(), RefusedInput { count: 1, reason: reason.to_owned() });
        }
    }

    /// A message on a topic is valid.
    pub(super) fn received(&mut self, now: MissionTime, topic: &TopicName) {
        if self.refused.contains_key(topic) {
            self.well(now, &topic.to_string());
        }
    }

    /// Ends faults that have been over for long enough.
    pub(super) fn settle(&mut self, now: MissionTime) {
        for name in self.alarms.settle(now.0) {
            self.put(name, Level::Ok, "well again", Vec::new());
        }
    }

    /// All diagnostics, or that there is no fault; and the invalid messages of each topic.
    pub(super) fn all(&self) -> Vec<Diagnostic> {
        let mut all = self.entries.clone();
        for (topic, refused) in &self.refused {
            let name = name(&topic.to_string());
            let entry = all.entry(name.clone()).or_insert_with(|| Diagnostic {
                level: Level::Ok,
                name,
                message: format!("the last rejected: {}", refused.reason),
                values: Vec::new(),
            });
            entry.values.push(("refused".to_owned(), refused.count.to_string()));
        }
        if all.is_empty() {
            let (name, message) = (name("vehicle"), "well".to_owned());
            return vec![Diagnostic { level: Level::Ok, name, message, values: Vec::new() }];
        }
        all.into_values().collect()
    }

    /// Invalid messages, by topic.
    pub(super) const fn refused(&self) -> &BTreeMap<TopicName, RefusedInput> {
        &self.refused
    }

    /// New diagnostics since the last call.
    pub(super) fn take_news(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.news)
    }

    fn put(&mut self, name: String, level: Level, message: &str, values: Vec<(String, String)>) {
        if self.entries.len() < MOST || self.entries.contains_key(&name) {
            let entry = Diagnostic { level, name: name.clone(), message: message.to_owned(), values };
            self.news.push(entry.clone());
            self.entries.insert(name, entry);
        }
    }
}

fn name(subject: &str) -> String {
    format!("dragnet: {subject}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> MissionTime {
        MissionTime(seconds * 1_000_000_000)
    }

    fn topic(name: &str) -> TopicName {
        TopicName::resolve(name, &"".parse().unwrap(), &"dragnet".parse().unwrap()).unwrap()
    }

    #[test]
    fn the_last_diagnostic_of_a_subject_counts() {
        let mut aggregator = DiagnosticsAggregator::default();
        assert_eq!(aggregator.all()[0].message, "well");
        let say = |level, message: &str| PilotDiagnostic {
            level,
            name: "pose".to_owned(),
            message: message.to_owned(),
            numbers: vec![("silence_seconds", 2.5)],
        };
        aggregator.pin(&say(Degree::Error, "no pose arrives"));
        aggregator.note(at(1), "map", "turned");
        aggregator.note(at(1), "path", "no progress");
        aggregator.well(at(1), "path");
        aggregator.well(at(1), "goal");
        aggregator.refuse(at(1), &topic("/fix"), "NaN");
        aggregator.refuse(at(2), &topic("/fix"), "infinite");
        aggregator.count(&topic("/seen"), "stamps stand still");
        aggregator.settle(at(4));
        aggregator.pin(&say(Degree::Ok, "well again"));
        let lines: Vec<String> = aggregator
            .all()
            .iter()
            .map(|entry| format!("{} {:?} {} {:?}", entry.name, entry.level, entry.message, entry.values))
            .collect();
        assert_eq!(
            lines,
            [
                "dragnet: /fix Warning infinite [(\"refused\", \"2\")]",
                "dragnet: /seen Ok the last rejected: stamps stand still [(\"refused\", \"1\")]",
                "dragnet: map Warning turned []",
                "dragnet: path Ok well again []",
                "dragnet: pose Ok well again [(\"silence_seconds\", \"2.5\")]",
            ]
        );
        let news: Vec<String> = aggregator.take_news().into_iter().map(|entry| entry.message).collect();
        assert_eq!(news, ["no pose arrives", "turned", "no progress", "NaN", "well again", "well again"]);
        assert!(aggregator.take_news().is_empty());
    }

    #[test]
    fn a_topic_that_is_good_and_bad_in_turn_is_reported_once_and_counted() {
        let mut aggregator = DiagnosticsAggregator::default();
        for second in 0..1000 {
            aggregator.refuse(at(second), &topic("/odom"), "NaN");
            aggregator.received(at(second), &topic("/odom"));
            aggregator.settle(at(second));
        }
        assert_eq!(aggregator.take_news().len(), 1);
        assert_eq!(
            aggregator.refused()[&topic("/odom")],
            RefusedInput { count: 1000, reason: "NaN".to_owned() }
        );
        aggregator.settle(at(1002));
        let news: Vec<Level> = aggregator.take_news().into_iter().map(|entry| entry.level).collect();
        assert_eq!(news, [Level::Ok]);
    }
}
