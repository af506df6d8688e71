//! A log that no flood fills: the same of the same sender is told once a minute, with a count of what was left out.

use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant};

use dragnet_proto::validation::Rejection;

use crate::waiting::Sender;

/// The same is told again after so long.
pub(crate) const PERIOD: Duration = Duration::from_mins(1);
/// So many different things are told apart; all others count as one.
pub(crate) const MOST_KINDS: usize = 1000;

/// Between two looks for room for further kinds.
const LOOK: Duration = Duration::from_secs(1);

/// Decides what is told and what is only counted.
#[derive(Clone, Debug)]
pub(crate) struct LogLimit<K> {
    /// What was told last, by kind; without a kind, what is too much to be told apart.
    told: BTreeMap<Option<K>, Told>,
    /// When something left out is to be told of, at the earliest.
    due: Option<Instant>,
    /// When room for further kinds was last looked for: not for each of a flood of them.
    looked: Option<Instant>,
}

#[derive(Clone, Copy, Debug)]
struct Told {
    at: Instant,
    left_out: u64,
}

impl<K> Default for LogLimit<K> {
    fn default() -> Self {
        Self { told: BTreeMap::new(), due: None, looked: None }
    }
}

impl<K: Ord + Clone> LogLimit<K> {
    /// Whether something of a kind is to be told now; if it is not, it is counted.
    pub(crate) fn admits(&mut self, now: Instant, kind: &K) -> bool {
        let key = self.key(now, kind);
        let Some(told) = self.told.get_mut(&key) else {
            self.told.insert(key, Told { at: now, left_out: 0 });
            return true;
        };
        let again = told.at + PERIOD;
        if told.left_out == 0 && now >= again {
            told.at = now;
            return true;
        }
        told.left_out += 1;
        self.due = Some(self.due.map_or(again, |due| due.min(again)));
        false
    }

    /// When [`LogLimit::settle`] has something to tell, if nothing else happens.
    #[must_use]
    pub(crate) const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// How much of which kinds was left out, where it is time to tell; without a kind, of all that is not told apart.
    pub(crate) fn settle(&mut self, now: Instant) -> Vec<(Option<K>, u64)> {
        if self.due.is_none_or(|due| now < due) {
            return Vec::new();
        }
        let mut counts = Vec::new();
        for (kind, told) in &mut self.told {
            if told.left_out > 0 && now >= told.at + PERIOD {
                told.at = now;
                counts.push((kind.clone(), std::mem::take(&mut told.left_out)));
            }
        }
        let left = self.told.values().filter(|told| told.left_out > 0);
        self.due = left.map(|told| told.at + PERIOD).min();
        counts
    }

    /// How much of which kinds was left out, whether or not it is time to tell.
    fn left_out(&mut self) -> Vec<(Option<K>, u64)> {
        self.due = None;
        let counts =
            self.told.iter_mut().map(|(kind, told)| (kind.clone(), std::mem::take(&mut told.left_out)));
        counts.filter(|(_, count)| *count > 0).collect()
    }

    fn key(&mut self, now: Instant, kind: &K) -> Option<K> {
        let key = Some(kind.clone());
        if self.told.len() < MOST_KINDS || self.told.contains_key(&key) {
            return key;
        }
        if self.looked.is_none_or(|looked| now >= looked + LOOK) {
            self.looked = Some(now);
            self.told.retain(|_, told| told.left_out > 0 || now < told.at + PERIOD);
        }
        if self.told.len() < MOST_KINDS { key } else { None }
    }
}

/// What a participant says in its log that others could make it say without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// What is no message.
    NoMessage,
    /// What cannot be.
    Rejected(Rejection),
    /// Messages that wait too long.
    Dropped,
    /// Somebody has come.
    Came,
    /// Somebody who had left has come again.
    Back,
    /// Somebody has left.
    Left,
    /// What the network did not take.
    Network,
    /// What could not be repeated from a journal.
    Journal,
    /// A sensor.
    Sensor,
    /// That the clock was set.
    Clock,
    /// A time that is not believed.
    Disbelief,
    /// That there are two processes of somebody.
    Two,
    /// That neither of two is one that has died.
    Double,
    /// That there is one process again.
    One,
    /// That the own robot stands.
    Stands,
    /// That it goes on.
    GoesOn,
}

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMessage => formatter.write_str("what is no message"),
            Self::Rejected(why) => write!(formatter, "refusals ({why})"),
            Self::Dropped => formatter.write_str("messages that had to be dropped"),
            Self::Came => formatter.write_str("coming"),
            Self::Back => formatter.write_str("coming back"),
            Self::Left => formatter.write_str("leaving"),
            Self::Network => formatter.write_str("failures of the network"),
            Self::Journal => formatter.write_str("failures of the journal"),
            Self::Sensor => formatter.write_str("faults of the sensor"),
            Self::Clock => formatter.write_str("settings of the clock"),
            Self::Disbelief => formatter.write_str("times that were not believed"),
            Self::Two | Self::Double => formatter.write_str("doubles"),
            Self::One => formatter.write_str("ends of doubles"),
            Self::Stands => formatter.write_str("standing still"),
            Self::GoesOn => formatter.write_str("going on"),
        }
    }
}

/// The log of a participant: each kind once a minute of each sender.
#[derive(Default)]
pub(crate) struct Teller {
    limit: LogLimit<(Kind, Sender)>,
}

impl Teller {
    pub(crate) fn warn(&mut self, kind: Kind, sender: Sender, text: impl fmt::Display) {
        if self.admits(kind, sender) {
            tracing::warn!("{text}");
        }
    }

    pub(crate) fn error(&mut self, kind: Kind, sender: Sender, text: impl fmt::Display) {
        if self.admits(kind, sender) {
            tracing::error!("{text}");
        }
    }

    pub(crate) fn inform(&mut self, kind: Kind, sender: Sender, text: impl fmt::Display) {
        if self.admits(kind, sender) {
            tracing::info!("{text}");
        }
    }

    fn admits(&mut self, kind: Kind, sender: Sender) -> bool {
        let now = Instant::now();
        self.tell_left_out(now);
        self.limit.admits(now, &(kind, sender))
    }

    /// Waits until something was left out long enough ago, and tells of it; for ever if nothing was.
    pub(crate) async fn settle(&mut self) {
        match self.limit.due() {
            Some(due) => tokio::time::sleep_until(due.into()).await,
            None => std::future::pending().await,
        }
        self.tell_left_out(Instant::now());
    }

    fn tell_left_out(&mut self, now: Instant) {
        for (kind, count) in self.limit.settle(now) {
            tracing::warn!("{count} more in {} s, not told: {}", PERIOD.as_secs(), what(kind));
        }
    }
}

impl Drop for Teller {
    /// Nothing is left out without a word.
    fn drop(&mut self) {
        for (kind, count) in self.limit.left_out() {
            tracing::warn!("{count} more until the end, not told: {}", what(kind));
        }
    }
}

fn what(kind: Option<(Kind, Sender)>) -> String {
    kind.map_or("of too many kinds to be told apart".to_owned(), |(kind, sender)| {
        format!("{kind} of {sender}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_is_told_once_a_period_and_the_rest_is_counted() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let told = (0..1000).filter(|&step| limit.admits(start + PERIOD / 1000 * step, &"a")).count();
        assert_eq!((told, limit.due()), (1, Some(start + PERIOD)));
        assert!(limit.admits(start, &"b"), "another kind has a turn of its own");
        assert!(limit.settle(start + PERIOD / 2).is_empty());
        assert_eq!(limit.settle(start + PERIOD), [(Some("a"), 999)]);
        assert_eq!(limit.due(), None);
        // That was this period's line.
        assert!(!limit.admits(start + PERIOD, &"a"));
        assert_eq!(limit.settle(start + PERIOD * 2), [(Some("a"), 1)]);
        assert!(limit.admits(start + PERIOD * 3, &"a"));
    }

    #[test]
    fn at_the_end_all_that_was_left_out_is_known() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let told = ["a", "b", "a", "a", "c"].into_iter().filter(|kind| limit.admits(start, kind)).count();
        assert_eq!((told, limit.left_out()), (3, vec![(Some("a"), 2)]));
        assert_eq!((limit.left_out(), limit.due()), (Vec::new(), None));
    }

    #[test]
    fn nothing_is_forgotten_when_it_is_told_late() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        assert!(limit.admits(start, &1));
        assert!(!limit.admits(start, &1));
        assert!(!limit.admits(start + PERIOD * 5, &1), "what was left out is told of first");
        assert_eq!(limit.settle(start + PERIOD * 5), [(Some(1), 2)]);
    }

    #[test]
    fn however_many_kinds_there_are_memory_and_log_are_bounded() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let told = (0..100_000).filter(|kind| limit.admits(start, kind)).count();
        assert_eq!(told, MOST_KINDS + 1);
        assert_eq!(limit.told.len(), MOST_KINDS + 1);
        let left_out = 100_000 - MOST_KINDS as u64 - 1;
        assert_eq!(limit.settle(start + PERIOD), [(None, left_out)]);
        // Workspace again, once they are long past.
        assert!(limit.admits(start + PERIOD * 3, &200_000));
        assert_eq!(limit.told.len(), 1);
    }
}
