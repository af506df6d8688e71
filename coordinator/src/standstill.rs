//! Robots that are under way and enter no cell: something may be in their way, and a person should know.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_proto::message::Heartbeat;
use dragnet_proto::state_machine::Standstill;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;

/// Time beyond that of two moves after which a robot that enters no cell stands.
const PATIENCE: Duration = Duration::from_mins(1);

/// At most so much of the time between two heartbeats counts: the clock may have been set, or the robot out of reach.
const LONGEST_GAP: Duration = Duration::from_secs(20);

/// For how long each robot has entered no cell.
#[derive(Clone, Debug, Default)]
pub struct Standstills {
    /// What two of the longest moves take each robot, seconds, by [`RobotId::index`].
    usual_seconds: Vec<f64>,
    robots: BTreeMap<RobotId, Progress>,
}

/// What a robot told last.
#[derive(Clone, Copy, Debug)]
struct Progress {
    received: MissionTime,
    cell: Cell,
    path_meters: f64,
    is_under_way: bool,
    /// For how long that has been so, as far as it was heard.
    lasts: Duration,
}

impl Standstills {
    /// Robots of these speeds, by [`RobotId::index`], on cells of an edge in meters. Others never stand.
    #[must_use]
    pub fn new(cell_meters: f64, speeds_meters_per_second: &[f64]) -> Self {
        let usual = |speed: &f64| 2.0 * std::f64::consts::SQRT_2 * cell_meters / speed;
        Self { usual_seconds: speeds_meters_per_second.iter().map(usual).collect(), robots: BTreeMap::new() }
    }

    /// Applies a heartbeat that arrives now.
    pub fn beat(&mut self, now: MissionTime, heartbeat: &Heartbeat) {
        let is_under_way = heartbeat.activity.is_under_way() && !heartbeat.intent.path.is_empty();
        let &Heartbeat { robot, cell, path_meters, .. } = heartbeat;
        let stood = self.robots.get(&robot).filter(|before| {
            let has_moved = before.cell != cell || before.path_meters.total_cmp(&path_meters).is_ne();
            is_under_way && before.is_under_way && !has_moved
        });
        let lasts =
            stood.map_or(Duration::ZERO, |before| before.lasts + now.since(before.received).min(LONGEST_GAP));
        self.robots.insert(robot, Progress { received: now, cell, path_meters, is_under_way, lasts });
    }

    /// The standstill of a robot, if it has been under way for longer than usual without entering a cell.
    #[must_use]
    pub fn of(&self, robot: RobotId) -> Option<Standstill> {
        let usual = self.usual_seconds.get(robot.index())?;
        let &Progress { cell, lasts, .. } = self.robots.get(&robot)?;
        (lasts.as_secs_f64() > usual + PATIENCE.as_secs_f64()).then_some(Standstill { robot, cell, lasts })
    }

    /// All standstills, by the robots' numbers.
    pub fn iter(&self) -> impl Iterator<Item = Standstill> + '_ {
        self.robots.keys().filter_map(|&robot| self.of(robot))
    }
}

#[cfg(test)]
mod tests {
    use dragnet_proto::directive::Directive;
    use dragnet_proto::message::{Activity, Intent};
    use dragnet_search::cell::Grid;
    use dragnet_search::evidence::Digest;
    use dragnet_search::observation::Versions;

    use super::*;

    const ONE: RobotId = RobotId::FIRST;

    /// Hears one robot, whose longest move takes 5 s, every 10 s.
    struct Watch {
        standstills: Standstills,
        now: MissionTime,
    }

    impl Watch {
        fn new() -> Self {
            Self {
                standstills: Standstills::new(5.0 / std::f64::consts::SQRT_2, &[1.0]),
                now: MissionTime::START,
            }
        }

        /// The robot tells the same so often; returns for how long it stands then, seconds.
        fn hear(&mut self, count: usize, number: u32, activity: Activity) -> Option<u64> {
            let cell = |number| Grid::new(1, 9).unwrap().cell_numbered(number).unwrap();
            let path = if activity.is_under_way() { vec![cell(8)] } else { Vec::new() };
            let heartbeat = Heartbeat {
                robot: ONE,
                time_ns: 0,
                activity,
                cell: cell(number),
                path_meters: f64::from(number),
                intent: Intent { robot: ONE, incarnation: 0, decision: 0, time_ns: 0, path: path.into() },
                versions: Versions::default(),
                digest: Digest(0),
                directive: Directive::default(),
            };
            for _ in 0..count {
                self.now = self.now + Duration::from_secs(10);
                self.standstills.beat(self.now, &heartbeat);
            }
            self.standstills.of(ONE).map(|standstill| standstill.lasts.as_secs())
        }
    }

    #[test]
    fn a_robot_under_way_stands_after_a_minute_and_two_moves_until_it_moves() {
        let mut watch = Watch::new();
        assert_eq!(watch.hear(8, 3, Activity::Searching), None, "70 s");
        assert_eq!(watch.hear(1, 3, Activity::Searching), Some(80));
        assert_eq!(watch.hear(1, 3, Activity::Returning), Some(90), "it has decided again");
        assert_eq!(watch.hear(8, 4, Activity::Returning), None, "it has moved");
        assert_eq!(watch.hear(1, 4, Activity::Returning), Some(80));
    }

    #[test]
    fn a_robot_that_may_stay_where_it_is_does_not_stand() {
        let mut watch = Watch::new();
        for activity in [Activity::Cleared, Activity::Paused, Activity::Holding, Activity::Waiting] {
            assert_eq!(watch.hear(20, 3, activity), None);
        }
        assert_eq!(watch.hear(8, 3, Activity::Searching), None, "from now on");
        assert_eq!(watch.hear(1, 3, Activity::Searching), Some(80));
    }

    #[test]
    fn silence_and_a_clock_that_is_set_are_no_standstill() {
        let mut watch = Watch::new();
        watch.hear(1, 3, Activity::Searching);
        watch.now = watch.now + Duration::from_hours(1);
        assert_eq!(watch.hear(1, 3, Activity::Searching), None);
        watch.now = MissionTime::START;
        assert_eq!(watch.hear(1, 3, Activity::Searching), None);
        assert_eq!(watch.hear(7, 3, Activity::Searching), Some(90));
    }
}
