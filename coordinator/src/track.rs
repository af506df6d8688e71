//! Tracks: each robot's position and plan, from messages that may arrive late, twice or out of order.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_proto::message::Intent;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::observation::RobotId;

/// The state of one robot.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Track {
    /// Its last cell, and when it was there by its own clock.
    pub pose: Option<(Cell, MissionTime)>,
    /// Its current plan; `None` if none was received, or the robot is lost.
    pub plan: Option<Intent>,
}

impl Track {
    /// The cells of its plan, and when it is expected in each if it drives `cells_per_second`; empty if no plan is known.
    ///
    /// A robot that is late is about to enter the next cell.
    #[must_use]
    pub fn expected(&self, now: MissionTime, grid: Grid, cells_per_second: f64) -> Vec<(Cell, MissionTime)> {
        let path = self.plan.as_ref().map_or(&[][..], |plan| &plan.path);
        let Some(&first) = path.first() else { return Vec::new() };
        let (mut from, entered) = self.pose.unwrap_or((first, now));
        let mut cells = 0.0;
        let mut departure = None;
        let expect = |&to: &Cell| {
            cells += grid.offset(from, to).euclidean();
            from = to;
            let seconds = cells / cells_per_second;
            let departure =
                *departure.get_or_insert_with(|| entered.as_seconds().max(now.as_seconds() - seconds));
            (
                to,
                MissionTime::START
                    + Duration::try_from_secs_f64(departure + seconds).unwrap_or(Duration::MAX),
            )
        };
        path.iter().map(expect).collect()
    }
}

/// All robots that messages have arrived from.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    robots: BTreeMap<RobotId, Track>,
}

impl Tracks {
    /// Records that a robot was in a cell at a time; returns whether its position has changed.
    pub fn at(&mut self, robot: RobotId, cell: Cell, time: MissionTime) -> bool {
        let track = self.robots.entry(robot).or_default();
        let is_later = track.pose.is_none_or(|(_, known)| time >= known);
        let has_moved = track.pose.is_none_or(|(known, _)| cell != known);
        if is_later {
            track.pose = Some((cell, time));
        }
        is_later && has_moved
    }

    /// Records a robot's plan; returns whether it has changed: it is newer, or the same plan with fewer cells left.
    pub fn plans(&mut self, intent: &Intent) -> bool {
        let track = self.robots.entry(intent.robot).or_default();
        let is_news = track.plan.as_ref().is_none_or(|known| intent.supersedes(known));
        if is_news {
            track.plan = Some(intent.clone());
        }
        is_news
    }

    /// Removes the plan of a lost robot; returns whether there was one.
    pub fn lapses(&mut self, robot: RobotId) -> bool {
        let plan = self.robots.get_mut(&robot).and_then(|track| track.plan.take());
        plan.is_some_and(|plan| !plan.path.is_empty())
    }

    /// The state of each robot, by number.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &Track)> + '_ {
        self.robots.iter().map(|(&robot, track)| (robot, track))
    }

    /// The state of a robot.
    #[must_use]
    pub fn of(&self, robot: RobotId) -> Option<&Track> {
        self.robots.get(&robot)
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::*;

    const ONE: RobotId = RobotId::FIRST;

    fn cell(number: u32) -> Cell {
        Grid::new(1, 9).unwrap().cell_numbered(number).unwrap()
    }

    fn intent(decision: u64, path: std::ops::Range<u32>) -> Intent {
        Intent { robot: ONE, incarnation: 0, decision, time_ns: 0, path: path.map(cell).collect() }
    }

    #[test]
    fn a_pose_that_comes_late_moves_no_robot_back() {
        let mut tracks = Tracks::default();
        assert!(tracks.at(ONE, cell(0), MissionTime(0)));
        assert!(tracks.at(ONE, cell(2), MissionTime(20)));
        assert!(!tracks.at(ONE, cell(1), MissionTime(10)));
        assert!(!tracks.at(ONE, cell(2), MissionTime(30)));
        assert_eq!(tracks.robots().next().unwrap().1.pose, Some((cell(2), MissionTime(30))));
    }

    #[test]
    fn a_plan_is_replaced_shrinks_and_lapses() {
        let mut tracks = Tracks::default();
        assert!(tracks.plans(&intent(1, 0..5)));
        assert!(!tracks.plans(&intent(0, 0..2)));
        assert!(!tracks.plans(&intent(1, 0..5)));
        assert!(tracks.plans(&intent(1, 3..5)));
        assert!(tracks.lapses(ONE));
        assert!(!tracks.lapses(ONE));
        assert!(tracks.plans(&intent(1, 4..5)), "a robot that returns has a plan again");
        assert!(tracks.plans(&intent(2, 0..0)));
        assert!(!tracks.lapses(ONE), "resting is no plan to lapse");
    }

    #[test]
    fn a_robot_is_expected_along_its_plan_and_a_late_one_in_the_next_cell_now() {
        let grid = Grid::new(1, 9).unwrap();
        let seconds = |track: &Track, now: u64| {
            let expected = track.expected(MissionTime(now * 1_000_000_000), grid, 0.5);
            expected.iter().map(|(cell, time)| (cell.number(), time.as_seconds())).collect::<Vec<_>>()
        };
        let mut track = Track { pose: None, plan: Some(intent(0, 3..6)) };
        assert_eq!(seconds(&track, 7), [(3, 7.0), (4, 9.0), (5, 11.0)]);
        track.pose = Some((cell(2), MissionTime(10_000_000_000)));
        assert_eq!(seconds(&track, 11), [(3, 12.0), (4, 14.0), (5, 16.0)]);
        assert_eq!(seconds(&track, 60), [(3, 60.0), (4, 62.0), (5, 64.0)]);
        track.plan = None;
        assert_eq!(seconds(&track, 11), []);
    }
}
