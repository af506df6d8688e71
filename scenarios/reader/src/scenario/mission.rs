//! For how long, and when an object counts as found.

use std::time::Duration;

use super::check::{self, Invalid};
use super::file::MissionTable;

/// The most metres in a budget, and metres a second of a robot.
const MAX_METERS: f64 = 1e9;

/// How a mission is judged, ended and kept alive.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// A cell whose probability reaches this is declared an object; above 0.5 and below 1.
    pub tau: f64,
    /// Way and time of each robot.
    pub budget: Budget,
    /// Speed of a robot in simulation, above 0; whoever claims to be faster is not believed.
    pub speed_meters_per_second: f64,
    /// The search is over when this number of objects or fewer are expected outside the declared cells, of those that
    /// robots can see. That is what is left behind in the mean over many searches, for the belief is the posterior of the
    /// model that readings are drawn from, whenever it is looked at. `None` is not before nothing is worth a look.
    pub expected_undeclared: Option<f64>,
    /// Time between two signs of life of a robot, above 0.
    pub heartbeat: Duration,
    /// Silence after which a robot is taken for lost, above the heartbeat.
    pub lost_after: Duration,
    /// Robot `k` takes its first decision `k - 1` times this after the mission's start.
    pub stagger: Duration,
    /// By so much may clocks differ: what is dated later is not taken yet.
    pub clock_tolerance: Duration,
}

/// Way and time of each robot, at least one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    meters: Option<f64>,
    time: Option<Duration>,
}

impl Budget {
    /// Way that each robot may cover, metres, above 0.
    #[must_use]
    pub const fn meters(&self) -> Option<f64> {
        self.meters
    }

    /// Time from the mission's start, above 0.
    #[must_use]
    pub const fn time(&self) -> Option<Duration> {
        self.time
    }

    /// Whether a robot that has covered this way at this time from the mission's start may go on for no step
    /// more.
    #[must_use]
    pub fn is_spent(&self, path_meters: f64, elapsed: Duration) -> bool {
        self.meters.is_some_and(|budget| path_meters >= budget)
            || self.time.is_some_and(|budget| elapsed >= budget)
    }
}

impl Mission {
    pub(super) fn new(table: &MissionTable) -> Result<Self, Invalid> {
        let heartbeat = check::positive_seconds("mission.heartbeat_seconds", table.heartbeat_seconds)?;
        let lost_after = check::positive_seconds("mission.lost_after_seconds", table.lost_after_seconds)?;
        if lost_after <= heartbeat {
            let allowed = format!("above mission.heartbeat_seconds, {}", table.heartbeat_seconds);
            return Err(Invalid::new("mission.lost_after_seconds", table.lost_after_seconds, allowed));
        }
        let speed = "mission.speed_meters_per_second";
        let undeclared = "mission.expected_undeclared";
        let expected_undeclared = check::at_least_zero(undeclared, table.expected_undeclared, 1e6)?;
        Ok(Self {
            tau: check::between("mission.tau", table.tau, 0.5, 1.0)?,
            budget: Budget::new(table)?,
            speed_meters_per_second: check::positive(speed, table.speed_meters_per_second, MAX_METERS)?,
            expected_undeclared: (expected_undeclared > 0.0).then_some(expected_undeclared),
            heartbeat,
            lost_after,
            stagger: check::seconds("mission.stagger_seconds", table.stagger_seconds)?,
            clock_tolerance: check::seconds(
                "mission.clock_tolerance_seconds",
                table.clock_tolerance_seconds,
            )?,
        })
    }
}

impl Budget {
    fn new(table: &MissionTable) -> Result<Self, Invalid> {
        let meters = table
            .budget_meters
            .map(|meters| check::positive("mission.budget_meters", meters, MAX_METERS))
            .transpose()?;
        let time = table
            .budget_seconds
            .map(|seconds| check::positive_seconds("mission.budget_seconds", seconds))
            .transpose()?;
        if meters.is_none() && time.is_none() {
            let allowed = "mission.budget_meters, mission.budget_seconds or both";
            return Err(Invalid::new("mission", "without a budget", allowed));
        }
        Ok(Self { meters, time })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_spent_by_way_or_by_time() {
        let table = MissionTable {
            budget_meters: Some(60.0),
            budget_seconds: Some(100.0),
            ..MissionTable::default()
        };
        let budget = Mission::new(&table).unwrap().budget;
        assert!(!budget.is_spent(59.0, Duration::from_secs(99)));
        assert!(budget.is_spent(60.0, Duration::ZERO));
        assert!(budget.is_spent(0.0, Duration::from_secs(100)));
    }
}
