//! Zenoh keys of all messages.
//!
//! ```text
//! dragnet/<mission>/robots/<robot>/{observation,intent,heartbeat,verdicts,orders,zones,marks}
//! dragnet/<mission>/robots/<robot>/picture
//! dragnet/<mission>/robots/<robot>/alive/<seniority>/<identity>
//! dragnet/<mission>/robots/<robot>/scenario/<digest>
//! dragnet/<mission>/robots/<from>/{sync_request,sync_reply}/<to>
//! dragnet/<mission>/coordinator/{status,verdicts,orders,zones,marks}
//! dragnet/<mission>/coordinator/alive/<seniority>/<identity>
//! dragnet/<mission>/coordinator/scenario/<digest>
//! dragnet/<mission>/coordinator/{sync_request,sync_reply}/<to>
//! dragnet/<mission>/sim/step/<participant>
//! dragnet/<mission>/sim/sensed/<robot>
//! ```
//!
//! `<robot>` is a number, `<from>` too; `<to>` and `<participant>` are a number or `coordinator`; `<seniority>` and
//! `<identity>` are the claim of a process ([`crate::sender`]), a number to 255 and 16 hexadecimal digits; `<digest>` is that of
//! its scenario ([`crate::scenario_digest`]). [`Key`]'s `Display` builds each key, its `FromStr` parses each; they are inverse.

mod mission;
mod selection;

use std::fmt;
use std::str::FromStr;

use dragnet_scenario::participant::Participant;
use dragnet_search::observation::RobotId;

pub use mission::{Mission, MissionError};
pub use selection::Selection;

use crate::message::{Audience, MessageKind};
use crate::scenario_digest::ScenarioDigest;
use crate::sender::Claim;

const ROOT: &str = "dragnet";
const COORDINATOR: &str = "coordinator";

/// The key of one kind of message of one sender in a mission.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// The mission.
    pub mission: Mission,
    /// The topic.
    pub topic: Topic,
}

/// The topic of a key: all but its mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// A robot's observations, [`MessageKind::Observation`].
    Observation(RobotId),
    /// A robot's plans, [`MessageKind::Intent`].
    Intent(RobotId),
    /// A robot's heartbeats, [`MessageKind::Heartbeat`].
    Heartbeat(RobotId),
    /// Liveliness token of a participant's process.
    Alive {
        /// The participant.
        participant: Participant,
        /// The claim of its process.
        claim: Claim,
    },
    /// Liveliness token that tells a participant's scenario.
    Scenario {
        /// The participant.
        participant: Participant,
        /// The digest of its scenario.
        digest: ScenarioDigest,
    },
    /// Requests of one participant to another, [`MessageKind::SyncRequest`].
    SyncRequest {
        /// The sender.
        from: Participant,
        /// The receiver.
        to: Participant,
    },
    /// Replies of one participant to another, [`MessageKind::SyncReply`].
    SyncReply {
        /// The sender.
        from: Participant,
        /// The receiver.
        to: Participant,
    },
    /// The coordinator's status, [`MessageKind::MissionStatus`].
    Status,
    /// The operator's verdicts as a participant knows them, [`MessageKind::Verdicts`].
    Verdicts(Participant),
    /// The operator's orders to single robots as a participant knows them, [`MessageKind::Orders`].
    Orders(Participant),
    /// The operator's zones as a participant knows them, [`MessageKind::Zones`].
    Zones(Participant),
    /// The operator's marks as a participant knows them, [`MessageKind::Marks`].
    Marks(Participant),
    /// Queries for a robot's pictures of finds, [`crate::picture::PictureRequest`].
    Picture(RobotId),
    /// Queries of the simulator to a participant, [`crate::step::Step`].
    SimStep(Participant),
    /// The readings of a robot's simulated sensor, [`crate::step::Sensed`].
    SimSensed(RobotId),
}

impl Topic {
    /// The topic under which a participant publishes a message; `None` if it does not publish this kind, or not to this
    /// audience.
    #[must_use]
    pub fn of(kind: MessageKind, from: Participant, to: Audience) -> Option<Self> {
        match (kind, from, to) {
            (MessageKind::Observation, Participant::Robot(robot), Audience::All) => {
                Some(Self::Observation(robot))
            }
            (MessageKind::Intent, Participant::Robot(robot), Audience::All) => Some(Self::Intent(robot)),
            (MessageKind::Heartbeat, Participant::Robot(robot), Audience::All) => {
                Some(Self::Heartbeat(robot))
            }
            (MessageKind::SyncRequest, from, Audience::One(to)) => Some(Self::SyncRequest { from, to }),
            (MessageKind::SyncReply, from, Audience::One(to)) => Some(Self::SyncReply { from, to }),
            (MessageKind::MissionStatus, Participant::Coordinator, Audience::All) => Some(Self::Status),
            (MessageKind::Verdicts, from, Audience::All) => Some(Self::Verdicts(from)),
            (MessageKind::Orders, from, Audience::All) => Some(Self::Orders(from)),
            (MessageKind::Zones, from, Audience::All) => Some(Self::Zones(from)),
            (MessageKind::Marks, from, Audience::All) => Some(Self::Marks(from)),
            _ => None,
        }
    }

    /// The kind and the sender of the messages under this topic; `None` if it is not for messages between participants.
    #[must_use]
    pub const fn speech(self) -> Option<(MessageKind, Participant)> {
        match self {
            Self::Observation(robot) => Some((MessageKind::Observation, Participant::Robot(robot))),
            Self::Intent(robot) => Some((MessageKind::Intent, Participant::Robot(robot))),
            Self::Heartbeat(robot) => Some((MessageKind::Heartbeat, Participant::Robot(robot))),
            Self::SyncRequest { from, .. } => Some((MessageKind::SyncRequest, from)),
            Self::SyncReply { from, .. } => Some((MessageKind::SyncReply, from)),
            Self::Status => Some((MessageKind::MissionStatus, Participant::Coordinator)),
            Self::Verdicts(from) => Some((MessageKind::Verdicts, from)),
            Self::Orders(from) => Some((MessageKind::Orders, from)),
            Self::Zones(from) => Some((MessageKind::Zones, from)),
            Self::Marks(from) => Some((MessageKind::Marks, from)),
            Self::Alive { .. }
            | Self::Scenario { .. }
            | Self::Picture(_)
            | Self::SimStep(_)
            | Self::SimSensed(_) => None,
        }
    }
}

impl fmt::Display for Key {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{ROOT}/{}/", self.mission)?;
        match self.topic {
            Topic::Observation(robot) => write!(formatter, "robots/{robot}/observation"),
            Topic::Intent(robot) => write!(formatter, "robots/{robot}/intent"),
            Topic::Heartbeat(robot) => write!(formatter, "robots/{robot}/heartbeat"),
            Topic::Alive { participant, claim: Claim { seniority, identity } } => {
                write!(formatter, "{}/alive/{seniority}/{identity:016x}", Home(participant))
            }
            Topic::Scenario { participant, digest } => {
                write!(formatter, "{}/scenario/{digest}", Home(participant))
            }
            Topic::SyncRequest { from, to } => {
                write!(formatter, "{}/sync_request/{}", Home(from), Address(to))
            }
            Topic::SyncReply { from, to } => {
                write!(formatter, "{}/sync_reply/{}", Home(from), Address(to))
            }
            Topic::Status => write!(formatter, "{COORDINATOR}/status"),
            Topic::Verdicts(from) => write!(formatter, "{}/verdicts", Home(from)),
            Topic::Orders(from) => write!(formatter, "{}/orders", Home(from)),
            Topic::Zones(from) => write!(formatter, "{}/zones", Home(from)),
            Topic::Marks(from) => write!(formatter, "{}/marks", Home(from)),
            Topic::Picture(robot) => write!(formatter, "robots/{robot}/picture"),
            Topic::SimStep(participant) => write!(formatter, "sim/step/{}", Address(participant)),
            Topic::SimSensed(robot) => write!(formatter, "sim/sensed/{robot}"),
        }
    }
}

/// A participant's part of the key space.
struct Home(Participant);

impl fmt::Display for Home {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Participant::Robot(robot) => write!(formatter, "robots/{robot}"),
            Participant::Coordinator => formatter.write_str(COORDINATOR),
        }
    }
}

/// A participant in the last chunk of a key.
struct Address(Participant);

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Participant::Robot(robot) => write!(formatter, "{robot}"),
            Participant::Coordinator => formatter.write_str(COORDINATOR),
        }
    }
}

/// An invalid key.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// Its mission is invalid.
    #[error("key {key:?}: {source}")]
    Mission {
        /// The whole key.
        key: String,
        /// The error.
        source: MissionError,
    },
    /// Its robot is invalid.
    #[error("key {key:?}: robot {found:?}; allowed are 1 to 65535 without leading zeros")]
    Robot {
        /// The whole key.
        key: String,
        /// The invalid robot number.
        found: String,
    },
    /// No such topic.
    #[error(
        "key {0:?}: allowed are keys like dragnet/<mission>/robots/<robot>/observation, as the module `key` lists them"
    )]
    Unknown(String),
}

impl FromStr for Key {
    type Err = KeyError;

    fn from_str(key: &str) -> Result<Self, KeyError> {
        let unknown = || KeyError::Unknown(key.to_owned());
        let chunks: Vec<&str> = key.split('/').collect();
        let [ROOT, mission, chunks @ ..] = chunks.as_slice() else {
            return Err(unknown());
        };
        let mission = mission.parse().map_err(|source| KeyError::Mission { key: key.to_owned(), source })?;
        let topic = topic(chunks)
            .map_err(|NotARobot(found)| KeyError::Robot { key: key.to_owned(), found })?
            .ok_or_else(unknown)?;
        Ok(Self { mission, topic })
    }
}

/// An invalid robot number in a key.
struct NotARobot(String);

/// The topic of a key, from its chunks after the mission; `None` if there is none.
fn topic(chunks: &[&str]) -> Result<Option<Topic>, NotARobot> {
    let from_coordinator = Participant::Coordinator;
    Ok(Some(match *chunks {
        ["robots", robot, "observation"] => Topic::Observation(number(robot)?),
        ["robots", robot, "intent"] => Topic::Intent(number(robot)?),
        ["robots", robot, "heartbeat"] => Topic::Heartbeat(number(robot)?),
        ["robots", robot, "verdicts"] => Topic::Verdicts(Participant::Robot(number(robot)?)),
        ["robots", robot, "orders"] => Topic::Orders(Participant::Robot(number(robot)?)),
        ["robots", robot, "zones"] => Topic::Zones(Participant::Robot(number(robot)?)),
        ["robots", robot, "marks"] => Topic::Marks(Participant::Robot(number(robot)?)),
        ["robots", robot, "picture"] => Topic::Picture(number(robot)?),
        ["robots", robot, "alive", seniority, identity] => {
            let participant = Participant::Robot(number(robot)?);
            let Some(claim) = claim(seniority, identity) else { return Ok(None) };
            Topic::Alive { participant, claim }
        }
        ["robots", robot, "scenario", digest] => {
            let participant = Participant::Robot(number(robot)?);
            let Ok(digest) = digest.parse() else { return Ok(None) };
            Topic::Scenario { participant, digest }
        }
        ["robots", from, "sync_request", to] => {
            Topic::SyncRequest { from: Participant::Robot(number(from)?), to: address(to)? }
        }
        ["robots", from, "sync_reply", to] => {
            Topic::SyncReply { from: Participant::Robot(number(from)?), to: address(to)? }
        }
        [COORDINATOR, "status"] => Topic::Status,
        [COORDINATOR, "verdicts"] => Topic::Verdicts(from_coordinator),
        [COORDINATOR, "orders"] => Topic::Orders(from_coordinator),
        [COORDINATOR, "zones"] => Topic::Zones(from_coordinator),
        [COORDINATOR, "marks"] => Topic::Marks(from_coordinator),
        [COORDINATOR, "alive", seniority, identity] => {
            let Some(claim) = claim(seniority, identity) else { return Ok(None) };
            Topic::Alive { participant: from_coordinator, claim }
        }
        [COORDINATOR, "scenario", digest] => {
            let Ok(digest) = digest.parse() else { return Ok(None) };
            Topic::Scenario { participant: from_coordinator, digest }
        }
        [COORDINATOR, "sync_request", to] => Topic::SyncRequest { from: from_coordinator, to: address(to)? },
        [COORDINATOR, "sync_reply", to] => Topic::SyncReply { from: from_coordinator, to: address(to)? },
        ["sim", "step", participant] => Topic::SimStep(address(participant)?),
        ["sim", "sensed", robot] => Topic::SimSensed(number(robot)?),
        _ => return Ok(None),
    }))
}

fn address(chunk: &str) -> Result<Participant, NotARobot> {
    if chunk == COORDINATOR { Ok(Participant::Coordinator) } else { number(chunk).map(Participant::Robot) }
}

fn claim(seniority: &str, identity: &str) -> Option<Claim> {
    let claim =
        Claim { seniority: seniority.parse().ok()?, identity: u64::from_str_radix(identity, 16).ok()? };
    // One claim has one spelling, too.
    let is_usual = claim.seniority.to_string() == seniority && format!("{:016x}", claim.identity) == identity;
    is_usual.then_some(claim)
}

/// One number has one spelling, so that a key has only one.
fn number(chunk: &str) -> Result<RobotId, NotARobot> {
    let robot = chunk.parse().ok().and_then(RobotId::new);
    robot.filter(|robot| robot.to_string() == chunk).ok_or_else(|| NotARobot(chunk.to_owned()))
}

#[cfg(test)]
mod tests;
