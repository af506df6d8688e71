//! The end of a mission, as the operator orders it: the mission ends once every robot of the team is back.
//!
//! A robot is back once it has told that it rests under that order, or under a later one. It may leave the network then: it
//! is not awaited. One that is away, or has never come, is: it may still bring finds. So is one that the operator has told
//! something else since. The operator can end the mission without it.

use std::collections::BTreeMap;

use dragnet_proto::directive::{Directive, TeamOrder};
use dragnet_proto::message::Heartbeat;
use dragnet_search::observation::{ObservationLog, RobotId, Versions};

/// The robots that rest.
#[derive(Clone, Debug, Default)]
pub struct Resting(BTreeMap<RobotId, Rest>);

/// What a robot that rests knew then.
#[derive(Clone, Debug)]
struct Rest {
    /// The order to all robots, with its number.
    order: (u64, TeamOrder),
    /// Its observations, and those of others.
    versions: Versions,
}

impl Resting {
    /// Applies a heartbeat.
    pub fn beat(&mut self, heartbeat: &Heartbeat) {
        if heartbeat.activity.is_rest() {
            let rest =
                Rest { order: heartbeat.directive.numbered_order(), versions: heartbeat.versions.clone() };
            self.0.insert(heartbeat.robot, rest);
        } else {
            self.0.remove(&heartbeat.robot);
        }
    }

    /// The robots that are not known to be back, if the directive ends the mission. `is_called` says whether that is what the
    /// operator wants of a robot, or another order to it alone is newer.
    #[must_use]
    pub fn awaited(
        &self,
        team: impl IntoIterator<Item = RobotId>,
        directive: &Directive,
        is_called: impl Fn(RobotId) -> bool,
    ) -> Option<Vec<RobotId>> {
        let knows =
            |robot: &RobotId| self.0.get(robot).is_some_and(|rest| rest.order >= directive.numbered_order());
        let is_back = |robot: &RobotId| is_called(*robot) && knows(robot);
        let is_ending = directive.order == TeamOrder::End;
        is_ending.then(|| team.into_iter().filter(|robot| !is_back(robot)).collect())
    }

    /// Whether a log has all observations that these robots have.
    pub(crate) fn are_in(&self, log: &ObservationLog) -> bool {
        self.0.values().all(|rest| log.missing(&rest.versions).is_empty())
    }
}
