//! The mission's clock: one time that all of a mission come to share, however late, reset or wrong their own clocks are.
//!
//! A mission begins with the first look of its first robot, wherever that is, and its time is the longest that any
//! participant has counted since. All that is dated (signs of life, plans, looks, statuses) is dated in it, so every
//! message says how long the mission lasts at least: whoever hears of more sets its clock forward to that, and never
//! back. The larger of two times is the same in any order and however often it is heard, so that all who hear each
//! other, by whatever way, come to the same time, that of the one who began first. Between messages each counts with
//! its computer's monotonic clock, which nobody sets; the date of a computer is never asked. So
//!
//! - a robot that starts late, or has lost its journal, has the mission's time with the first message that it hears;
//! - one that starts again goes on from its journal ([`Kept`]): within one run of its computer by that one's uptime,
//!   after another start of the computer from the last time that it had noted, until it hears more;
//! - one that nobody hears counts by itself, and all agree as soon as they meet, on the longer time.
//!
//! A participant *joins* until [`JOINING`] after it has first heard anybody, each time that it starts, and believes
//! whatever it hears within [`LONGEST`]. After that the words of others move it forward by no more than [`CREDIT`] at
//! once, and then by one second a second: somebody who lies about the time makes a mission seem ten minutes older, and
//! then its time pass twice as fast, and no more. What it can do to one that joins: date it so late that it rests, its
//! budget spent, or that others take its looks for looks of the future.

use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Source;

use crate::message::Message;

/// So long, by its own clock, a participant believes all that it hears of the time, since it first heard anybody.
pub const JOINING: Duration = Duration::from_secs(10);
/// By so much the words of others move a participant that has joined at once, mission time: by so much may parts of a
/// team that have not heard each other yet have begun apart.
pub const CREDIT: Duration = Duration::from_mins(10);
/// No mission lasts as long: whoever says so is not believed.
pub const LONGEST: Duration = Duration::from_hours(365 * 24);
/// A simulator that is behind by no more than this, by its own clock, tells the exact time all the same: messages take
/// a while.
const LATENCY: Duration = Duration::from_secs(1);

/// Mission time of one participant. `local` is always the time by the same monotonic clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MissionClock {
    /// Mission seconds a local second: 1 in the field.
    real_time_factor: f64,
    /// Local and mission time of one moment.
    moment: (Duration, MissionTime),
    /// Whether the mission has begun, as far as is known here: before, its time stands still.
    has_begun: bool,
    /// When it first heard anybody.
    met: Option<Duration>,
    /// By how much the words of others may move it yet, as of a local time.
    credit: (Duration, Duration),
}

/// A clock was set forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Adjustment {
    /// By so much mission time.
    pub by: Duration,
    /// What it heard was ahead of it by so much more, which it does not believe, or not yet.
    pub left: Duration,
}

impl MissionClock {
    /// The clock of a participant that knows of no mission yet. It stands at `first`, which should differ between two
    /// starts that know nothing of each other: names are given by the time.
    #[must_use]
    pub const fn new(real_time_factor: f64, first: MissionTime) -> Self {
        let credit = (Duration::ZERO, CREDIT);
        Self { real_time_factor, moment: (Duration::ZERO, first), has_begun: false, met: None, credit }
    }

    /// The same, that it is this mission time now.
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

    /// Local time until it will be a mission time; nothing if that stands still.
    #[must_use]
    pub fn until(&self, local: Duration, time: MissionTime) -> Option<Duration> {
        let left = time.since(self.now(local)).as_secs_f64() / self.real_time_factor;
        // The end of time is never reached.
        self.has_begun.then(|| Duration::try_from_secs_f64(left).unwrap_or(Duration::MAX))
    }

    /// The mission begins now, unless it has.
    pub fn begin(&mut self, local: Duration) {
        if !self.has_begun {
            *self = self.at(local, self.now(local));
        }
    }

    /// Somebody says that it is this time, or was when it spoke.
    pub fn hear(&mut self, local: Duration, time: MissionTime) -> Adjustment {
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

    /// Whoever moves this participant and shows it what it sees says that it is this time, exactly. Whether it can be
    /// followed: one that has begun anew, and does not know the mission's time yet, is not followed back.
    pub fn follow(&mut self, local: Duration, time: MissionTime) -> bool {
        let is_behind =
            self.has_begun && time + LATENCY.mul_f64(self.real_time_factor.max(1.0)) < self.now(local);
        if !is_behind {
            *self = self.at(local, time);
        }
        !is_behind
    }

    /// As much of what is asked for as there is, which is then gone.
    fn take_credit(&mut self, local: Duration, asked: Duration) -> Duration {
        let (since, left) = self.credit;
        let has = (left + local.saturating_sub(since).mul_f64(self.real_time_factor)).min(CREDIT);
        let taken = asked.min(has);
        self.credit = (local, has.saturating_sub(taken));
        taken
    }
}

/// The mission time that a message was made at, by the clock of whoever made it. What repeats others tells none.
#[must_use]
pub fn dated(from: Participant, message: &Message) -> Option<MissionTime> {
    let time_ns = match message {
        Message::Observation(observation) => match (from, observation.origin.source) {
            (Participant::Robot(from), Source::Robot(robot)) if from == robot => observation.time_ns,
            // Marks that a person makes are named by the coordinator.
            _ => return None,
        },
        Message::Intent(intent) => intent.time_ns,
        Message::Heartbeat(heartbeat) => heartbeat.time_ns,
        Message::MissionStatus(status) => status.time_ns,
        Message::SyncRequest(_) | Message::SyncReply(_) => return None,
    };
    Some(MissionTime(time_ns))
}

/// What a participant notes of its clock, for when it starts again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// Which run of the computer it was: no two have the same.
    pub boot: String,
    /// How long the computer had run.
    pub uptime: Duration,
    /// Which mission time it was then.
    pub time: MissionTime,
}

impl Kept {
    /// The mission time now, by what was noted: in the same run of the computer that goes on, in another one nobody
    /// knows how long it was off.
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
    fn whoever_starts_late_or_without_memory_has_the_missions_time_with_the_first_message() {
        let mut standing = MissionClock::new(1.0, MissionTime::START);
        assert_eq!(standing.hear(seconds(5), at(7_000)).by, seconds(7_000));
        let mut alone = begun(0);
        assert_eq!(
            alone.hear(seconds(500), at(7_000)),
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
    fn in_whatever_order_and_however_often_they_hear_each_other_all_come_to_the_longest_time() {
        let starts = [400, 0, 299, 120];
        for first in 0..4 {
            let mut clocks = starts.map(begun);
            for round in 0..3 {
                for step in 0..16 {
                    let (from, to) = ((first + step) % 4, (first + step / 4 + round) % 4);
                    let time = clocks[from].now(seconds(500));
                    clocks[to].hear(seconds(500), time);
                }
            }
            assert_eq!(clocks.map(|clock| clock.now(seconds(510))), [at(510); 4], "{first}");
        }
    }

    #[test]
    fn what_is_heard_late_sets_nothing_back() {
        let mut clock = begun(0);
        assert_eq!(clock.hear(seconds(100), at(99)), Adjustment { by: Duration::ZERO, left: Duration::ZERO });
        assert_eq!(clock.now(seconds(100)), at(100));
    }

    #[test]
    fn a_liar_moves_whoever_has_joined_by_ten_minutes_and_then_by_a_second_a_second() {
        let mut clock = begun(0);
        clock.hear(seconds(1), at(1));
        for local in 20..620 {
            // Each is told a thousand times.
            for _ in 0..1000 {
                clock.hear(seconds(local), at(3_000_000));
            }
            let ahead = clock.now(seconds(local)).since(at(local));
            assert_eq!(ahead, seconds(600 + local - 20));
        }
        let mut joining = begun(0);
        let adjustment = joining.hear(seconds(1), MissionTime(u64::MAX));
        assert_eq!(adjustment.by, Duration::ZERO, "no mission is as old");
    }

    #[test]
    fn parts_of_a_team_that_began_apart_agree_when_they_meet() {
        let (mut older, mut younger) = (begun(0), begun(550));
        for local in [560, 1_000] {
            older.hear(seconds(local), older.now(seconds(local)));
            younger.hear(seconds(local), younger.now(seconds(local)));
        }
        assert_eq!(younger.hear(seconds(1_001), older.now(seconds(1_001))).left, Duration::ZERO);
        assert_eq!(younger.now(seconds(2_000)), older.now(seconds(2_000)));
    }

    #[test]
    fn a_simulator_says_the_exact_time_unless_it_has_forgotten_it() {
        let mut clock = MissionClock::new(10.0, MissionTime(123));
        let mut check = |local: u64, said: u64, expected: u64| {
            assert_eq!(clock.follow(seconds(local), at(said)), said == expected);
            assert_eq!(clock.now(seconds(local)), at(expected));
        };
        check(3, 0, 0);
        // It took a tenth of a second to come.
        check(5, 19, 19);
        // It has started again.
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
