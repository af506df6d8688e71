//! Rate limiting of the log: the same kind of line about the same sender is logged once a minute, and that it comes or goes ten
//! times, with a count of the suppressed ones.

use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant};

use dragnet_proto::validation::Rejection;

use crate::waiting::Sender;

/// Time after which the same is logged again.
pub(crate) const PERIOD: Duration = Duration::from_mins(1);
/// Maximum number of different kinds; all others count as one.
pub(crate) const MOST_KINDS: usize = 1000;

/// Time between two removals of old kinds.
const CHECK_PERIOD: Duration = Duration::from_secs(1);

/// Decides which lines are logged, and which are only counted.
#[derive(Clone, Debug)]
pub(crate) struct LogLimit<K> {
    /// The last line of each kind; `None` is the common kind of the rest.
    reported: BTreeMap<Option<K>, Reported>,
    /// When the next count of suppressed lines is due.
    due: Option<Instant>,
    /// When old kinds were last removed: not for each line of a flood.
    observed: Option<Instant>,
}

#[derive(Clone, Copy, Debug)]
struct Reported {
    /// When the first line of a period was logged.
    at: Instant,
    /// How many were since.
    count: u32,
    suppressed: u64,
}

impl<K> Default for LogLimit<K> {
    fn default() -> Self {
        Self { reported: BTreeMap::new(), due: None, observed: None }
    }
}

impl<K: Ord + Clone> LogLimit<K> {
    /// Whether a line of a kind is to be logged now; otherwise it is counted.
    pub(crate) fn admits(&mut self, now: Instant, kind: &K) -> bool {
        self.admits_up_to(1, now, kind)
    }

    /// The same, where a period has up to `most` lines of the kind.
    fn admits_up_to(&mut self, most: u32, now: Instant, kind: &K) -> bool {
        let key = self.key(now, kind);
        let Some(reported) = self.reported.get_mut(&key) else {
            self.reported.insert(key, Reported { at: now, count: 1, suppressed: 0 });
            return true;
        };
        let again = reported.at + PERIOD;
        if reported.suppressed == 0 && now >= again {
            (reported.at, reported.count) = (now, 1);
            return true;
        }
        if reported.suppressed == 0 && reported.count < most {
            reported.count += 1;
            return true;
        }
        reported.suppressed += 1;
        self.due = Some(self.due.map_or(again, |due| due.min(again)));
        false
    }

    /// When [`LogLimit::settle`] has something to log, if nothing else happens.
    #[must_use]
    pub(crate) const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// The counts of suppressed lines that are due, by kind; `None` is the common kind of the rest.
    pub(crate) fn settle(&mut self, now: Instant) -> Vec<(Option<K>, u64)> {
        if self.due.is_none_or(|due| now < due) {
            return Vec::new();
        }
        let mut counts = Vec::new();
        for (kind, reported) in &mut self.reported {
            if reported.suppressed > 0 && now >= reported.at + PERIOD {
                (reported.at, reported.count) = (now, 1);
                counts.push((kind.clone(), std::mem::take(&mut reported.suppressed)));
            }
        }
        let left = self.reported.values().filter(|reported| reported.suppressed > 0);
        self.due = left.map(|reported| reported.at + PERIOD).min();
        counts
    }

    /// The counts of suppressed lines by kind, due or not.
    fn suppressed(&mut self) -> Vec<(Option<K>, u64)> {
        self.due = None;
        let counts = self
            .reported
            .iter_mut()
            .map(|(kind, reported)| (kind.clone(), std::mem::take(&mut reported.suppressed)));
        counts.filter(|(_, count)| *count > 0).collect()
    }

    fn key(&mut self, now: Instant, kind: &K) -> Option<K> {
        let key = Some(kind.clone());
        if self.reported.len() < MOST_KINDS || self.reported.contains_key(&key) {
            return key;
        }
        if self.observed.is_none_or(|observed| now >= observed + CHECK_PERIOD) {
            self.observed = Some(now);
            self.reported.retain(|_, reported| reported.suppressed > 0 || now < reported.at + PERIOD);
        }
        if self.reported.len() < MOST_KINDS { key } else { None }
    }
}

/// The kinds of lines that other participants could cause without end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// An invalid message.
    NoMessage,
    /// An invalid observation.
    Rejected(Rejection),
    /// Dropped messages.
    Dropped,
    /// A participant has joined.
    Came,
    /// A participant has joined again.
    Back,
    /// A participant has left.
    Left,
    /// A publication failed.
    Network,
    /// Reading from a journal failed.
    Journal,
    /// A sensor.
    Sensor,
    /// The clock was set.
    Clock,
    /// The mission's time runs faster than here.
    Pace,
    /// A time was rejected.
    Disbelief,
    /// There are two processes of a participant.
    Two,
    /// Neither of two processes has died.
    Double,
    /// There is one process again.
    One,
    /// A participant has another scenario.
    Scenario,
}

impl Kind {
    /// How many lines of a sender are logged in a period. Whether a participant is there must not be hidden by a limit, unless it
    /// comes and goes without end.
    const fn most(self) -> u32 {
        match self {
            Self::Came | Self::Back | Self::Left => 10,
            _ => 1,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoMessage => formatter.write_str("invalid messages"),
            Self::Rejected(why) => write!(formatter, "rejections ({why})"),
            Self::Dropped => formatter.write_str("dropped messages"),
            Self::Came => formatter.write_str("arrivals"),
            Self::Back => formatter.write_str("returns"),
            Self::Left => formatter.write_str("departures"),
            Self::Network => formatter.write_str("network failures"),
            Self::Journal => formatter.write_str("journal failures"),
            Self::Sensor => formatter.write_str("faults of the sensor"),
            Self::Clock => formatter.write_str("clock adjustments"),
            Self::Pace => formatter.write_str("unlike real-time factors"),
            Self::Disbelief => formatter.write_str("rejected times"),
            Self::Two | Self::Double => formatter.write_str("duplicate processes"),
            Self::One => formatter.write_str("ends of duplicate processes"),
            Self::Scenario => formatter.write_str("other scenarios"),
        }
    }
}

/// The log of a participant: each kind once a minute for each sender.
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
        self.log_suppressed(now);
        self.limit.admits_up_to(kind.most(), now, &(kind, sender))
    }

    /// Waits until a count of suppressed lines is due, and logs it; never ends if there is none.
    pub(crate) async fn settle(&mut self) {
        match self.limit.due() {
            Some(due) => tokio::time::sleep_until(due.into()).await,
            None => std::future::pending().await,
        }
        self.log_suppressed(Instant::now());
    }

    fn log_suppressed(&mut self, now: Instant) {
        for (kind, count) in self.limit.settle(now) {
            tracing::warn!("{count} more in {} s, not logged: {}", PERIOD.as_secs(), what(kind));
        }
    }
}

impl Drop for Teller {
    /// All suppressed lines are counted in the log.
    fn drop(&mut self) {
        for (kind, count) in self.limit.suppressed() {
            tracing::warn!("{count} more until the end, not logged: {}", what(kind));
        }
    }
}

fn what(kind: Option<(Kind, Sender)>) -> String {
    kind.map_or("of too many kinds to list".to_owned(), |(kind, sender)| format!("{kind} of {sender}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_is_logged_once_a_period_and_the_rest_is_counted() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let reported = (0..1000).filter(|&step| limit.admits(start + PERIOD / 1000 * step, &"a")).count();
        assert_eq!((reported, limit.due()), (1, Some(start + PERIOD)));
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
    fn comings_and_goings_are_logged_unless_they_do_not_end() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let mut logged = |after: Duration| {
            (0..15).filter(|_| limit.admits_up_to(Kind::Left.most(), start + after, &"a")).count()
        };
        assert_eq!(logged(Duration::ZERO), 10);
        assert_eq!(logged(PERIOD / 2), 0);
        assert_eq!(limit.settle(start + PERIOD), [(Some("a"), 20)]);
        assert!(limit.admits_up_to(2, start + PERIOD, &"a"), "after that again");
    }

    #[test]
    fn at_the_end_all_that_was_left_out_is_known() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let reported = ["a", "b", "a", "a", "c"].into_iter().filter(|kind| limit.admits(start, kind)).count();
        assert_eq!((reported, limit.suppressed()), (3, vec![(Some("a"), 2)]));
        assert_eq!((limit.suppressed(), limit.due()), (Vec::new(), None));
    }

    #[test]
    fn late_pauses_are_applied() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        assert!(limit.admits(start, &1));
        assert!(!limit.admits(start, &1));
        assert!(!limit.admits(start + PERIOD * 5, &1), "suppressed lines are counted first");
        assert_eq!(limit.settle(start + PERIOD * 5), [(Some(1), 2)]);
    }

    #[test]
    fn however_many_kinds_there_are_memory_and_log_are_bounded() {
        let (mut limit, start) = (LogLimit::default(), Instant::now());
        let reported = (0..100_000).filter(|kind| limit.admits(start, kind)).count();
        assert_eq!(reported, MOST_KINDS + 1);
        assert_eq!(limit.reported.len(), MOST_KINDS + 1);
        let suppressed = 100_000 - MOST_KINDS as u64 - 1;
        assert_eq!(limit.settle(start + PERIOD), [(None, suppressed)]);
        // Memory for other kinds again, once those are long past.
        assert!(limit.admits(start + PERIOD * 3, &200_000));
        assert_eq!(limit.reported.len(), 1);
    }
}
