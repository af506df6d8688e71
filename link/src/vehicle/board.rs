//! What is wrong with a vehicle, for whoever reads its diagnostics.

use std::collections::BTreeMap;

use dragnet_proto::ros::name::TopicName;
use dragnet_proto::ros::output::{Diagnostic, Level};
use dragnet_vehicle::pilot::diagnostic::{Diagnostic as Said, Level as Degree};

/// So many subjects stand on it: their names come from settings and from the pilot, so that there are few.
const MOST: usize = 256;

/// The last that was said of each subject.
#[derive(Debug, Default)]
pub(super) struct Board {
    entries: BTreeMap<String, Diagnostic>,
    /// What is to be told once, not as long as it stands.
    news: Vec<Diagnostic>,
    /// What was refused, by topic.
    refused: BTreeMap<TopicName, u64>,
}

impl Board {
    /// What the pilot says.
    pub(super) fn pin(&mut self, said: &Said) {
        let level = match said.level {
            Degree::Ok => Level::Ok,
            Degree::Warning => Level::Warning,
            Degree::Error => Level::Error,
        };
        let values = said.numbers.iter().map(|(name, value)| ((*name).to_owned(), value.to_string()));
        self.put(&said.name, level, &said.message, values.collect(), true);
    }

    /// Something that somebody should look at.
    pub(super) fn note(&mut self, subject: &str, message: &str) {
        let is_new = self.entries.get(&name(subject)).is_none_or(|entry| entry.message != message);
        self.put(subject, Level::Warning, message, Vec::new(), is_new);
    }

    /// Nobody need look at it any more.
    pub(super) fn well(&mut self, subject: &str) {
        if self.entries.get(&name(subject)).is_some_and(|entry| entry.level != Level::Ok) {
            self.put(subject, Level::Ok, "well again", Vec::new(), true);
        }
    }

    /// What came on a topic cannot be. The first of each topic is news, the others are only counted.
    pub(super) fn refuse(&mut self, topic: &TopicName, reason: &str) {
        let count = self.refused.entry(topic.clone()).or_default();
        *count += 1;
        let count = *count;
        let values = vec![("refused".to_owned(), count.to_string())];
        self.put(&topic.to_string(), Level::Warning, reason, values, count == 1);
    }

    /// All of it, or that all is well.
    pub(super) fn all(&self) -> Vec<Diagnostic> {
        if self.entries.is_empty() {
            let (name, message) = (name("vehicle"), "well".to_owned());
            return vec![Diagnostic { level: Level::Ok, name, message, values: Vec::new() }];
        }
        self.entries.values().cloned().collect()
    }

    /// What came up since this was last asked.
    pub(super) fn take_news(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.news)
    }

    fn put(
        &mut self,
        subject: &str,
        level: Level,
        message: &str,
        values: Vec<(String, String)>,
        is_new: bool,
    ) {
        let name = name(subject);
        if self.entries.len() < MOST || self.entries.contains_key(&name) {
            let entry = Diagnostic { level, name: name.clone(), message: message.to_owned(), values };
            if is_new {
                self.news.push(entry.clone());
            }
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

    #[test]
    fn the_last_that_was_said_of_a_subject_stands() {
        let mut board = Board::default();
        assert_eq!(board.all()[0].message, "well");
        let say = |level, message: &str| Said {
            level,
            name: "pose".to_owned(),
            message: message.to_owned(),
            numbers: vec![("silence_seconds", 2.5)],
        };
        board.pin(&say(Degree::Error, "no pose comes"));
        board.note("map", "turned");
        board.note("path", "nobody drives");
        board.well("path");
        board.well("goal");
        let topic: TopicName =
            TopicName::resolve("/fix", &"".parse().unwrap(), &"dragnet".parse().unwrap()).unwrap();
        board.refuse(&topic, "NaN");
        board.refuse(&topic, "infinite");
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
                "dragnet: map Warning turned []",
                "dragnet: path Ok well again []",
                "dragnet: pose Ok well again [(\"silence_seconds\", \"2.5\")]",
            ]
        );
        let news: Vec<String> = board.take_news().into_iter().map(|entry| entry.message).collect();
        assert_eq!(news, ["no pose comes", "turned", "nobody drives", "well again", "NaN", "well again"]);
        assert!(board.take_news().is_empty());
    }
}
