//! The times of a robot's heartbeats: periodic, and to synchronize with participants that have joined.

use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::situation::Place;

/// Participants that join within this part of the heartbeat period are synchronized together,
const TOGETHER: u32 = 32;
/// and within this further part, which is divided among the robots of the team: long enough to receive the previous
/// robot's heartbeat.
const WELCOMES: u32 = 8;

/// The heartbeat schedule of a robot. Each robot of a team has its own time in each period, so that the heartbeats of a
/// large team do not delay its observations.
#[derive(Clone, Debug)]
pub struct HeartbeatSchedule {
    place: Place,
    period: Duration,
    next: MissionTime,
    /// When a heartbeat for a joined participant is due, unless another one makes it unnecessary.
    sync: Option<MissionTime>,
}

impl HeartbeatSchedule {
    /// A heartbeat every period, from the mission's start.
    #[must_use]
    pub fn new(place: Place, period: Duration) -> Self {
        let mut schedule = Self { place, period, next: MissionTime::START, sync: None };
        schedule.restart(MissionTime::START);
        schedule
    }

    /// Starts or restarts the schedule: the next heartbeat is at the robot's next time slot.
    pub fn restart(&mut self, now: MissionTime) {
        let since_start = now.since(MissionTime::START).as_nanos();
        let (period, turn) = (self.period.as_nanos(), self.turn(self.period).as_nanos());
        let since_turn = (since_start + period - turn) % period.max(1);
        self.next = now + Duration::from_nanos_u128(period - since_turn);
        self.sync = None;
    }

    /// When the next heartbeat is due.
    #[must_use]
    pub fn due(&self) -> MissionTime {
        self.sync.map_or(self.next, |sync| sync.min(self.next))
    }

    /// Whether a heartbeat is due now; if so, it is marked as sent.
    pub fn beats(&mut self, now: MissionTime) -> bool {
        let is_due = now >= self.due();
        if is_due {
            self.restart(now);
        }
        is_due
    }

    /// A participant has joined, or joined again, and may miss observations. One heartbeat serves all that join
    /// together, and one robot's heartbeat is enough for its team.
    pub fn request_sync(&mut self, now: MissionTime) {
        let soon = now + self.period / TOGETHER + self.turn(self.period / WELCOMES);
        self.sync = Some(self.sync.map_or(soon, |due| due.min(soon)));
    }

    /// Another robot has sent its version vector; if it covers all that this robot knows, its own heartbeat is not
    /// needed.
    pub fn suppress(&mut self, is_all_told: impl FnOnce() -> bool) {
        if self.sync.is_some() && is_all_told() {
            self.sync = None;
        }
    }

    /// The end of the robot's share of a time that the team divides.
    fn turn(&self, time: Duration) -> Duration {
        time * (u32::from(self.place.member) + 1) / u32::from(self.place.team)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn at(seconds: u64) -> MissionTime {
        MissionTime(seconds * SECOND)
    }

    /// The second of four robots; each period is 16 s.
    fn second() -> HeartbeatSchedule {
        HeartbeatSchedule::new(Place { member: 1, team: 4 }, Duration::from_secs(16))
    }

    #[test]
    fn a_heartbeat_is_due_in_every_turn_and_none_is_caught_up_on() {
        let mut schedule = second();
        assert_eq!(schedule.due(), at(8));
        assert!(!schedule.beats(at(7)));
        assert!(schedule.beats(at(8)));
        assert_eq!(schedule.due(), at(24));
        assert!(schedule.beats(at(60)));
        assert_eq!(schedule.due(), at(72));
        schedule.restart(at(3));
        assert_eq!(schedule.due(), at(8), "the clock may be set back");
        assert_eq!(HeartbeatSchedule::new(Place::ALONE, Duration::from_secs(16)).due(), at(16));
    }

    #[test]
    fn one_heartbeat_serves_all_that_join_together() {
        let mut schedule = second();
        schedule.request_sync(at(1));
        let soon = MissionTime(SECOND + SECOND / 2 + SECOND);
        assert_eq!(schedule.due(), soon);
        schedule.request_sync(MissionTime(SECOND + 1));
        schedule.suppress(|| false);
        assert!(schedule.beats(soon));
        assert_eq!(schedule.due(), at(8));
        schedule.request_sync(at(2));
        schedule.suppress(|| true);
        assert_eq!(schedule.due(), at(8));
    }
}
