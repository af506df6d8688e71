//! Observations, and the log that counts each exactly once.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::cell::Cell;
use crate::evidence::Reading;

/// A robot of the team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RobotId(pub u16);

impl RobotId {
    /// Not a robot: a person, who marks cells by hand. Robots count from 1.
    pub const BY_HAND: Self = Self(0);
}

impl std::fmt::Display for RobotId {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}", self.0)
    }
}

/// A robot from one of its starts on: what it sees is numbered by it.
///
/// One that starts again counts anew under another origin, whatever it remembers: what it remembers last need not be the
/// last that it told, as when its disk was full, and no name may ever stand for two observations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// Which robot.
    pub robot: RobotId,
    /// When it started, nanoseconds of mission time by its own clock; later than every start that it remembers.
    pub incarnation: u64,
}

impl Origin {
    /// That of a robot that started with the mission.
    #[must_use]
    pub const fn first(robot: RobotId) -> Self {
        Self { robot, incarnation: 0 }
    }
}

/// All readings of one look. `(origin, sequence)` names it for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Who looked.
    pub origin: Origin,
    /// Counts the observations of that origin from 0 without a gap.
    pub sequence: u64,
    /// When, nanoseconds of mission time. Told to viewers; no decision uses it.
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
/// from. So a log is as long as what it holds, whatever numbers others invent.
#[derive(Clone, Debug, Default)]
pub struct ObservationLog {
    logs: BTreeMap<Origin, Vec<Arc<Observation>>>,
}

impl ObservationLog {
    /// Offers an observation; it is kept if it is new.
    pub fn insert(&mut self, observation: Arc<Observation>) -> Entry {
        let entry = self.entry(&observation);
        if entry == Entry::New {
            self.logs.entry(observation.origin).or_default().push(observation);
        }
        entry
    }

    /// What would become of an observation.
    #[must_use]
    pub fn entry(&self, observation: &Observation) -> Entry {
        let log = self.of(observation.origin);
        let known = usize::try_from(observation.sequence).ok().and_then(|place| log.get(place));
        match known {
            Some(known) if **known == *observation => Entry::Known,
            Some(_) => Entry::Conflicting,
            None if observation.sequence == log.len() as u64 => Entry::New,
            None => Entry::Early,
        }
    }

    /// Known observations of an origin, in order.
    #[must_use]
    pub fn of(&self, origin: Origin) -> &[Arc<Observation>] {
        self.logs.get(&origin).map_or(&[], Vec::as_slice)
    }

    /// The first sequence number of an origin that is missing.
    #[must_use]
    pub fn next(&self, origin: Origin) -> u64 {
        self.of(origin).len() as u64
    }

    /// What is known, by origin.
    pub fn versions(&self) -> impl Iterator<Item = Version> + '_ {
        self.logs.iter().map(|(&origin, log)| Version { origin, next: log.len() as u64 })
    }

    /// Whether somebody who tells these versions knows all that is known here.
    #[must_use]
    pub fn is_known_to(&self, told: &[Version]) -> bool {
        let told: BTreeMap<Origin, u64> = told.iter().map(|version| (version.origin, version.next)).collect();
        self.versions().all(|own| told.get(&own.origin).is_some_and(|&next| next >= own.next))
    }

    /// Incarnations of a robot of which something is known.
    #[must_use]
    pub fn incarnations(&self, robot: RobotId) -> usize {
        let [first, last] = [0, u64::MAX].map(|incarnation| Origin { robot, incarnation });
        self.logs.range(first..=last).count()
    }

    /// Known observations of an origin from a sequence number on, in order.
    #[must_use]
    pub fn since(&self, origin: Origin, first: u64) -> &[Arc<Observation>] {
        let first = usize::try_from(first).unwrap_or(usize::MAX);
        self.of(origin).get(first..).unwrap_or_default()
    }

    /// Number of observations known.
    #[must_use]
    pub fn len(&self) -> usize {
        self.logs.values().map(Vec::len).sum()
    }

    /// Whether none is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Grid;

    const SEVEN: Origin = Origin::first(RobotId(7));

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
    fn each_incarnation_counts_from_zero() {
        let mut log = ObservationLog::default();
        log.insert(observation(0, 0));
        let again = Origin { incarnation: 5, ..SEVEN };
        let first = Observation { origin: again, ..(*observation(0, 0)).clone() };
        assert_eq!((log.next(again), log.insert(Arc::new(first))), (0, Entry::New));
        assert_eq!(log.versions().map(|version| version.next).collect::<Vec<_>>(), [1, 1]);
        assert_eq!((log.incarnations(RobotId(7)), log.incarnations(RobotId(8))), (2, 0));
    }

    #[test]
    fn who_knows_more_knows_all() {
        let mut log = ObservationLog::default();
        assert!(log.is_known_to(&[]));
        log.insert(observation(0, 0));
        let version = |origin, next| Version { origin, next };
        let other = Origin::first(RobotId(8));
        assert!(log.is_known_to(&[version(other, 9), version(SEVEN, 1)]));
        assert!(!log.is_known_to(&[version(other, 9), version(SEVEN, 0)]));
        assert!(!log.is_known_to(&[version(other, 9)]));
    }
}
