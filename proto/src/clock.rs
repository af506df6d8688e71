//! The mission clock: one time that all participants agree on, even if their computers' clocks are late, reset or
//! wrong.
//!
//! A mission begins with the first observation of its first robot, and its time is the longest that any participant has
//! counted since. Heartbeats, plans, observations and statuses carry it, so every message gives a lower bound of the
//! mission's duration: a receiver whose clock is behind sets it forward to that, and never back. The maximum is the
//! same in any order and with any repetition, so all participants that are connected, directly or through others, agree
//! on the time of the one that began first. Between messages each counts with its computer's monotonic clock, which
//! cannot be set; the date of a computer is never used. So
//!
//! - a robot that starts late, or has lost its journal, has the mission's time with the first message that it receives;
//! - one that restarts continues from its journal ([`Kept`]): within one boot of its computer by the computer's uptime,
//!   after another boot from the last stored time, until it receives a later one;
//! - one without a connection uses its own clock, and all agree on the longest time as soon as they connect.
//!
//! A participant is *joining* until [`JOINING`] after its first message, at each start, and accepts all times within
//! [`LONGEST`]. After that, messages move it forward by no more than [`CREDIT`] at once, and then by one second per
//! second: a participant that publishes false times makes a mission seem ten minutes older, and then its time pass
//! twice as fast, and no more. A joining participant is more vulnerable: false times can advance its clock so far that
//! its budget of time is spent, or that others reject its observations as dated in the future.

use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Source;

use crate::message::Message;

/// Duration, by its own clock, from its first message for which a participant accepts all times.
pub const JOINING: Duration = Duration::from_secs(10);
/// By how much messages move a participant that has joined at once, mission time: parts of a team that are not
/// connected yet may have begun this far apart.
pub const CREDIT: Duration = Duration::from_mins(10);
/// The longest mission: longer times are rejected.
pub const LONGEST: Duration = Duration::from_hours(365 * 24);
/// A simulator's time is accepted as exact if it is behind the participant's clock by at most this, because messages
/// take time.
const LATENCY: Duration = Duration::from_secs(1);

/// Mission time of one participant. `local` is always the time by the same monotonic clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissionClock {
    /// Mission seconds per local second: 1 in the field.
    real_time_factor: f64,
    /// Local and mission time of one moment.
    moment: (Duration, MissionTime),
    /// Whether the mission has begun, as far as known here: before, its time stands still.
    has_begun: bool,
    /// When it first received a message.
    met: Option<Duration>,
    /// By how much messages may still move it, as of a local time.
    credit: (Duration, Duration),
}

/// The result of receiving a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Adjustment {
    /// By how much the clock was set forward, mission time.
    pub by: Duration,
    /// The rest of the difference, which is rejected, or not accepted yet.
    pub left: Duration,
}

impl MissionClock {
    /// The clock of a participant that knows no mission yet. It stands at `first`, which should differ between two
    /// starts that do not know each other, because incarnations are named by the time.
    #[must_use]
    pub const fn new(real_time_factor: f64, first: MissionTime) -> Self {
        let credit = (Duration::ZERO, CREDIT);
        Self { real_time_factor, moment: (Duration::ZERO, first), has_begun: false, met: None, credit }
    }

    /// The clock, set to this mission time now.
    #[must_use]
    pub const fn at(self, local: Duration, now: MissionTime) -> Self {
        Self { moment: (local, now), has_begun: true, ..self }
    }

    /// The mission time now.
    #[must_use]
    pub fn now(&self, local: Duration) -> MissionTime {
        let (since, time) = self.moment;
        if self.has_begun { time + local.saturating_sub(since).mul_f64(self.real_time_factor) } else { time }
    }

    /// Whether the mission has begun.
    #[must_use]
    pub const fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// Local time until a mission time; `None` if the clock stands still.
    #[must_use]
    pub fn until(&self, local: Duration, time: MissionTime) -> Option<Duration> {
        let left = time.since(self.now(local)).as_secs_f64() / self.real_time_factor;
        // The end of time is never reached.
        self.has_begun.then(|| Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX))
    }

    /// Begins the mission now, unless it has begun.
    pub fn begin(&mut self, local: Duration) {
        if !self.has_begun {
            *self = self.at(local, self.now(local));
        }
    }

    /// Receives the mission time in another participant's message.
    pub fn receive(&mut self, local: Duration, time: MissionTime) -> Adjustment {
        let now = self.now(local);
        let ahead = time.since(now);
        let met = *self.met.get_or_insert(local);
        let by = if time.since(MissionTime::START) > LONGEST {
            Duration::ZERO
        } else if !self.has_begun || local.saturating_sub(met) < JOINING {
            ahead
        } else {
            ahead.min(self.take_credit(local, ahead))
        };
        *self = self.at(local, now + by);
        Adjustment { by, left: ahead.saturating_sub(by) }
    }

    /// Receives the exact time from the simulator. Returns whether the clock can follow: one that has restarted, and
    /// does not know the mission's time yet, is not set back.
    pub fn follow(&mut self, local: Duration, time: MissionTime) -> bool {
        let is_behind =
            self.has_begun && time + LATENCY.mul_f64(self.real_time_factor.max(1.0)) < self.now(local);
        if !is_behind {
            *self = self.at(local, time);
        }
        !is_behind
    }

    /// Takes as much of the asked credit as is left.
    fn take_credit(&mut self, local: Duration, asked: Duration) -> Duration {
        let (since, left) = self.credit;
        let has = (left + local.saturating_sub(since).mul_f64(self.real_time_factor)).min(CREDIT);
        let taken = asked.min(has);
        self.credit = (local, has.saturating_sub(taken));
        taken
    }
}

/// The mission time at which a message was created, by its author's clock; `None` for messages that repeat others.
#[must_use]
pub fn dated(from: Participant, message: &Message) -> Option<MissionTime> {
    let time_ns = match message {
        Message::Observation(observation) => match (from, observation.origin.source) {
            (Participant::Robot(from), Source::Robot(robot)) if from == robot => observation.time_ns,
            // An operator's marks are named by the coordinator.
            _ => return None,
        },
        Message::Intent(intent) => intent.time_ns,
        Message::Heartbeat(heartbeat) => heartbeat.time_ns,
        Message::MissionStatus(status) => status.time_ns,
        Message::Verdicts(report) => report.time_ns,
        Message::Orders(report) => report.time_ns,
        Message::Zones(report) => report.time_ns,
        Message::Marks(report) => report.time_ns,
        Message::SyncRequest(_) | Message::SyncReply(_) => return None,
    };
    Some(MissionTime(time_ns))
}

/// A participant's stored clock, for a restart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Identifier of the computer's boot.
    pub boot: String,
    /// Uptime of the computer.
    pub uptime: Duration,
    /// Mission time at that uptime.
    pub time: MissionTime,
}

impl Kept {
    /// The mission time now, from the stored one: within the same boot it has advanced; after another boot the time in
    /// between is unknown.
    #[must_use]
    pub fn resumed(&self, boot: &str, uptime: Duration, real_time_factor: f64) -> MissionTime {
        let is_same = !boot.is_empty() && self.boot == boot;
        let since = if is_same { uptime.saturating_sub(self.uptime) } else { Duration::ZERO };
        self.time + since.mul_f64(real_time_factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn seconds(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn at(time: u64) -> MissionTime {
        MissionTime::START + seconds(time)
    }

    /// A clock that began at this local time.
    fn begun(local: u64) -> MissionClock {
        let mut clock = MissionClock::new(1.0, MissionTime::START);
        clock.begin(seconds(local));
        clock
    }

    #[test]
    fn time_stands_still_until_the_mission_begins() {
        let mut clock = MissionClock::new(2.0, MissionTime(7));
        assert_eq!((clock.now(seconds(50)), clock.until(seconds(50), at(1))), (MissionTime(7), None));
        clock.begin(seconds(60));
        assert_eq!(clock.now(seconds(61)), at(2) + Duration::from_nanos(7));
        clock.begin(seconds(70));
        assert_eq!(clock.until(seconds(61), at(2) + Duration::from_nanos(7) + seconds(4)), Some(seconds(2)));
        assert!(clock.until(seconds(61), MissionTime(u64::MAX)) > Some(seconds(1 << 30)));
    }

    #[test]
    fn a_late_or_reset_participant_has_the_missions_time_with_the_first_message() {
        let mut standing = MissionClock::new(1.0, MissionTime::START);
        assert_eq!(standing.receive(seconds(5), at(7_000)).by, seconds(7_000));
        let mut alone = begun(0);
        assert_eq!(
            alone.receive(seconds(500), at(7_000)),
            Adjustment { by: seconds(6_500), left: Duration::ZERO }
        );
        for clock in [standing, alone] {
            assert_eq!(
                clock.now(seconds(501)).since(at(7_000)),
                seconds(if clock == alone { 1 } else { 496 })
            );
        }
    }

    #[test]
    fn in_any_order_and_repetition_all_agree_on_the_longest_time() {
        let starts = [400, 0, 299, 120];
        for first in 0..4 {
            let mut clocks = starts.map(begun);
            for round in 0..3 {
                for step in 0..16 {
                    let (from, to) = ((first + step) % 4, (first + step / 4 + round) % 4);
                    let time = clocks[from].now(seconds(500));
                    clocks[to].receive(seconds(500), time);
                }
            }
            assert_eq!(clocks.map(|clock| clock.now(seconds(510))), [at(510); 4], "{first}");
        }
    }

    #[test]
    fn late_messages_set_nothing_back() {
        let mut clock = begun(0);
        assert_eq!(
            clock.receive(seconds(100), at(99)),
            Adjustment { by: Duration::ZERO, left: Duration::ZERO }
        );
        assert_eq!(clock.now(seconds(100)), at(100));
    }

    #[test]
    fn false_times_move_a_joined_clock_by_ten_minutes_and_then_by_a_second_a_second() {
        let mut clock = begun(0);
        clock.receive(seconds(1), at(1));
        for local in 20..620 {
            // Each receives a thousand times.
            for _ in 0..1000 {
                clock.receive(seconds(local), at(3_000_000));
            }
            let ahead = clock.now(seconds(local)).since(at(local));
            assert_eq!(ahead, seconds(600 + local - 20));
        }
        let mut joining = begun(0);
        let adjustment = joining.receive(seconds(1), MissionTime(u64::MAX));
        assert_eq!(adjustment.by, Duration::ZERO, "no mission is as old");
    }

    #[test]
    fn parts_of_a_team_that_began_apart_agree_when_they_meet() {
        let (mut older, mut younger) = (begun(0), begun(550));
        for local in [560, 1_000] {
            older.receive(seconds(local), older.now(seconds(local)));
            younger.receive(seconds(local), younger.now(seconds(local)));
        }
        assert_eq!(younger.receive(seconds(1_001), older.now(seconds(1_001))).left, Duration::ZERO);
        assert_eq!(younger.now(seconds(2_000)), older.now(seconds(2_000)));
    }

    #[test]
    fn a_simulator_sends_the_exact_time_unless_it_has_lost_it() {
        let mut clock = MissionClock::new(10.0, MissionTime(123));
        let mut check = |local: u64, mission_seconds: u64, expected: u64| {
            assert_eq!(clock.follow(seconds(local), at(mission_seconds)), mission_seconds == expected);
            assert_eq!(clock.now(seconds(local)), at(expected));
        };
        check(3, 0, 0);
        // It took a tenth of a second to arrive.
        check(5, 19, 19);
        // The participant has restarted.
        check(6, 0, 29);
        check(7, 400, 400);
    }

    #[test]
    fn a_clock_goes_on_by_the_uptime_of_one_run_of_a_computer_and_stands_still_between_two() {
        let kept = Kept { boot: "a".to_owned(), uptime: seconds(100), time: at(40) };
        assert_eq!(kept.resumed("a", seconds(130), 2.0), at(100));
        assert_eq!(kept.resumed("b", seconds(9_000), 2.0), at(40));
        assert_eq!(kept.resumed("a", seconds(90), 2.0), at(40));
        let unknown = Kept { boot: String::new(), ..kept };
        assert_eq!(unknown.resumed("", seconds(9_000), 2.0), at(40));
    }
}
