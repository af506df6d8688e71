//! Whether the search is over, or waits for the operator, by the activities of the robots that are here.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_coordinator::liveness::named;
use dragnet_proto::message::Activity;
use dragnet_search::observation::RobotId;

/// The last activities of robots, and what was told of them.
#[derive(Default)]
pub(super) struct Ending {
    activities: BTreeMap<RobotId, Activity>,
    /// Robots that are here, and have not told yet what they do.
    silent: BTreeSet<RobotId>,
    is_over: bool,
    /// Robots that the search waits for.
    held: BTreeSet<RobotId>,
    /// Robots that the end of the mission waits for.
    awaited: Vec<RobotId>,
}

impl Ending {
    /// A robot is here.
    pub(super) fn expect(&mut self, robot: RobotId) {
        if !self.activities.contains_key(&robot) {
            self.silent.insert(robot);
        }
    }

    /// A robot does this.
    pub(super) fn receive(&mut self, robot: RobotId, activity: Activity) {
        self.silent.remove(&robot);
        self.activities.insert(robot, activity);
    }

    /// A robot has left; returns what it did last.
    pub(super) fn lose(&mut self, robot: RobotId) -> Option<Activity> {
        self.silent.remove(&robot);
        self.activities.remove(&robot)
    }

    /// That all robots rest, and why, once.
    pub(super) fn rests(&mut self) -> Option<String> {
        let is_known = self.silent.is_empty() && !self.activities.is_empty();
        let is_over = is_known && self.activities.values().all(|it| it.is_rest());
        let was_over = std::mem::replace(&mut self.is_over, is_over);
        let mut reasons: BTreeMap<&str, Vec<RobotId>> = BTreeMap::new();
        for (&robot, activity) in &self.activities {
            reasons.entry(activity.reason()).or_default().push(robot);
        }
        let is_one = reasons.len() == 1;
        let line = |(reason, robots): (&str, Vec<RobotId>)| {
            if is_one { reason.to_owned() } else { format!("{}: {reason}", named(&robots)) }
        };
        let reasons = reasons.into_iter().map(line).collect::<Vec<_>>().join("; ");
        (is_over && !was_over)
            .then(|| format!("all robots that are here ({}) rest, {reasons}", self.activities.len()))
    }

    /// That the search would be over but for robots that stay where they are by the operator's order, once.
    pub(super) fn waits(&mut self) -> Option<String> {
        let is_held = |activity: Activity| matches!(activity, Activity::Holding | Activity::Paused);
        let waits = self.silent.is_empty() && self.activities.values().all(|&it| it.is_rest() || is_held(it));
        let held = self.activities.iter().filter(|&(_, &activity)| waits && is_held(activity));
        let (robots, activities): (Vec<RobotId>, Vec<Activity>) = held.unzip();
        let now: BTreeSet<RobotId> = robots.iter().copied().collect();
        let before = std::mem::replace(&mut self.held, now);
        if self.held.is_empty() || self.held == before {
            return None;
        }
        let (stays, is, them) =
            if robots.len() == 1 { ("holds", "is", "it") } else { ("hold", "are", "them") };
        let what = match [Activity::Holding, Activity::Paused].map(|it| activities.contains(&it)) {
            [true, false] => stays.to_owned(),
            [false, _] => format!("{is} paused"),
            [true, true] => format!("{stays} or {is} paused"),
        };
        let robots = named(&robots);
        Some(format!(
            "the search waits for {robots}, which {what} by your order: resume {them}, or call {them} back"
        ))
    }

    /// That the mission ends once these robots are back, whenever they change.
    pub(super) fn awaits(&mut self, awaited: Option<Vec<RobotId>>) -> Option<String> {
        let awaited = awaited.unwrap_or_default();
        if awaited == self.awaited {
            return None;
        }
        self.awaited = awaited;
        let are = if self.awaited.len() == 1 { "is" } else { "are" };
        (!self.awaited.is_empty())
            .then(|| format!("the mission ends once {} {are} back", named(&self.awaited)))
    }
}

#[cfg(test)]
mod tests {
    use super::Activity::{Cleared, Holding, Paused, Searching, Spent};
    use super::*;

    fn robot(number: u16) -> RobotId {
        RobotId::new(number).unwrap()
    }

    #[test]
    fn the_robots_of_each_reason_are_named_where_reasons_differ() {
        let mut ending = Ending::default();
        let mut rests = |number, activity| {
            ending.receive(robot(number), activity);
            ending.rests()
        };
        assert_eq!(
            rests(1, Cleared).unwrap(),
            "all robots that are here (1) rest, too little is left for it to find"
        );
        assert_eq!(rests(2, Searching), None);
        assert_eq!(rests(3, Cleared), None);
        assert_eq!(
            rests(2, Spent).unwrap(),
            "all robots that are here (3) rest, robot 2: its budget or battery leaves no further step; \
             robots 1, 3: too little is left for it to find"
        );
        assert_eq!(rests(2, Spent), None, "once");
        assert_eq!(rests(2, Searching), None);
        assert!(rests(2, Spent).is_some(), "again");
    }

    #[test]
    fn nothing_is_over_before_each_robot_that_is_here_has_told_what_it_does() {
        let mut ending = Ending::default();
        ending.expect(robot(1));
        ending.expect(robot(2));
        ending.receive(robot(1), Cleared);
        assert_eq!((ending.rests(), ending.waits()), (None, None));
        ending.receive(robot(2), Holding);
        assert!(ending.waits().is_some());
        ending.expect(robot(3));
        ending.receive(robot(2), Cleared);
        assert_eq!(ending.rests(), None);
        ending.lose(robot(3));
        assert!(ending.rests().unwrap().starts_with("all robots that are here (2) rest"));
    }

    #[test]
    fn the_robots_that_the_end_waits_for_are_told_whenever_they_change() {
        let mut ending = Ending::default();
        assert_eq!(ending.awaits(None), None);
        let all = || Some([1, 2, 3].map(robot).to_vec());
        assert_eq!(ending.awaits(all()).unwrap(), "the mission ends once robots 1 to 3 are back");
        assert_eq!(ending.awaits(all()), None, "once");
        let one = Some(vec![robot(2)]);
        assert_eq!(ending.awaits(one).unwrap(), "the mission ends once robot 2 is back");
        assert_eq!(ending.awaits(Some(Vec::new())), None);
    }

    #[test]
    fn a_search_that_is_held_open_by_the_operator_is_told_once() {
        let mut ending = Ending::default();
        let mut waits = |activities: &[(u16, Activity)]| {
            for &(number, activity) in activities {
                ending.receive(robot(number), activity);
            }
            ending.waits()
        };
        assert_eq!(waits(&[(1, Cleared), (2, Searching), (3, Holding)]), None, "one searches");
        let one = "the search waits for robot 3, which holds by your order: resume it, or call it back";
        assert_eq!(waits(&[(2, Spent)]).unwrap(), one);
        assert_eq!(waits(&[(2, Spent)]), None, "once");
        assert_eq!(
            waits(&[(2, Paused)]).unwrap(),
            "the search waits for robots 2, 3, which hold or are paused by your order: resume them, or call them back"
        );
        assert_eq!(waits(&[(2, Searching)]), None);
        assert_eq!(waits(&[(2, Cleared)]).unwrap(), one, "it waits again");
        assert_eq!(waits(&[(3, Cleared)]), None, "all rest");
        let paused = waits(&[(1, Paused), (2, Paused), (3, Paused)]).unwrap();
        assert!(paused.starts_with("the search waits for robots 1 to 3, which are paused by your order"));
    }
}
