//! Participants of a mission.

use std::fmt;

use dragnet_search::observation::RobotId;

/// A participant of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Participant {
    /// A robot of the team.
    Robot(RobotId),
    /// The coordinator, which declares finds and records.
    Coordinator,
}

impl fmt::Display for Participant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot(robot) => write!(formatter, "robot {robot}"),
            Self::Coordinator => write!(formatter, "the coordinator"),
        }
    }
}
