//! Observations, and a log that counts each of them exactly once.

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

    /// The first `count` robots of a team.
    pub fn first(count: u16) -> impl Iterator<Item = Self> {
        (1..=count).filter_map(Self::new)
    }

    /// Its number, from 1.
    #[must_use]
    pub const fn number(self) -> u16 {
        self.0.get()
    }

    /// Its index in the team, from 0.
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

/// The source of observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// The operator, who marks cells.
    Operator,
    /// A robot of the team.
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

/// One start (incarnation) of a source; its observations are numbered within it.
///
/// A robot that restarts numbers its observations anew under a new origin, even if it has stored earlier ones: the last
/// stored one need not be the last that was published, for example if the disk was full, and a name must never denote
/// two observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// The source.
    pub source: Source,
    /// When it started, nanoseconds of mission time by its own clock; later than every earlier start that it has
    /// stored.
    pub incarnation: u64,
}

impl Origin {
    /// The origin of a robot that started with the mission.
    #[must_use]
    pub const fn first(robot: RobotId) -> Self {
        Self { source: Source::Robot(robot), incarnation: 0 }
    }
}

/// All readings taken from one cell at one time. `(origin, sequence)` names it for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The robot's origin.
    pub origin: Origin,
    /// The number of the observation: observations of an origin are numbered from 0 without a gap.
    pub sequence: u64,
    /// When, nanoseconds of mission time. It bounds the robot's speed since its previous observation, and shows how
    /// long the robot stands still; the meaning of the readings does not depend on it.
    pub time_ns: u64,
    /// The robot's cell.
    pub from: Cell,
    /// The readings.
    pub readings: Vec<Reading>,
}

/// The result of inserting an observation into a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// It is new: its readings count from now on.
    New,
    /// It is known: its readings already count.
    Known,
    /// An earlier one is missing: this one is not stored, and is sent again with the missing ones.
    Early,
    /// Another observation of the same name is known. The first one stays.
    Conflicting,
}

/// Which observations of an origin are known: all before the first missing one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// The origin.
    pub origin: Origin,
    /// The first sequence number that is missing.
    pub next: u64,
}

/// All observations that a participant knows, its own and those of others.
///
/// Those of an origin are known from the first one on, without a gap; observations after a missing one are not stored.
/// So the size of a log does not depend on the sequence numbers that others send. Observations that are stored
/// elsewhere may be released: they stay known, and take no memory.
#[derive(Clone, Debug, Default)]
pub struct ObservationLog {
    logs: BTreeMap<Origin, Known>,
    /// Number of known incarnations of each source.
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

/// The observations of one origin; at least one is known.
#[derive(Clone, Debug)]
struct Known {
    first: Arc<Observation>,
    /// Number of observations, from the first on, that are known and no longer held.
    released: u64,
    /// Those after them; the last one is always held.
    held: Vec<Arc<Observation>>,
}

impl Known {
    fn next(&self) -> u64 {
        self.released + self.held.len() as u64
    }

    /// Those held from a sequence number on; `None` if that one is not held.
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

    /// The result that an insertion would have. An observation whose name is that of a released one is not compared
    /// with it.
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

    /// The first and last known observation of an origin; `None` if none is known.
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

    /// The version vector: what is known, by origin.
    pub fn versions(&self) -> impl Iterator<Item = Version> + '_ {
        self.logs.iter().map(|(&origin, known)| Version { origin, next: known.next() })
    }

    /// Whether a participant with this version vector knows all that is known here.
    #[must_use]
    pub fn is_known_to(&self, reported: &[Version]) -> bool {
        let reported: BTreeMap<Origin, u64> =
            reported.iter().map(|version| (version.origin, version.next)).collect();
        self.versions().all(|own| reported.get(&own.origin).is_some_and(|&next| next >= own.next))
    }

    /// Number of known incarnations of a source.
    #[must_use]
    pub fn incarnations(&self, source: Source) -> usize {
        self.incarnations.get(&source).copied().unwrap_or_default()
    }

    /// Observations of an origin from a sequence number on, in order; none if that one is missing or released.
    #[must_use]
    pub fn since(&self, origin: Origin, first: u64) -> &[Arc<Observation>] {
        self.logs.get(&origin).and_then(|known| known.since(first)).unwrap_or_default()
    }

    /// Keeps at most the last `held` observations of each origin in memory.
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
    fn observations_after_a_gap_count_once_the_gap_is_filled() {
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
    fn released_observations_stay_known_and_leave_memory() {
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
    fn a_larger_version_vector_covers_all() {
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
