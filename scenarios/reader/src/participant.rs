//! Participants of a mission.

use std::fmt;

use dragnet_search::observation::{RobotId, Source};

/// A participant of a mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Participant {
    /// A robot of the team.
    Robot(RobotId),
    /// The coordinator, which declares finds and records.
    Coordinator,
}

/// The operator gives commands at the coordinator.
impl From<Participant> for Source {
    fn from(participant: Participant) -> Self {
        match participant {
            Participant::Robot(robot) => Self::Robot(robot),
            Participant::Coordinator => Self::Operator,
        }
    }
}

impl From<Source> for Participant {
    fn from(source: Source) -> Self {
        match source {
            Source::Robot(robot) => Self::Robot(robot),
            Source::Operator => Self::Coordinator,
        }
    }
}

impl fmt::Display for Participant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot(robot) => write!(formatter, "robot {robot}"),
            Self::Coordinator => write!(formatter, "the coordinator"),
        }
    }
}
