//! Observations, and the log that counts each exactly once.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::num::{NonZeroU16, NonZeroUsize};
use std::sync::Arc;

use crate::cell::Cell;
use crate::evidence::Reading;

/// A robot of the team, by its number. Robots count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RobotId(NonZeroU16);

impl RobotId {
    /// The first of a team.
    pub const FIRST: Self = Self(NonZeroU16::MIN);

    /// The robot of a number; none has 0.
    #[must_use]
    pub const fn new(number: u16) -> Option<Self> {
        match NonZeroU16::new(number) {
            Some(number) => Some(Self(number)),
            None => None,
        }
    }

    /// The first so many.
    pub fn first(count: u16) -> impl Iterator<Item = Self> {
        (1..=count).filter_map(Self::new)
    }

    /// Its number, from 1.
    #[must_use]
    pub const fn number(self) -> u16 {
        self.0.get()
    }

    /// Its place in the team, from 0.
    #[must_use]
    pub const fn index(self) -> usize {
        self.number() as usize - 1
    }
}

impl fmt::Display for RobotId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Who tells what is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// A person, who marks cells by hand.
    Operator,
    /// A robot, which looks around.
    Robot(RobotId),
}

impl From<RobotId> for Source {
    fn from(robot: RobotId) -> Self {
        Self::Robot(robot)
    }
}

impl fmt::Display for Source {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operator => formatter.write_str("the operator"),
            Self::Robot(robot) => write!(formatter, "robot {robot}"),
        }
    }
}

/// A source from one of its starts on: what it sees is numbered by it.
///
/// A robot that starts again counts anew under another origin, whatever it remembers: what it remembers last need not be the
/// last that it told, as when its disk was full, and no name may ever stand for two observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// Who tells it.
    pub source: Source,
    /// When it started, nanoseconds of mission time by its own clock; later than every start that it remembers.
    pub incarnation: u64,
}

impl Origin {
    /// That of a robot that started with the mission.
    #[must_use]
    pub const fn first(robot: RobotId) -> Self {
        Self { source: Source::Robot(robot), incarnation: 0 }
    }
}

/// All readings of one look. `(origin, sequence)` names it for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Who looked.
    pub origin: Origin,
    /// Counts the observations of that origin from 0 without a gap.
    pub sequence: u64,
    /// When, nanoseconds of mission time. It bounds how fast the robot can have moved since its observation before, and says how
    /// long it stands still; what the readings say does not depend on it.
    pub time_ns: u64,
    /// Where the robot stood.
    pub from: Cell,
    /// What it saw.
    pub readings: Vec<Reading>,
}

/// What became of an observation that was offered to a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// It is new: its readings count, now.
    New,
    /// It is known: its readings have counted already.
    Known,
    /// One before it is missing: it is not kept, and comes again with what is missing.
    Early,
    /// Another one of the same name is known. The first stays.
    Conflicting,
}

/// Which observations of an origin are known: all before the first one that is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// Whose observations.
    pub origin: Origin,
    /// The first sequence number that is missing.
    pub next: u64,
}

/// All observations known to a robot, its own and others'.
///
/// Those of an origin are known from the first one on, without a gap: what comes after a missing one waits where it came
/// from. So a log is as long as what it holds, whatever numbers others invent. What is written down elsewhere may be
/// released: it stays known, and takes no memory.
#[derive(Clone, Debug, Default)]
pub struct ObservationLog {
    logs: BTreeMap<Origin, Known>,
    /// Incarnations of each source of which something is known.
    incarnations: BTreeMap<Source, usize>,
}

/// The first and the last known observation of an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends<'a> {
    /// The first.
    pub first: &'a Observation,
    /// The last; the first, if it is the only one.
    pub last: &'a Observation,
}

/// The observations of one origin; one at least is known.
#[derive(Clone, Debug)]
struct Known {
    first: Arc<Observation>,
    /// So many, from the first on, are known and no longer held.
    released: u64,
    /// Those after them; the last is always held.
    held: Vec<Arc<Observation>>,
}

impl Known {
    fn next(&self) -> u64 {
        self.released + self.held.len() as u64
    }

    /// Those held from a sequence number on; `None` if it is not held.
    fn since(&self, first: u64) -> Option<&[Arc<Observation>]> {
        let place = usize::try_from(first.checked_sub(self.released)?).ok()?;
        self.held.get(place..).filter(|held| !held.is_empty())
    }
}

impl ObservationLog {
    /// Offers an observation; it is held if it is new.
    pub fn insert(&mut self, observation: Arc<Observation>) -> Entry {
        let entry = self.entry(&observation);
        if entry == Entry::New {
            let known = self.logs.entry(observation.origin).or_insert_with(|| {
                *self.incarnations.entry(observation.origin.source).or_default() += 1;
                Known { first: Arc::clone(&observation), released: 0, held: Vec::new() }
            });
            known.held.push(observation);
        }
        entry
    }

    /// What would become of an observation. One whose name is that of a released one is not compared with it.
    #[must_use]
    pub fn entry(&self, observation: &Observation) -> Entry {
        let known = self.logs.get(&observation.origin);
        let held = known.and_then(|known| known.since(observation.sequence)?.first());
        match held {
            Some(held) if **held == *observation => Entry::Known,
            Some(_) => Entry::Conflicting,
            None => match observation.sequence.cmp(&self.next(observation.origin)) {
                Ordering::Less => Entry::Known,
                Ordering::Equal => Entry::New,
                Ordering::Greater => Entry::Early,
            },
        }
    }

    /// The ends of what is known of an origin; `None` if nothing is.
    #[must_use]
    pub fn ends(&self, origin: Origin) -> Option<Ends<'_>> {
        let known = self.logs.get(&origin)?;
        Some(Ends { first: &known.first, last: known.held.last()? })
    }

    /// The first sequence number of an origin that is missing.
    #[must_use]
    pub fn next(&self, origin: Origin) -> u64 {
        self.logs.get(&origin).map_or(0, Known::next)
    }

    /// What is known, by origin.
    pub fn versions(&self) -> impl Iterator<Item = Version> + '_ {
        self.logs.iter().map(|(&origin, known)| Version { origin, next: known.next() })
    }

    /// Whether somebody who tells these versions knows all that is known here.
    #[must_use]
    pub fn is_known_to(&self, told: &[Version]) -> bool {
        let told: BTreeMap<Origin, u64> = told.iter().map(|version| (version.origin, version.next)).collect();
        self.versions().all(|own| told.get(&own.origin).is_some_and(|&next| next >= own.next))
    }

    /// Incarnations of a source of which something is known.
    #[must_use]
    pub fn incarnations(&self, source: Source) -> usize {
        self.incarnations.get(&source).copied().unwrap_or_default()
    }

    /// Observations of an origin from a sequence number on, in order; none if that one is missing or released.
    #[must_use]
    pub fn since(&self, origin: Origin, first: u64) -> &[Arc<Observation>] {
        self.logs.get(&origin).and_then(|known| known.since(first)).unwrap_or_default()
    }

    /// Holds no more than the last so many of each origin, and one at least.
    pub fn release(&mut self, held: NonZeroUsize) {
        for known in self.logs.values_mut() {
            let surplus = known.held.len().saturating_sub(held.get());
            known.held.drain(..surplus);
            known.released += surplus as u64;
        }
    }

    /// Number of observations known.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.logs.values().map(Known::next).sum()
    }

    /// Whether none is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.logs.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Grid;

    const SEVEN: Origin = Origin::first(RobotId::new(7).unwrap());

    fn observation(sequence: u64, time_ns: u64) -> Arc<Observation> {
        let from = Grid::new(1, 1).unwrap().cells().next().unwrap();
        Arc::new(Observation { origin: SEVEN, sequence, time_ns, from, readings: Vec::new() })
    }

    #[test]
    fn an_observation_counts_once_and_the_first_of_a_name_stays() {
        let mut log = ObservationLog::default();
        assert_eq!(log.insert(observation(0, 5)), Entry::New);
        assert_eq!(log.insert(observation(0, 5)), Entry::Known);
        assert_eq!(log.insert(observation(0, 6)), Entry::Conflicting);
        assert_eq!(log.len(), 1);
    }

    #[test]
    fn what_comes_after_a_gap_is_kept_once_the_gap_is_filled() {
        let mut log = ObservationLog::default();
        log.insert(observation(0, 0));
        for early in [2, u64::MAX] {
            assert_eq!(log.insert(observation(early, 0)), Entry::Early);
        }
        assert_eq!((log.next(SEVEN), log.len()), (1, 1));
        assert_eq!([1, 2].map(|sequence| log.insert(observation(sequence, 0))), [Entry::New; 2]);
        let since = log.since(SEVEN, 1).iter().map(|known| known.sequence);
        assert_eq!(since.collect::<Vec<_>>(), [1, 2]);
        assert!(log.since(SEVEN, 4).is_empty() && log.since(SEVEN, u64::MAX).is_empty());
    }

    #[test]
    fn what_is_released_stays_known_and_is_held_no_more() {
        let mut log = ObservationLog::default();
        (0..5).for_each(|sequence| assert_eq!(log.insert(observation(sequence, sequence)), Entry::New));
        log.release(NonZeroUsize::new(2).unwrap());
        log.release(NonZeroUsize::new(3).unwrap());
        assert_eq!((log.next(SEVEN), log.len()), (5, 5));
        let held = |first| log.since(SEVEN, first).iter().map(|held| held.sequence).collect::<Vec<_>>();
        assert_eq!([2, 3, 4, 5].map(held), [vec![], vec![3, 4], vec![4], vec![]]);
        let ends = log.ends(SEVEN).map(|ends| (ends.first.sequence, ends.last.sequence));
        assert_eq!(ends, Some((0, 4)));
        let offered = [(2, 2), (2, 9), (3, 3), (3, 9), (5, 5), (6, 6)];
        let entries = offered.map(|(sequence, time_ns)| log.entry(&observation(sequence, time_ns)));
        let again = [Entry::Known, Entry::Known, Entry::Known, Entry::Conflicting];
        assert_eq!(entries[..4], again, "what is released cannot be compared");
        assert_eq!(entries[4..], [Entry::New, Entry::Early]);
    }

    #[test]
    fn robots_count_from_one_and_come_after_the_operator() {
        assert_eq!((RobotId::new(0), RobotId::new(1)), (None, Some(RobotId::FIRST)));
        assert_eq!(
            RobotId::first(3).map(|robot| (robot.number(), robot.index())).collect::<Vec<_>>(),
            [(1, 0), (2, 1), (3, 2)]
        );
        assert!(Source::Operator < RobotId::FIRST.into());
    }

    #[test]
    fn each_incarnation_counts_from_zero() {
        let mut log = ObservationLog::default();
        log.insert(observation(0, 0));
        let again = Origin { incarnation: 5, ..SEVEN };
        let first = Observation { origin: again, ..(*observation(0, 0)).clone() };
        assert_eq!((log.next(again), log.insert(Arc::new(first))), (0, Entry::New));
        assert_eq!(log.versions().map(|version| version.next).collect::<Vec<_>>(), [1, 1]);
        assert_eq!((log.incarnations(SEVEN.source), log.incarnations(Source::Operator)), (2, 0));
    }

    #[test]
    fn who_knows_more_knows_all() {
        let mut log = ObservationLog::default();
        assert!(log.is_known_to(&[]));
        log.insert(observation(0, 0));
        let version = |origin, next| Version { origin, next };
        let other = Origin::first(RobotId::new(8).unwrap());
        assert!(log.is_known_to(&[version(other, 9), version(SEVEN, 1)]));
        assert!(!log.is_known_to(&[version(other, 9), version(SEVEN, 0)]));
        assert!(!log.is_known_to(&[version(other, 9)]));
    }
}
