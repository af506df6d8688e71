//! What is wrong with a vehicle, for whoever reads its diagnostics.

use std::collections::BTreeMap;

use dragnet_ros2::name::TopicName;
use dragnet_ros2::output::{Diagnostic, Level};
use dragnet_scenario::time::MissionTime;
use dragnet_vehicle::pilot::alarms::Alarms;
use dragnet_vehicle::pilot::diagnostic::{Diagnostic as Said, Level as Degree};

/// So many subjects stand on it: their names come from settings and from the pilot, so that there are few.
const MOST: usize = 256;
/// Something is well again after so long without a fault, nanoseconds.
const RECOVERY_NS: u64 = 3_000_000_000;

/// The last that was said of each subject.
#[derive(Debug)]
pub(super) struct DiagnosticsAggregator {
    entries: BTreeMap<String, Diagnostic>,
    /// Of what is not the pilot's: that has alarms of its own.
    alarms: Alarms<String>,
    /// What is to be told once, not as long as it stands.
    news: Vec<Diagnostic>,
    refused: BTreeMap<TopicName, RefusedInput>,
}

/// What came on a topic and could not be used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RefusedInput {
    pub(crate) count: u64,
    /// Why the last of it could not.
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
    /// What the pilot says.
    pub(super) fn pin(&mut self, said: &Said) {
        let level = match said.level {
            Degree::Ok => Level::Ok,
            Degree::Warning => Level::Warning,
            Degree::Error => Level::Error,
        };
        let values = said.numbers.iter().map(|(name, value)| ((*name).to_owned(), value.to_string()));
        self.put(name(&said.name), level, &said.message, values.collect());
    }

    /// Something that somebody should look at.
    pub(super) fn note(&mut self, now: MissionTime, subject: &str, message: &str) {
        let name = name(subject);
        if self.alarms.raise(now.0, name.clone(), message.to_owned()) {
            self.put(name, Level::Warning, message, Vec::new());
        }
    }

    /// Nobody need look at it any more.
    pub(super) fn well(&mut self, now: MissionTime, subject: &str) {
        self.alarms.ease(now.0, &name(subject));
    }

    /// What came on a topic cannot be used, for a reason that is told by this alone: the first is news, the others are
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

    /// What came on a topic cannot be used, for a reason that is told otherwise.
    pub(super) fn count(&mut self, topic: &TopicName, reason: &str) {
        if let Some(refused) = self.refused.get_mut(topic) {
            refused.count += 1;
            reason.clone_into(&mut refused.reason);
        } else if self.refused.len() < MOST {
            self.refused.insert(topic.clone(), RefusedInput { count: 1, reason: reason.to_owned() });
        }
    }

    /// What came on a topic can be used.
    pub(super) fn heard(&mut self, now: MissionTime, topic: &TopicName) {
        if self.refused.contains_key(topic) {
            self.well(now, &topic.to_string());
        }
    }

    /// Time passes: what has been well for long enough is well again.
    pub(super) fn settle(&mut self, now: MissionTime) {
        for name in self.alarms.settle(now.0) {
            self.put(name, Level::Ok, "well again", Vec::new());
        }
    }

    /// All of it, or that all is well; and what was refused of each topic.
    pub(super) fn all(&self) -> Vec<Diagnostic> {
        let mut all = self.entries.clone();
        for (topic, refused) in &self.refused {
            let name = name(&topic.to_string());
            let entry = all.entry(name.clone()).or_insert_with(|| Diagnostic {
                level: Level::Ok,
                name,
                message: format!("the last that was refused: {}", refused.reason),
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

    /// What was refused, by topic.
    pub(super) const fn refused(&self) -> &BTreeMap<TopicName, RefusedInput> {
        &self.refused
    }

    /// What came up since this was last asked.
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
    fn the_last_that_was_said_of_a_subject_stands() {
        let mut board = DiagnosticsAggregator::default();
        assert_eq!(board.all()[0].message, "well");
        let say = |level, message: &str| Said {
            level,
            name: "pose".to_owned(),
            message: message.to_owned(),
            numbers: vec![("silence_seconds", 2.5)],
        };
        board.pin(&say(Degree::Error, "no pose comes"));
        board.note(at(1), "map", "turned");
        board.note(at(1), "path", "nobody drives");
        board.well(at(1), "path");
        board.well(at(1), "goal");
        board.refuse(at(1), &topic("/fix"), "NaN");
        board.refuse(at(2), &topic("/fix"), "infinite");
        board.count(&topic("/seen"), "stamps stand still");
        board.settle(at(4));
        board.pin(&say(Degree::Ok, "well again"));
        let lines: Vec<String> = board
            .all()
            .iter()
            .map(|entry| format!("{} {:?} {} {:?}", entry.name, entry.level, entry.message, entry.values))
            .collect();
        assert_eq!(
            lines,
            [
                "dragnet: /fix Warning infinite [(\"refused\", \"2\")]",
                "dragnet: /seen Ok the last that was refused: stamps stand still [(\"refused\", \"1\")]",
                "dragnet: map Warning turned []",
                "dragnet: path Ok well again []",
                "dragnet: pose Ok well again [(\"silence_seconds\", \"2.5\")]",
            ]
        );
        let news: Vec<String> = board.take_news().into_iter().map(|entry| entry.message).collect();
        assert_eq!(news, ["no pose comes", "turned", "nobody drives", "NaN", "well again", "well again"]);
        assert!(board.take_news().is_empty());
    }

    #[test]
    fn a_topic_that_is_good_and_bad_in_turn_is_told_once_and_counted() {
        let mut board = DiagnosticsAggregator::default();
        for second in 0..1000 {
            board.refuse(at(second), &topic("/odom"), "NaN");
            board.heard(at(second), &topic("/odom"));
            board.settle(at(second));
        }
        assert_eq!(board.take_news().len(), 1);
        assert_eq!(board.refused()[&topic("/odom")], RefusedInput { count: 1000, reason: "NaN".to_owned() });
        board.settle(at(1002));
        let news: Vec<Level> = board.take_news().into_iter().map(|entry| entry.level).collect();
        assert_eq!(news, [Level::Ok]);
    }
}
