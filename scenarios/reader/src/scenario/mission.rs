//! Budget, detection threshold and communication of a mission.

use std::time::Duration;

use super::check::{self, Invalid};
use super::class::Class;
use super::file::MissionTable;

/// The maximum of a budget, meters, and of a speed, meters per second.
const MAX_METERS: f64 = 1e9;
/// The slowest robot, meters per second.
const MIN_SPEED: f64 = 0.001;
/// The most heartbeats, or recorded beliefs, while a robot crosses a cell.
const MAX_PERIODS_A_CELL: f64 = 1000.0;

/// Detection threshold, stopping conditions, and communication periods.
#[derive(Clone, Debug, PartialEq)]
pub struct Mission {
    /// A cell whose probability reaches this is declared an object; above 0.5 and below 1.
    pub detection_threshold: f64,
    /// Budgets of path length and time of each robot.
    pub budget: Budget,
    /// Whether each robot is back at its base, the cell that it starts in, when its budget ends or its search is over;
    /// then the share of each budget that no plan uses, at least 0 and below 1.
    pub return_reserve: Option<f64>,
    /// Speed of a robot in simulation, above 0; observations that imply a higher speed are rejected.
    pub speed_meters_per_second: f64,
    /// The search is over when at most this number of objects are expected outside the declared cells, counting only
    /// cells in reach. This is the mean number of objects left behind over many searches, since the belief is the
    /// posterior of the model that readings are drawn from, whenever it is evaluated. With `None` the search ends when
    /// no observation is informative.
    pub stop_when_expected_remaining: Option<f64>,
    /// Heartbeat period of a robot, above 0.
    pub heartbeat: Duration,
    /// Silence after which a robot counts as lost, above the heartbeat period.
    pub lost_after: Duration,
    /// Robot `k` makes its first decision `k - 1` times this duration after the mission's start. Over radios it is at least
    /// the time that a long plan takes: robots that decide at the same moment all answer each other's last plans, and
    /// again, and their tours do not settle.
    pub stagger: Duration,
    /// Allowed clock skew: observations that are dated later are not accepted yet.
    pub clock_tolerance: Duration,
}

/// Budgets of path length and time of each robot, at least one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    meters: Option<f64>,
    time: Option<Duration>,
}

impl Budget {
    /// Path length that each robot may drive, meters, above 0.
    #[must_use]
    pub const fn meters(&self) -> Option<f64> {
        self.meters
    }

    /// Time from the mission's start, above 0.
    #[must_use]
    pub const fn time(&self) -> Option<Duration> {
        self.time
    }

    /// Whether the budget is spent for a robot with this path length at this time from the mission's start: it makes no
    /// further step.
    #[must_use]
    pub fn is_spent(&self, path_meters: f64, elapsed: Duration) -> bool {
        self.meters.is_some_and(|budget| path_meters >= budget)
            || self.time.is_some_and(|budget| elapsed >= budget)
    }
}

impl Mission {
    /// Path length that the budget leaves to a robot with this path length at this time from the mission's start, meters,
    /// at least 0: in time, as far as it drives by then. Infinite without a budget. A reserve is not left to it.
    #[must_use]
    pub fn remaining_meters(&self, path_meters: f64, elapsed: Duration) -> f64 {
        let Budget { meters, time } =
            self.return_reserve.map_or(self.budget, |share| self.budget.less(share));
        let of_length = meters.map(|budget| budget - path_meters);
        let left = |budget: Duration| budget.saturating_sub(elapsed).as_secs_f64();
        let of_time = time.map(|budget| left(budget) * self.speed_meters_per_second);
        [of_length, of_time].into_iter().flatten().fold(f64::INFINITY, f64::min).max(0.0)
    }

    /// The mission of the robots of a class: with their speed and budget.
    #[must_use]
    pub fn of(&self, class: &Class) -> Self {
        Self { speed_meters_per_second: class.speed_meters_per_second, budget: class.budget, ..self.clone() }
    }

    pub(super) fn check_speed(key: &str, speed: f64) -> Result<f64, Invalid> {
        check::within(key, speed, MIN_SPEED, MAX_METERS)
    }

    pub(super) fn new(table: &MissionTable) -> Result<Self, Invalid> {
        let heartbeat = check::period("mission.heartbeat_seconds", table.heartbeat_seconds)?;
        let lost_after =
            check::positive_seconds("mission.liveness_timeout_seconds", table.liveness_timeout_seconds)?;
        if lost_after <= heartbeat {
            let allowed = format!("above mission.heartbeat_seconds, {}", table.heartbeat_seconds);
            return Err(Invalid::new(
                "mission.liveness_timeout_seconds",
                table.liveness_timeout_seconds,
                allowed,
            ));
        }
        let stop_key = "mission.stop_when_expected_remaining";
        let stop_at = check::at_least_zero(stop_key, table.stop_when_expected_remaining, 1e6)?;
        Ok(Self {
            detection_threshold: check::between(
                "mission.detection_threshold",
                table.detection_threshold,
                0.5,
                1.0,
            )?,
            budget: Budget::new(table)?,
            return_reserve: return_reserve(table)?,
            speed_meters_per_second: Self::check_speed(
                "mission.speed_meters_per_second",
                table.speed_meters_per_second,
            )?,
            stop_when_expected_remaining: (stop_at > 0.0).then_some(stop_at),
            heartbeat,
            lost_after,
            stagger: check::seconds("mission.start_stagger_seconds", table.start_stagger_seconds)?,
            clock_tolerance: check::seconds("mission.max_clock_skew_seconds", table.max_clock_skew_seconds)?,
        })
    }
}

fn return_reserve(table: &MissionTable) -> Result<Option<f64>, Invalid> {
    let reserve = check::chance("mission.budget_reserve", table.budget_reserve)?;
    Ok(table.return_to_base.then_some(reserve))
}

/// Checks that a robot crosses a cell in a bounded number of periods: otherwise the simulation of a step would take too
/// long.
pub(super) fn check_period(
    key: &str,
    period: Duration,
    cell_meters: f64,
    class: &Class,
) -> Result<(), Invalid> {
    let cell_seconds = cell_meters / class.speed_meters_per_second;
    let least = cell_seconds / MAX_PERIODS_A_CELL;
    if period.as_secs_f64() >= least {
        return Ok(());
    }
    let allowed = format!(
        "at least {}, of which {MAX_PERIODS_A_CELL} pass while a robot crosses a cell (map.cell_meters / \
         {}, {} seconds)",
        check::written(least),
        class.speed_key(),
        check::written(cell_seconds)
    );
    Err(Invalid::new(key, period.as_secs_f64(), allowed))
}

impl Budget {
    /// The same without a share of each.
    fn less(self, share: f64) -> Self {
        let rest = 1.0 - share;
        Self { meters: self.meters.map(|it| it * rest), time: self.time.map(|it| it.mul_f64(rest)) }
    }

    /// The same but for what a class's table gives.
    pub(super) fn with(self, key: &str, meters: Option<f64>, seconds: Option<f64>) -> Result<Self, Invalid> {
        let meters = meters.map(|it| check::positive(format!("{key}.budget_meters"), it, MAX_METERS));
        let time = seconds.map(|it| check::positive_seconds(format!("{key}.budget_seconds"), it));
        Ok(Self { meters: meters.transpose()?.or(self.meters), time: time.transpose()?.or(self.time) })
    }

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
    fn a_budget_is_spent_by_path_length_or_by_time() {
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
