//! Observations, and a log that counts each of them exactly once.

use std::cmp::Ordering;
use std::fmt;
use std::num::{NonZeroU16, NonZeroUsize};
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use xxhash_rust::xxh3::xxh3_128;

use crate::cell::Cell;
use crate::evidence::{Digest, Reading};
use crate::object_position::ObjectPosition;

/// A robot of the team, by its number. Numbers start at 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RobotId(NonZeroU16);

impl RobotId {
    /// The first of a team.
    pub const FIRST: Self = Self(NonZeroU16::MIN);

    /// The robot with a number; `None` for 0.
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

impl Source {
    /// The source with a number: 0 is the operator, all others are robots.
    #[must_use]
    pub fn numbered(number: u16) -> Self {
        RobotId::new(number).map_or(Self::Operator, Self::Robot)
    }

    /// Its number in messages and in stored observations.
    #[must_use]
    pub const fn number(self) -> u16 {
        match self {
            Self::Operator => 0,
            Self::Robot(robot) => robot.number(),
        }
    }

    const fn slot(self) -> usize {
        self.number() as usize
    }
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
/// A robot that restarts numbers its observations from 0 under a new origin, even if it has stored earlier ones: the
/// last stored observation may not be the last published one, for example if the disk was full, and an identifier must
/// never denote two observations.
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

/// All readings taken from one cell at one time. `(origin, sequence)` identifies it permanently.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The robot's origin.
    pub origin: Origin,
    /// The number of the observation: observations of an origin are numbered from 0 without a gap.
    pub sequence: u64,
    /// When it was made, nanoseconds of mission time. It bounds the robot's speed since its previous observation, and
    /// shows how long the robot stands still; the meaning of the readings does not depend on it.
    pub time_ns: u64,
    /// The robot's cell.
    pub from: Cell,
    /// The readings.
    pub readings: Vec<Reading>,
    /// Positions of objects that the robot has declared, new or better known than before; mostly none.
    pub positions: Box<[ObjectPosition]>,
}

impl Observation {
    /// A hash of all of it: equal observations have equal digests on every machine.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let Self { origin, sequence, time_ns, from, readings, positions } = self;
        let mut bytes = Vec::with_capacity(30 + 12 * readings.len());
        bytes.extend(origin.source.number().to_le_bytes());
        for number in [origin.incarnation, *sequence, *time_ns] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(from.number().to_le_bytes());
        for Reading { cell, value, variance } in readings {
            bytes.extend(cell.number().to_le_bytes());
            bytes.extend(value.to_bits().to_le_bytes());
            bytes.extend(variance.to_bits().to_le_bytes());
        }
        // Their number tells them from readings, of 12 bytes each.
        if !positions.is_empty() {
            bytes.push(u8::try_from(positions.len()).unwrap_or(u8::MAX));
        }
        for position in positions {
            let (east, north) = position.meters();
            bytes.extend(position.cell().number().to_le_bytes());
            bytes.extend([east, north].map(|meters| meters.to_bits().to_le_bytes()).as_flattened());
            let covariance = position.covariance_square_meters();
            bytes.extend(covariance.map(|entry| entry.to_bits().to_le_bytes()).as_flattened());
        }
        Digest(xxh3_128(&bytes))
    }
}

/// The result of inserting an observation into a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// It is new: its readings count from now on.
    New,
    /// It is known: its readings already count.
    Known,
    /// An earlier one is missing: this one is not stored. It will be received again with the missing ones.
    Early,
    /// Another observation with the same identifier is known, and is kept.
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

/// A version vector, by origin: which observations a participant knows. Copies share one list.
#[derive(Clone, Debug)]
pub struct Versions(Arc<VersionList>);

#[derive(Debug)]
struct VersionList {
    list: Vec<Version>,
    fingerprint: Fingerprint,
    /// The first participant's knowledge that was seen to cover the list: others of its process mostly have the same.
    covering: OnceLock<Fingerprint>,
    /// Likewise the first knowledge that was compared with the list, and whether the list covers it.
    covered: OnceLock<(Fingerprint, bool)>,
}

impl Versions {
    /// A list in order.
    fn new(list: Vec<Version>, fingerprint: Fingerprint) -> Self {
        let (covering, covered) = (OnceLock::new(), OnceLock::new());
        Self(Arc::new(VersionList { list, fingerprint, covering, covered }))
    }
}

impl PartialEq for Versions {
    fn eq(&self, other: &Self) -> bool {
        self.0.list == other.0.list
    }
}

impl Eq for Versions {}

impl FromIterator<Version> for Versions {
    fn from_iter<I: IntoIterator<Item = Version>>(versions: I) -> Self {
        let mut list: Vec<Version> = versions.into_iter().collect();
        list.sort_by_key(|version| version.origin);
        let fingerprint = list.iter().fold(Fingerprint::default(), |sum, &version| sum.with(version));
        Self::new(list, fingerprint)
    }
}

impl From<Vec<Version>> for Versions {
    fn from(versions: Vec<Version>) -> Self {
        versions.into_iter().collect()
    }
}

impl Default for Versions {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl Deref for Versions {
    type Target = [Version];

    fn deref(&self) -> &[Version] {
        &self.0.list
    }
}

/// The sum of the hashes of versions, in any order: one more observation subtracts a hash and adds another. Equal sums are
/// taken for equal version vectors; at 128 bits, different vectors do not have equal sums by chance. A participant that
/// constructs such a vector is not asked for what it knows, like one that sends no heartbeats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Fingerprint(u128);

impl Fingerprint {
    fn with(self, version: Version) -> Self {
        Self(self.0.wrapping_add(Self::hash(version)))
    }

    fn without(self, version: Version) -> Self {
        Self(self.0.wrapping_sub(Self::hash(version)))
    }

    fn hash(Version { origin, next }: Version) -> u128 {
        let mut bytes = [0; 18];
        bytes[..2].copy_from_slice(&origin.source.number().to_le_bytes());
        bytes[2..10].copy_from_slice(&origin.incarnation.to_le_bytes());
        bytes[10..].copy_from_slice(&next.to_le_bytes());
        xxh3_128(&bytes)
    }
}

/// All observations that a participant knows, its own and those of others.
///
/// Those of an origin are known from the first one on, without a gap; observations after a missing one are not stored.
/// So the size of a log does not depend on the sequence numbers that others send. Observations that are stored
/// elsewhere may be released: they stay known, and take no memory.
#[derive(Clone, Debug, Default)]
pub struct ObservationLog {
    /// By [`Source::slot`]; of each source by incarnation. Most have one. Copies share what neither has changed.
    sources: Vec<Arc<Vec<(u64, Known)>>>,
    /// Number of known observations.
    count: u64,
    fingerprint: Fingerprint,
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
            let Origin { source, incarnation } = observation.origin;
            if source.slot() >= self.sources.len() {
                self.sources.resize_with(source.slot() + 1, Arc::default);
            }
            let starts = Arc::make_mut(&mut self.sources[source.slot()]);
            let start = starts.partition_point(|&(known, _)| known < incarnation);
            if starts.get(start).is_none_or(|&(known, _)| known != incarnation) {
                let first = Arc::clone(&observation);
                starts.insert(start, (incarnation, Known { first, released: 0, held: Vec::new() }));
            }
            let (origin, known) = (observation.origin, &mut starts[start].1);
            let next = known.next();
            known.held.push(observation);
            self.count += 1;
            if next > 0 {
                self.fingerprint = self.fingerprint.without(Version { origin, next });
            }
            self.fingerprint = self.fingerprint.with(Version { origin, next: next + 1 });
        }
        entry
    }

    /// The result that an insertion would have. An observation whose name is that of a released one is not compared
    /// with it.
    #[must_use]
    pub fn entry(&self, observation: &Observation) -> Entry {
        let known = self.known(observation.origin);
        let held = known.and_then(|known| known.since(observation.sequence)?.first());
        match held {
            Some(held) if std::ptr::eq(&raw const **held, observation) || **held == *observation => {
                Entry::Known
            }
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
        let known = self.known(origin)?;
        Some(Ends { first: &known.first, last: known.held.last()? })
    }

    /// The first sequence number of an origin that is missing.
    #[must_use]
    pub fn next(&self, origin: Origin) -> u64 {
        self.known(origin).map_or(0, Known::next)
    }

    fn known(&self, origin: Origin) -> Option<&Known> {
        let starts = self.sources.get(origin.source.slot())?;
        let start = starts.binary_search_by_key(&origin.incarnation, |&(incarnation, _)| incarnation).ok()?;
        Some(&starts[start].1)
    }

    /// The last known observation of a robot's last start.
    #[must_use]
    pub fn latest(&self, robot: RobotId) -> Option<&Observation> {
        let (_, known) = self.sources.get(Source::Robot(robot).slot())?.last()?;
        known.held.last().map(|observation| &**observation)
    }

    /// The version vector: the known observations, by origin.
    #[must_use]
    pub fn versions(&self) -> Versions {
        Versions::new(self.each().collect(), self.fingerprint)
    }

    fn each(&self) -> impl Iterator<Item = Version> {
        (0..=u16::MAX).map(Source::numbered).zip(&self.sources).flat_map(|(source, starts)| {
            starts.iter().map(move |&(incarnation, ref known)| Version {
                origin: Origin { source, incarnation },
                next: known.next(),
            })
        })
    }

    /// The origins of which a participant with this version vector knows observations that are missing here.
    #[must_use]
    pub fn missing(&self, reported: &Versions) -> Vec<Origin> {
        let VersionList { list, fingerprint, covering, .. } = &*reported.0;
        if self.fingerprint == *fingerprint || covering.get() == Some(&self.fingerprint) {
            return Vec::new();
        }
        let is_missing = |version: &&Version| version.next > self.next(version.origin);
        let missing: Vec<Origin> = list.iter().filter(is_missing).map(|version| version.origin).collect();
        if missing.is_empty() {
            covering.get_or_init(|| self.fingerprint);
        }
        missing
    }

    /// Whether a participant with this version vector knows all that is known here.
    #[must_use]
    pub fn is_known_to(&self, reported: &Versions) -> bool {
        let VersionList { list, fingerprint, covered, .. } = &*reported.0;
        if self.fingerprint == *fingerprint {
            return true;
        }
        let known = || {
            // Both are in order.
            let mut reported = list.iter();
            self.each().all(|own| {
                reported
                    .find(|version| version.origin >= own.origin)
                    .is_some_and(|version| version.origin == own.origin && version.next >= own.next)
            })
        };
        let &(compared, is_known) = covered.get_or_init(|| (self.fingerprint, known()));
        if compared == self.fingerprint { is_known } else { known() }
    }

    /// Number of known incarnations of a source.
    #[must_use]
    pub fn incarnations(&self, source: Source) -> usize {
        self.sources.get(source.slot()).map_or(0, |starts| starts.len())
    }

    /// Observations of an origin from a sequence number on, in order; none if that one is missing or released.
    #[must_use]
    pub fn since(&self, origin: Origin, first: u64) -> &[Arc<Observation>] {
        self.known(origin).and_then(|known| known.since(first)).unwrap_or_default()
    }

    /// Keeps at most the last `held` observations of each origin in memory.
    pub fn release(&mut self, held: NonZeroUsize) {
        for (_, known) in self.sources.iter_mut().flat_map(Arc::make_mut) {
            let surplus = known.held.len().saturating_sub(held.get());
            known.held.drain(..surplus);
            known.released += surplus as u64;
        }
    }

    /// Number of observations known.
    #[must_use]
    pub const fn len(&self) -> u64 {
        self.count
    }

    /// Whether none is known.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Grid;

    const SEVEN: Origin = Origin::first(RobotId::new(7).unwrap());

    fn observation(sequence: u64, time_ns: u64) -> Arc<Observation> {
        let from = Grid::new(1, 1).unwrap().cells().next().unwrap();
        Arc::new(Observation {
            origin: SEVEN,
            sequence,
            time_ns,
            from,
            readings: Vec::new(),
            positions: Box::default(),
        })
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
        assert_eq!(log.versions().iter().map(|version| version.next).collect::<Vec<_>>(), [1, 1]);
        assert_eq!((log.incarnations(SEVEN.source), log.incarnations(Source::Operator)), (2, 0));
    }

    #[test]
    fn a_larger_version_vector_covers_all() {
        let mut log = ObservationLog::default();
        assert!(log.is_known_to(&Versions::default()));
        log.insert(observation(0, 0));
        let version = |origin, next| Version { origin, next };
        let other = Origin::first(RobotId::new(8).unwrap());
        assert!(log.is_known_to(&vec![version(other, 9), version(SEVEN, 1)].into()));
        assert!(!log.is_known_to(&vec![version(other, 9), version(SEVEN, 0)].into()));
        assert!(!log.is_known_to(&vec![version(other, 9)].into()));
    }

    #[test]
    fn the_same_versions_are_told_by_their_fingerprint_however_they_came_about() {
        let mut log = ObservationLog::default();
        for sequence in 0..3 {
            log.insert(observation(sequence, 0));
        }
        let told = |next| Versions::from(vec![Version { origin: SEVEN, next }]);
        assert_eq!(log.versions().0.fingerprint, told(3).0.fingerprint);
        assert_eq!(log.versions(), told(3));
    }

    #[test]
    fn what_is_missing_is_told_of_each_log_that_one_version_vector_meets() {
        let mut log = ObservationLog::default();
        (0..3).for_each(|sequence| assert_eq!(log.insert(observation(sequence, 0)), Entry::New));
        let told = |next| Versions::from(vec![Version { origin: SEVEN, next }]);
        let (less, same, more) = (told(2), told(3), told(4));
        let mut later = log.clone();
        later.insert(observation(3, 0));
        // Once more, when the first answer is remembered.
        for _ in 0..2 {
            let missing = [&less, &same, &more].map(|versions| log.missing(versions).len());
            assert_eq!(missing, [0, 0, 1]);
            let missing = [&less, &same, &more].map(|versions| later.missing(versions).len());
            assert_eq!(missing, [0, 0, 0]);
            assert_eq!([&less, &same, &more].map(|versions| log.is_known_to(versions)), [false, true, true]);
            assert_eq!(
                [&less, &same, &more].map(|versions| later.is_known_to(versions)),
                [false, false, true]
            );
        }
    }
}
