//! The owners of a mission's certificates.

use std::fmt;
use std::str::FromStr;

use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;
use serde::{Deserialize, Serialize};

/// An owner of a certificate: `robot-1` and so on, `coordinator`, `sim`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Name {
    /// A robot or the coordinator.
    Participant(Participant),
    /// The simulated world.
    Simulator,
}

/// An invalid name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("participant {0:?}: allowed are robot-1 to robot-65535, coordinator and sim")]
pub struct NameError(String);

impl Name {
    /// The name of a robot, by its number from 1.
    #[must_use]
    pub const fn robot(number: u16) -> Option<Self> {
        match RobotId::new(number) {
            Some(robot) => Some(Self::Participant(Participant::Robot(robot))),
            None => None,
        }
    }

    /// The name of the coordinator.
    pub const COORDINATOR: Self = Self::Participant(Participant::Coordinator);
}

impl fmt::Display for Name {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Participant(Participant::Robot(robot)) => write!(formatter, "robot-{robot}"),
            Self::Participant(Participant::Coordinator) => formatter.write_str("coordinator"),
            Self::Simulator => formatter.write_str("sim"),
        }
    }
}

impl FromStr for Name {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let name = match text {
            "coordinator" => Some(Self::COORDINATOR),
            "sim" => Some(Self::Simulator),
            _ => text.strip_prefix("robot-").and_then(|number| Self::robot(number.parse().ok()?)),
        };
        // One name has one spelling: robot-01 is invalid.
        name.filter(|name| name.to_string() == text).ok_or_else(|| NameError(text.to_owned()))
    }
}

impl TryFrom<String> for Name {
    type Error = NameError;

    fn try_from(text: String) -> Result<Self, NameError> {
        text.parse()
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_one_spelling() {
        for text in ["robot-1", "robot-65535", "coordinator", "sim"] {
            assert_eq!(text.parse::<Name>().unwrap().to_string(), text);
        }
        for text in ["robot-0", "robot-01", "robot-65536", "robot", "robot-1/../x", "Sim", ""] {
            assert_eq!(text.parse::<Name>(), Err(NameError(text.to_owned())));
        }
    }
}
