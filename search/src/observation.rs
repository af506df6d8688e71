//! Observations, and the log that counts each exactly once.

use std::collections::BTreeMap;
use std::sync::Arc;

use xxhash_rust::xxh3::xxh3_64;

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
    /// Another one of the same name is known. The first stays.
    Conflicting,
}

/// Which observations of an origin are known: all before the first one that is missing, and some later ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// Whose observations.
    pub origin: Origin,
    /// The first sequence number that is missing.
    pub next: u64,
    /// A hash of the later ones that are known; 0 if none is. What is missing may be missing for ever, as when the robot
    /// that knew it lost its memory: then what came after it is known to some and not to others, and `next` does not tell.
    pub beyond: u64,
}

impl Version {
    /// Whether somebody at this version may know what is missing at another of the same origin.
    #[must_use]
    pub const fn may_help(self, other: Self) -> bool {
        self.next > other.next || self.beyond != 0 && self.beyond != other.beyond
    }
}

/// All observations known to a robot, its own and others'.
#[derive(Clone, Debug, Default)]
pub struct ObservationLog {
    logs: BTreeMap<Origin, Log>,
}

/// Of one origin.
#[derive(Clone, Debug, Default)]
struct Log {
    next: u64,
    observations: BTreeMap<u64, Arc<Observation>>,
}

impl ObservationLog {
    /// Offers an observation; it is kept if it is new.
    pub fn insert(&mut self, observation: Arc<Observation>) -> Entry {
        let log = self.logs.entry(observation.origin).or_default();
        if let Some(known) = log.observations.get(&observation.sequence) {
            return if *known == observation { Entry::Known } else { Entry::Conflicting };
        }
        log.observations.insert(observation.sequence, observation);
        while log.observations.contains_key(&log.next) {
            log.next += 1;
        }
        Entry::New
    }

    /// The first sequence number of an origin that is missing.
    #[must_use]
    pub fn next(&self, origin: Origin) -> u64 {
        self.logs.get(&origin).map_or(0, |log| log.next)
    }

    /// Whether later observations of an origin are known than one that is missing.
    #[must_use]
    pub fn has_gap(&self, origin: Origin) -> bool {
        self.logs
            .get(&origin)
            .is_some_and(|log| log.observations.last_key_value().is_some_and(|(&last, _)| last >= log.next))
    }

    /// What is known of an origin.
    #[must_use]
    pub fn version(&self, origin: Origin) -> Version {
        let (next, beyond) = self.logs.get(&origin).map_or((0, 0), |log| (log.next, log.beyond()));
        Version { origin, next, beyond }
    }

    /// What is known, by origin.
    pub fn versions(&self) -> impl Iterator<Item = Version> + '_ {
        self.logs.keys().map(|&origin| self.version(origin))
    }

    /// Known observations of an origin from a sequence number on, in order.
    pub fn since(&self, origin: Origin, first: u64) -> impl Iterator<Item = &Arc<Observation>> + '_ {
        self.logs
            .get(&origin)
            .into_iter()
            .flat_map(move |log| log.observations.range(first..).map(|(_, observation)| observation))
    }

    /// Number of observations known.
    #[must_use]
    pub fn len(&self) -> usize {
        self.logs.values().map(|log| log.observations.len()).sum()
    }

    /// Whether none is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Log {
    /// [`Version::beyond`]: the sum of a hash of each.
    fn beyond(&self) -> u64 {
        let later =
            self.observations.range(self.next..).map(|(sequence, _)| xxh3_64(&sequence.to_le_bytes()));
        later.fold(0, u64::wrapping_add)
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
    fn what_lies_beyond_a_gap_is_told() {
        let of = |sequences: &[u64]| {
            let mut log = ObservationLog::default();
            for &sequence in sequences {
                log.insert(observation(sequence, 0));
            }
            log.version(SEVEN)
        };
        let [none, five, six, both] = [&[0][..], &[0, 5], &[0, 6], &[0, 5, 6]].map(of);
        assert_eq!((none.next, none.beyond), (1, 0));
        assert!(five.may_help(none) && five.may_help(six) && six.may_help(five) && both.may_help(five));
        assert!(!none.may_help(five) && !five.may_help(five));
        assert!(five.may_help(of(&[0, 1, 2])) && of(&[0, 1, 2]).may_help(five));
    }

    #[test]
    fn a_gap_shows_until_it_is_filled() {
        let mut log = ObservationLog::default();
        log.insert(observation(0, 0));
        log.insert(observation(2, 0));
        assert_eq!((log.next(SEVEN), log.has_gap(SEVEN)), (1, true));
        log.insert(observation(1, 0));
        assert_eq!((log.next(SEVEN), log.has_gap(SEVEN)), (3, false));
        let since: Vec<u64> = log.since(SEVEN, 1).map(|known| known.sequence).collect();
        assert_eq!(since, [1, 2]);
        let again = Origin { incarnation: 5, ..SEVEN };
        assert_eq!(log.next(again), 0);
        assert_eq!(
            log.insert(Arc::new(Observation { origin: again, ..(*observation(0, 0)).clone() })),
            Entry::New
        );
        assert_eq!(log.versions().map(|version| version.next).collect::<Vec<_>>(), [3, 1]);
    }
}
