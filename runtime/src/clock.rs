//! This computer's part in the mission's time: its monotonic clock, and how long it has run.
//!
//! What the time is is decided in [`dragnet_proto::clock`]; here clocks are read.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

use dragnet_proto::clock::{Adjustment, Kept, MissionClock};
use dragnet_scenario::time::MissionTime;
use tokio::time::Instant;

/// Mission time by this process's clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    started: Instant,
    real_time_factor: f64,
    mission: MissionClock,
    /// How long it listens for others before its mission begins.
    listens: Duration,
}

/// Whoever knows of no mission begins within its first second, anywhere: so that two starts that know nothing of each
/// other name nothing alike.
const FIRST_NS: u64 = 1_000_000_000;
/// Whoever is in the mission already is heard within this time.
const LISTEN: Duration = Duration::from_secs(2);
/// Whoever is connected is known to be there within this time.
const SETTLE: Duration = Duration::from_secs(1);
/// No time on the wall is farther away than this.
const FARTHEST: Duration = Duration::from_hours(24);

impl Clock {
    /// The clock of a participant that knows of no mission yet, with so many mission seconds a second, above 0.
    #[must_use]
    pub fn new(real_time_factor: f64) -> Self {
        let first = MissionTime(RandomState::new().build_hasher().finish() % FIRST_NS);
        let mission = MissionClock::new(real_time_factor, first);
        Self { started: Instant::now(), real_time_factor, mission, listens: Duration::ZERO }
    }

    /// The same for a robot that looks around by itself: before its first look begins a mission of its own it listens for
    /// one that it comes late to, or has forgotten.
    #[must_use]
    pub fn listening(self) -> Self {
        Self { listens: LISTEN, ..self }
    }

    /// Whether it listens for others before anything else: one that knows the mission's time does so for a moment, too, as
    /// another process of its number may be there.
    #[must_use]
    pub fn listens(&self) -> bool {
        let listens = if self.has_begun() { self.listens.min(SETTLE) } else { self.listens };
        self.local() < listens
    }

    /// The same, that it is this mission time now.
    #[must_use]
    pub fn at(self, now: MissionTime) -> Self {
        Self { mission: self.mission.at(self.local(), now), ..self }
    }

    /// The mission time now.
    #[must_use]
    pub fn now(&self) -> MissionTime {
        self.mission.now(self.local())
    }

    /// How long this process has run.
    #[must_use]
    pub fn local(&self) -> Duration {
        self.started.elapsed()
    }

    /// Whether the mission has begun, as far as is known here.
    #[must_use]
    pub const fn has_begun(&self) -> bool {
        self.mission.has_begun()
    }

    /// The mission begins now, unless it has.
    pub fn begin(&mut self) {
        self.mission.begin(self.local());
    }

    /// Somebody says that it is this time, or was when it spoke.
    pub fn hear(&mut self, time: MissionTime) -> Adjustment {
        self.mission.hear(self.local(), time)
    }

    /// The simulator says that it is this time; whether it can be followed.
    pub fn follow(&mut self, time: MissionTime) -> bool {
        self.mission.follow(self.local(), time)
    }

    /// When it will be this time, on the wall; within a day.
    #[must_use]
    pub fn instant(&self, time: MissionTime) -> Instant {
        let left = self.mission.until(self.local(), time);
        Instant::now() + left.unwrap_or(FARTHEST).min(FARTHEST)
    }

    /// What is to be noted of it, for a later start.
    #[must_use]
    pub fn kept(&self) -> Kept {
        let (boot, uptime) = computer();
        Kept { boot, uptime, time: self.now() }
    }

    /// The mission time that it goes on at, by what was noted.
    #[must_use]
    pub fn resumed(&self, kept: &Kept) -> MissionTime {
        let (boot, uptime) = computer();
        kept.resumed(&boot, uptime, self.real_time_factor)
    }

    /// Whether it has been set since something was noted of it, so that a later start would go on at a wrong time.
    #[must_use]
    pub fn has_moved_since(&self, noted: &Clock) -> bool {
        // The two differ by what was set alone.
        let expected = noted.mission.now(self.local());
        let off = self.now().since(expected).max(expected.since(self.now()));
        off >= Duration::from_secs(1).mul_f64(self.real_time_factor.max(1.0))
    }
}

/// Which run of this computer it is, and for how long it has run, asleep too. Where the system does not tell, no two runs
/// are known to be the same.
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
    fn this_computer_tells_its_run_and_what_was_noted_goes_on_in_it() {
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
        clock.hear(MissionTime::START + Duration::from_secs(90));
        assert!(clock.has_moved_since(&noted));
    }
}
