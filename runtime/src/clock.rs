//! This computer's clocks as the source of mission time: its monotonic clock, and its uptime.
//!
//! Mission time is determined in [`dragnet_proto::clock`]; here clocks are read.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

use dragnet_proto::clock::{Adjustment, Kept, MissionClock};
use dragnet_scenario::time::MissionTime;
use tokio::time::Instant;

use crate::unix_time;

/// Mission time by this process's clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    real_time_factor: f64,
    mission: MissionClock,
    /// Time for which it listens to others before its mission begins.
    listens: Duration,
}

/// A process that knows no mission begins at a random time within the first second, so that two starts that do not know
/// each other use different names.
const FIRST_NS: u64 = 1_000_000_000;
/// Time within which a participant of a running mission is received.
const LISTEN: Duration = Duration::from_secs(2);
/// Time within which a connected participant is detected.
const SETTLE: Duration = Duration::from_secs(1);
/// Maximum duration to a wall-clock time.
const FARTHEST: Duration = Duration::from_hours(24);

impl Clock {
    /// The clock of a participant that knows no mission yet, with this real-time factor, above 0.
    #[must_use]
    pub fn new(real_time_factor: f64) -> Self {
        let first = MissionTime(RandomState::new().build_hasher().finish() % FIRST_NS);
        let mission = MissionClock::new(real_time_factor, first);
        Self { started: Instant::now(), real_time_factor, mission, listens: Duration::ZERO }
    }

    /// A clock for a robot with its own vehicle: before the robot's first observation begins a new mission, it listens
    /// for a mission that is running already and that it has to join.
    #[must_use]
    pub fn listening(self) -> Self {
        Self { listens: LISTEN, ..self }
    }

    /// Mission seconds per second.
    #[must_use]
    pub const fn real_time_factor(&self) -> f64 {
        self.real_time_factor
    }

    /// Whether it still listens to others. A robot that knows the mission's time listens for a moment too, to detect
    /// another process with its number.
    #[must_use]
    pub fn listens(&self) -> bool {
        let listens = if self.has_begun() { self.listens.min(SETTLE) } else { self.listens };
        self.local() < listens
    }

    /// The clock, set to this mission time now.
    #[must_use]
    pub fn at(self, now: MissionTime) -> Self {
        Self { mission: self.mission.at(self.local(), now), ..self }
    }

    /// The mission time now.
    #[must_use]
    pub fn now(&self) -> MissionTime {
        self.mission.now(self.local())
    }

    /// Time since this process started.
    #[must_use]
    pub fn local(&self) -> Duration {
        self.started.elapsed()
    }

    /// Whether the mission has begun, as far as this participant knows.
    #[must_use]
    pub const fn has_begun(&self) -> bool {
        self.mission.has_begun()
    }

    /// Begins the mission now, unless it has begun.
    pub fn begin(&mut self) {
        self.mission.begin(self.local());
    }

    /// Receives a time from another participant.
    pub fn receive(&mut self, time: MissionTime) -> Adjustment {
        self.mission.receive(self.local(), time)
    }

    /// Receives the simulator's time; returns whether the clock can follow.
    pub fn follow(&mut self, time: MissionTime) -> bool {
        self.mission.follow(self.local(), time)
    }

    /// The wall-clock time of a mission time, at most a day ahead.
    #[must_use]
    pub fn instant(&self, time: MissionTime) -> Instant {
        let left = self.mission.until(self.local(), time);
        Instant::now() + left.unwrap_or(FARTHEST).min(FARTHEST)
    }

    /// The date of mission time 0 by this computer, Unix time in nanoseconds, at least 0: for people.
    #[must_use]
    pub(crate) fn start_unix_ns(&self) -> i64 {
        unix_time::now_ns().saturating_sub_unsigned(self.now().0).max(0)
    }

    /// The values to store for a later start.
    #[must_use]
    pub fn kept(&self) -> Kept {
        let (boot, uptime) = computer();
        Kept { boot, uptime, time: self.now() }
    }

    /// The mission time from stored values.
    #[must_use]
    pub fn resumed(&self, kept: &Kept) -> MissionTime {
        let (boot, uptime) = computer();
        kept.resumed(&boot, uptime, self.real_time_factor)
    }

    /// Whether the clock was set since its values were stored, so that a restart would use a wrong time.
    #[must_use]
    pub fn has_moved_since(&self, noted: &Clock) -> bool {
        // The two differ only by adjustments.
        let expected = noted.mission.now(self.local());
        let off = self.now().since(expected).max(expected.since(self.now()));
        off >= self.least_adjustment()
    }

    /// Mission time by which the clock is set at least when it was wrong: messages take less.
    #[must_use]
    pub fn least_adjustment(&self) -> Duration {
        Duration::from_secs(1).mul_f64(self.real_time_factor.max(1.0))
    }
}

/// The boot identifier and the uptime of this computer, including sleep. If the system provides none, every boot counts
/// as a different one.
fn computer() -> (String, Duration) {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let uptime = std::fs::read_to_string("/proc/uptime").ok();
    let seconds = uptime.and_then(|text| text.split_whitespace().next()?.parse().ok());
    match seconds.map(Duration::try_from_secs_f64) {
        Some(Ok(uptime)) => (boot.trim().to_owned(), uptime),
        _ => (String::new(), Duration::ZERO),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stored_time_continues_within_a_boot() {
        let clock = Clock::new(1.0).at(MissionTime(5_000_000_000_000));
        let (mut kept, before) = (clock.kept(), clock.now());
        assert!(!kept.boot.is_empty() && kept.uptime > Duration::ZERO);
        kept.uptime = kept.uptime.saturating_sub(Duration::from_secs(1));
        assert!(clock.resumed(&kept) >= before + Duration::from_millis(900));
        "another run".clone_into(&mut kept.boot);
        assert_eq!(clock.resumed(&kept), kept.time);
    }

    #[test]
    fn only_a_clock_that_was_set_has_moved() {
        let noted = Clock::new(1.0).at(MissionTime(7));
        let mut clock = noted;
        assert!(!clock.has_moved_since(&noted));
        clock.receive(MissionTime::START + Duration::from_secs(90));
        assert!(clock.has_moved_since(&noted));
    }
}
