//! When a robot gives a sign of life: in its turn, and when somebody has come who must be told what there is to know.

use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::situation::Place;

/// Whoever comes within such a part of the time between two heartbeats is welcomed with others,
const TOGETHER: u32 = 32;
/// and within such a further part, of which each robot of the team has its share: long enough to hear the one before.
const WELCOMES: u32 = 8;

/// The beat of a robot. All robots of a team have a turn in each period: if all of a large team spoke at once, what they
/// see would wait behind it.
#[derive(Clone, Debug)]
pub struct HeartbeatSchedule {
    place: Place,
    period: Duration,
    next: MissionTime,
    /// Whoever has come is told then, unless somebody else does before.
    sync: Option<MissionTime>,
}

impl HeartbeatSchedule {
    /// A beat every period, from the mission's start.
    #[must_use]
    pub fn new(place: Place, period: Duration) -> Self {
        let mut schedule = Self { place, period, next: MissionTime::START, sync: None };
        schedule.restart(MissionTime::START);
        schedule
    }

    /// The robot begins, or begins anew, now: the next beat is that of its next turn.
    pub fn restart(&mut self, now: MissionTime) {
        let since_start = now.since(MissionTime::START).as_nanos();
        let (period, turn) = (self.period.as_nanos(), self.turn(self.period).as_nanos());
        let since_turn = (since_start + period - turn) % period.max(1);
        self.next = now + Duration::from_nanos_u128(period - since_turn);
        self.sync = None;
    }

    /// When the next beat is due.
    #[must_use]
    pub fn due(&self) -> MissionTime {
        self.sync.map_or(self.next, |sync| sync.min(self.next))
    }

    /// Whether it is due now; then it is given now.
    pub fn beats(&mut self, now: MissionTime) -> bool {
        let is_due = now >= self.due();
        if is_due {
            self.restart(now);
        }
        is_due
    }

    /// Somebody has come, or come back, who may miss much. One beat tells all who come together, and that of one robot is
    /// enough for its team.
    pub fn request_sync(&mut self, now: MissionTime) {
        let soon = now + self.period / TOGETHER + self.turn(self.period / WELCOMES);
        self.sync = Some(self.sync.map_or(soon, |due| due.min(soon)));
    }

    /// Somebody has told all what it knows; if that is all that this robot could tell, its own is not needed.
    pub fn suppress(&mut self, is_all_told: impl FnOnce() -> bool) {
        if self.sync.is_some() && is_all_told() {
            self.sync = None;
        }
    }

    /// The end of the robot's share of a time that its team divides.
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
    fn a_beat_is_due_in_every_turn_and_none_is_caught_up_on() {
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
    fn one_welcome_is_for_all_who_come_together_and_one_robot_gives_it() {
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
