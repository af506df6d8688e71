//! Validation of observations: possible positions of a robot, possible readings of its sensor, dates, and speed.
//!
//! Robots and the coordinator validate every observation by the same [`Limits`], including a robot's own. Observations
//! within the limits are accepted.
//!
//! An observation counts only after all before it of its origin have counted ([`crate::replica`]), and each is
//! validated by itself, by the one before it and by the first one. So the accepted part of an origin's log is its
//! longest valid prefix: a function of what was published, not of the order of arrival. Two participants that receive
//! the same observations, late, repeated or in any order, accept the same ones.
//!
//! Only the clock differs between participants. An observation that is dated in the future is therefore neither
//! accepted nor finally rejected: it is requested again like a lost one, until it is no longer in the future.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Class, Scenario};
use dragnet_search::evidence::Reading;
use dragnet_search::observation::{Ends, Observation, RobotId, Source};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

/// Factor by which a robot may exceed the mission's speed, because of clock drift and of wheels that are larger than nominal.
pub const SPEED_TOLERANCE: f64 = 1.1;
/// Cells by which a robot may get further between two observations than its speed allows: its position within its cell
/// is unknown.
const PLACE_TOLERANCE_CELLS: f64 = 2.0;
/// The number of consecutive observations that may have the same time.
const OBSERVATIONS_AT_ONCE: u64 = 16;
/// Observations that a robot may make in the time in which it crosses a cell at full speed. A robot observes once per
/// cell; unlimited observations could make any cell certain.
const OBSERVATIONS_PER_CELL: f64 = 2.0;
/// Maximum error of a reading, standard deviations: one reading in 10^15 exceeds it.
const DEVIATIONS: f64 = 8.0;
/// Share of the variance of the sensor's model by which a reading may be more precise.
const VARIANCE_TOLERANCE: f32 = 0.01;

/// Why an observation or a message does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rejection {
    /// Its robot is not of the team.
    Stranger,
    /// Another observation with the same identifier is known, and is kept.
    Conflicting,
    /// Its robot is in a cell that is not traversable.
    Blocked,
    /// A cell is farther away than the sensor radius.
    OutOfSight,
    /// A cell is read twice in one observation.
    Repeated,
    /// The position of an object is more than a cell beside the cell in which it is declared.
    Misplaced,
    /// A reading is more precise than the sensor can be at that distance.
    TooPrecise,
    /// A reading's value is impossible at its variance.
    TooFarOff,
    /// It is dated later than now, by more than the allowed clock skew. Not final: it is requested again.
    Future,
    /// It is dated before the previous one.
    Backwards,
    /// The robot cannot have reached its cell since the previous observation.
    TooFast,
    /// The robot observes more often than it can enter cells.
    TooOften,
    /// The robot has restarted too often.
    TooManyStarts,
}

impl fmt::Display for Rejection {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Stranger => "the robot is not of the team",
            Self::Conflicting => {
                "another observation with the same number is known: do two robots share a number?"
            }
            Self::Blocked => "the robot's cell is not traversable",
            Self::OutOfSight => "a cell is out of the sensor's view from the robot's cell",
            Self::Repeated => "a cell is read twice in one observation",
            Self::Misplaced => "the position of an object is more than a cell beside the object's cell",
            Self::TooPrecise => {
                "a reading is more precise than the scenario's sensor can be at that distance"
            }
            Self::TooFarOff => "a reading's value is impossible at its variance",
            Self::Future => "it is dated in the future, beyond mission.max_clock_skew_seconds",
            Self::Backwards => "it is dated before the previous one",
            Self::TooFast => {
                "the robot cannot have got there since the previous one at the speed of its class"
            }
            Self::TooOften => "the robot observes more often than it can enter cells",
            Self::TooManyStarts => "the robot has restarted too often",
        })
    }
}

/// A rejected message or observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rejected {
    /// The participant that sent it.
    pub from: Participant,
    /// The source of the rejected observation: a sync reply may repeat observations of any source.
    pub of: Source,
    /// The reason.
    pub why: Rejection,
}

impl fmt::Display for Rejected {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "rejected an observation of {1} that came from {0}: {2}",
            self.from, self.of, self.why
        )
    }
}

/// Rejections that are counted together. Participants outside the team are not distinguished, since there may be any number
/// of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RejectionKind {
    /// The sender; `None` if it is not of the team.
    pub from: Option<Participant>,
    /// The source; `None` if it is not of the team.
    pub of: Option<Source>,
    /// The reason.
    pub why: Rejection,
}

impl fmt::Display for RejectionKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from = self.from.map_or_else(|| "a stranger".to_owned(), |from| from.to_string());
        let of = self.of.map_or_else(|| "a stranger".to_owned(), |of| of.to_string());
        write!(formatter, "rejected an observation of {of} that came from {from}: {}", self.why)
    }
}

/// The limits of one mission.
#[derive(Clone, Debug)]
pub struct Limits {
    terrain: Arc<Terrain>,
    team: Arc<BTreeMap<RobotId, Arc<Class>>>,
    /// The last observation that passed [`Limits::check_observation`]: the robots of one process check the same one in turn.
    possible: Arc<Mutex<Option<Arc<Observation>>>>,
    clock_tolerance: Duration,
}

impl Limits {
    /// The limits of a mission with this map, and a team of these classes.
    #[must_use]
    pub fn new(
        terrain: Arc<Terrain>,
        team: impl IntoIterator<Item = (RobotId, Arc<Class>)>,
        clock_tolerance: Duration,
    ) -> Self {
        Self {
            terrain,
            team: Arc::new(team.into_iter().collect()),
            possible: Arc::default(),
            clock_tolerance,
        }
    }

    /// The limits of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let team = scenario.robots().iter().map(|robot| (robot.id, Arc::clone(&robot.class)));
        Self::new(Arc::new(scenario.terrain().clone()), team, scenario.mission().clock_tolerance)
    }

    /// The map.
    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }

    /// Whether a participant belongs to the mission.
    #[must_use]
    pub fn knows(&self, participant: Participant) -> bool {
        match participant {
            Participant::Robot(robot) => self.team.contains_key(&robot),
            Participant::Coordinator => true,
        }
    }

    /// Whether observations of a source may exist: those of the team's robots.
    #[must_use]
    pub fn counts(&self, source: Source) -> bool {
        self.class(source).is_some()
    }

    /// What a source can do, if it is a robot of the team.
    #[must_use]
    pub fn class(&self, source: Source) -> Option<&Class> {
        match source {
            Source::Operator => None,
            Source::Robot(robot) => self.team.get(&robot).map(|class| &**class),
        }
    }

    /// Validates an observation, by itself and by the known ones of its origin, if any.
    ///
    /// # Errors
    /// Why it is rejected.
    pub fn check(&self, observation: &Arc<Observation>, known: Option<Ends<'_>>) -> Result<(), Rejection> {
        let class = self.class(observation.origin.source).ok_or(Rejection::Stranger)?;
        self.check_observation_once(class, observation)?;
        let Some(known) = known else { return Ok(()) };
        self.check_speed(class, known.last, observation)?;
        self.check_rate(class, known.first, observation)
    }

    /// Validates the date of an observation.
    ///
    /// # Errors
    /// If it is in the future.
    pub fn check_date(&self, now: MissionTime, observation: &Observation) -> Result<(), Rejection> {
        if MissionTime(observation.time_ns) > now + self.clock_tolerance {
            return Err(Rejection::Future);
        }
        Ok(())
    }

    /// Like [`Limits::check_observation`], whose result for one observation is the same for all receivers of a process.
    fn check_observation_once(&self, class: &Class, observation: &Arc<Observation>) -> Result<(), Rejection> {
        let is_known = |possible: &Option<Arc<Observation>>| {
            possible.as_ref().is_some_and(|possible| Arc::ptr_eq(possible, observation))
        };
        if self.possible.try_lock().is_ok_and(|possible| is_known(&possible)) {
            return Ok(());
        }
        self.check_observation(class, observation)?;
        if let Ok(mut possible) = self.possible.try_lock() {
            *possible = Some(Arc::clone(observation));
        }
        Ok(())
    }

    fn check_observation(&self, class: &Class, observation: &Observation) -> Result<(), Rejection> {
        if !(class.flies || self.terrain.is_traversable(observation.from)) {
            return Err(Rejection::Blocked);
        }
        let (grid, radius) = (self.terrain.grid(), class.sensor.radius());
        // Of the square around the robot that holds all cells in sight, row by row.
        let side = 2 * radius + 1;
        let mut is_seen = vec![false; (side * side) as usize];
        let robot = grid.position(observation.from);
        for reading in &observation.readings {
            let cell = grid.position(reading.cell);
            let distance = cell.row.abs_diff(robot.row) + cell.column.abs_diff(robot.column);
            if distance > radius {
                return Err(Rejection::OutOfSight);
            }
            let place = (cell.row + radius - robot.row) * side + (cell.column + radius - robot.column);
            if std::mem::replace(&mut is_seen[place as usize], true) {
                return Err(Rejection::Repeated);
            }
            check_reading(&class.sensor, distance, reading)?;
        }
        if !observation.positions.iter().all(|position| position.is_near_its_cell(&self.terrain)) {
            return Err(Rejection::Misplaced);
        }
        Ok(())
    }

    /// The straight line is the shortest path, independently of obstacles.
    fn check_speed(
        &self,
        class: &Class,
        before: &Observation,
        observation: &Observation,
    ) -> Result<(), Rejection> {
        if observation.time_ns < before.time_ns {
            return Err(Rejection::Backwards);
        }
        let cells = self.terrain.grid().offset(before.from, observation.from).euclidean();
        if cells > self.cells_in(class, before, observation) * SPEED_TOLERANCE + PLACE_TOLERANCE_CELLS {
            return Err(Rejection::TooFast);
        }
        Ok(())
    }

    fn check_rate(
        &self,
        class: &Class,
        first: &Observation,
        observation: &Observation,
    ) -> Result<(), Rejection> {
        let observations = observation.sequence.saturating_sub(OBSERVATIONS_AT_ONCE) as f64;
        if observations > self.cells_in(class, first, observation) * SPEED_TOLERANCE * OBSERVATIONS_PER_CELL {
            return Err(Rejection::TooOften);
        }
        Ok(())
    }

    /// Cells that a robot crosses between two observations, at full speed.
    fn cells_in(&self, class: &Class, from: &Observation, to: &Observation) -> f64 {
        let time = MissionTime(to.time_ns).since(MissionTime(from.time_ns));
        time.as_secs_f64() * class.speed_meters_per_second / self.terrain.cell_meters()
    }
}

fn check_reading(sensor: &Sensor, distance: u32, reading: &Reading) -> Result<(), Rejection> {
    if reading.variance < sensor.variance(distance) * (1.0 - VARIANCE_TOLERANCE) {
        return Err(Rejection::TooPrecise);
    }
    let off = DEVIATIONS * f64::from(reading.variance).sqrt();
    if !(-off..=1.0 + off).contains(&f64::from(reading.value)) {
        return Err(Rejection::TooFarOff);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
