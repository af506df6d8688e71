//! What an observation can be: where a robot can stand, what its sensor can give there, when, and how fast it gets on.
//!
//! Robots and coordinator hold every observation against the same [`Limits`], a robot its own too. Whoever lies within
//! them is believed.
//!
//! An observation counts only after all before it of its origin have counted ([`crate::replica`]), and each is held against
//! itself, the one before it and the first one. So what is believed of an origin is the longest part of its log, from the
//! beginning, in which each is possible: a function of what the origin has said, not of the order in which messages come.
//! Two that hear the same, late, twice or in whatever order, come to believe the same.
//!
//! The clock alone differs between participants. What is dated in the future is therefore not judged: it is not taken
//! now, and asked for again like anything that was lost, until it is no longer in the future.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Mission, Scenario};
use dragnet_search::evidence::Reading;
use dragnet_search::observation::{Ends, Observation, RobotId, Source};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

use crate::command::Mark;

/// So many times as fast as the mission's speed may a robot be: its clock drifts, its wheels are new.
pub const SPEED_TOLERANCE: f64 = 1.1;
/// Between two looks a robot may get so many cells further than its speed allows, cells: that it stands in a cell says no
/// more than that it is somewhere in there.
const PLACE_TOLERANCE_CELLS: f64 = 2.0;
/// So many looks, one after another, need no time.
const LOOKS_AT_ONCE: u64 = 16;
/// So many looks may a robot take in the time in which it crosses a cell at full speed. A robot looks once in a cell; if
/// it could look as often as it likes, it could make anything certain.
const LOOKS_PER_CELL: f64 = 2.0;
/// A reading may be so many standard deviations off: one in 10^15 is.
const DEVIATIONS: f64 = 8.0;
/// A reading may claim to be so much more precise than the sensor's model, of its variance.
const VARIANCE_TOLERANCE: f32 = 0.01;

/// Why an observation, or a message, does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rejection {
    /// Its robot is not of the team.
    Stranger,
    /// Another one of the same name is known; the first stays.
    Conflicting,
    /// Its robot stands where none can.
    Blocked,
    /// A cell is farther away than the sensor sees.
    OutOfSight,
    /// A cell is read twice in one look.
    Repeated,
    /// A reading claims to be more precise than the sensor can be at that distance.
    TooPrecise,
    /// A reading's value cannot be, at its variance.
    TooFarOff,
    /// It is dated later than now, by more than clocks may differ. Not for ever: it is asked for again.
    Future,
    /// It is dated before the one before it.
    Backwards,
    /// The robot cannot have got there since the one before it.
    TooFast,
    /// The robot looks more often than it can enter cells.
    TooOften,
    /// It is told as a person's, and no person can mark a cell so.
    NoMark,
    /// The robot has started anew too often.
    TooManyStarts,
}

impl fmt::Display for Rejection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Stranger => "the robot is not of the team",
            Self::Conflicting => {
                "another observation of the same name is known: do two robots share a number?"
            }
            Self::Blocked => "the robot says that it stands where none can",
            Self::OutOfSight => {
                "a cell is out of the sensor's sight from where the robot says that it stands"
            }
            Self::Repeated => "a cell is read twice in one look",
            Self::TooPrecise => {
                "a reading is more precise than the scenario's sensor can be at that distance"
            }
            Self::TooFarOff => "a reading's value cannot be, at its variance",
            Self::Future => "it is dated in the future, beyond mission.max_clock_skew_seconds",
            Self::Backwards => "it is dated before the one before it",
            Self::TooFast => "the robot cannot be there yet at mission.speed_meters_per_second",
            Self::TooOften => "the robot looks more often than it can enter cells",
            Self::NoMark => "it is told as a person's, and no person can mark a cell so",
            Self::TooManyStarts => "the robot has started anew too often",
        })
    }
}

/// Something that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rejected {
    /// Who said it.
    pub from: Participant,
    /// Of whom: in a sync reply anybody may quote anybody.
    pub of: Source,
    /// Why.
    pub why: Rejection,
}

impl fmt::Display for Rejected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "refused what {} says that {} saw: {}", self.from, self.of, self.why)
    }
}

/// Refusals that are counted as one: those who are not of the team, of whom there may be any number, are not told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Refusal {
    /// Who said it; `None` if it is not of the team.
    pub from: Option<Participant>,
    /// Of whom; `None` if it is not of the team.
    pub of: Option<Source>,
    /// Why.
    pub why: Rejection,
}

impl fmt::Display for Refusal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = self.from.map_or_else(|| "a stranger".to_owned(), |from| from.to_string());
        let of = self.of.map_or_else(|| "a stranger".to_owned(), |of| of.to_string());
        write!(formatter, "refused what {from} says that {of} saw: {}", self.why)
    }
}

/// What can be in one mission.
#[derive(Clone, Debug)]
pub struct Limits {
    terrain: Arc<Terrain>,
    sensor: Arc<Sensor>,
    team: BTreeSet<RobotId>,
    speed_meters_per_second: f64,
    clock_tolerance: Duration,
}

impl Limits {
    /// Those of a mission of this team, on this map, with this sensor.
    #[must_use]
    pub fn new(
        terrain: Arc<Terrain>,
        sensor: Arc<Sensor>,
        team: impl IntoIterator<Item = RobotId>,
        mission: &Mission,
    ) -> Self {
        Self {
            terrain,
            sensor,
            team: team.into_iter().collect(),
            speed_meters_per_second: mission.speed_meters_per_second,
            clock_tolerance: mission.clock_tolerance,
        }
    }

    /// Those of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let (terrain, sensor) = (scenario.terrain().clone(), scenario.sensor().clone());
        let team = scenario.robots().iter().map(|robot| robot.id);
        Self::new(Arc::new(terrain), Arc::new(sensor), team, scenario.mission())
    }

    /// Whether somebody has a part in the mission.
    #[must_use]
    pub fn knows(&self, who: Participant) -> bool {
        match who {
            Participant::Robot(robot) => self.team.contains(&robot),
            Participant::Coordinator => true,
        }
    }

    /// Whether anybody may tell observations of a source: of the team's robots, and what a person has marked.
    #[must_use]
    pub fn counts(&self, source: Source) -> bool {
        match source {
            Source::Operator => true,
            Source::Robot(robot) => self.team.contains(&robot),
        }
    }

    /// Whether an observation can be: by itself, and after those that are known of its origin, if any are.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn check(&self, observation: &Observation, known: Option<Ends<'_>>) -> Result<(), Rejection> {
        if observation.origin.source == Source::Operator {
            return check_mark(observation, known);
        }
        self.check_look(observation)?;
        let Some(known) = known else { return Ok(()) };
        self.check_way(known.last, observation)?;
        self.check_rate(known.first, observation)
    }

    /// Whether an observation may be dated so.
    ///
    /// # Errors
    /// If it is in the future.
    pub fn check_date(&self, now: MissionTime, observation: &Observation) -> Result<(), Rejection> {
        if MissionTime(observation.time_ns) > now + self.clock_tolerance {
            return Err(Rejection::Future);
        }
        Ok(())
    }

    fn check_look(&self, observation: &Observation) -> Result<(), Rejection> {
        if !self.counts(observation.origin.source) {
            return Err(Rejection::Stranger);
        }
        if !self.terrain.is_traversable(observation.from) {
            return Err(Rejection::Blocked);
        }
        let mut seen = BTreeSet::new();
        for reading in &observation.readings {
            if !seen.insert(reading.cell) {
                return Err(Rejection::Repeated);
            }
            self.check_reading(observation, reading)?;
        }
        Ok(())
    }

    fn check_reading(&self, observation: &Observation, reading: &Reading) -> Result<(), Rejection> {
        let distance = self.terrain.grid().manhattan(observation.from, reading.cell);
        if distance > self.sensor.radius() {
            return Err(Rejection::OutOfSight);
        }
        if reading.variance < self.sensor.variance(distance) * (1.0 - VARIANCE_TOLERANCE) {
            return Err(Rejection::TooPrecise);
        }
        let off = DEVIATIONS * f64::from(reading.variance).sqrt();
        if !(-off..=1.0 + off).contains(&f64::from(reading.value)) {
            return Err(Rejection::TooFarOff);
        }
        Ok(())
    }

    /// The straight line is the shortest way, whatever is in between.
    fn check_way(&self, before: &Observation, observation: &Observation) -> Result<(), Rejection> {
        if observation.time_ns < before.time_ns {
            return Err(Rejection::Backwards);
        }
        let cells = self.terrain.grid().offset(before.from, observation.from).euclidean();
        if cells > self.cells_in(before, observation) * SPEED_TOLERANCE + PLACE_TOLERANCE_CELLS {
            return Err(Rejection::TooFast);
        }
        Ok(())
    }

    fn check_rate(&self, first: &Observation, observation: &Observation) -> Result<(), Rejection> {
        let looks = observation.sequence.saturating_sub(LOOKS_AT_ONCE) as f64;
        if looks > self.cells_in(first, observation) * SPEED_TOLERANCE * LOOKS_PER_CELL {
            return Err(Rejection::TooOften);
        }
        Ok(())
    }

    /// Cells that a robot crosses between two observations, at full speed.
    fn cells_in(&self, from: &Observation, to: &Observation) -> f64 {
        let time = MissionTime(to.time_ns).since(MissionTime(from.time_ns));
        time.as_secs_f64() * self.speed_meters_per_second / self.terrain.cell_meters()
    }
}

/// A person marks any cell, one at a time, whatever is there; one mark after another.
fn check_mark(observation: &Observation, known: Option<Ends<'_>>) -> Result<(), Rejection> {
    let is_mark = |mark: Mark| observation.readings[..] == [mark.reading(observation.from)];
    if !Mark::ALL.into_iter().any(is_mark) {
        return Err(Rejection::NoMark);
    }
    match known {
        Some(known) if observation.time_ns < known.last.time_ns => Err(Rejection::Backwards),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
