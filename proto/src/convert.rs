//! Conversion of domain messages to bytes and back. Decoding checks every field: decoded messages are well formed.
//!
//! Encoding a message cannot fail. Decoding needs the mission's [`Grid`]: cells are encoded as numbers, and numbers
//! that are not on the map are rejected.

mod check;
mod directive;
mod error;
mod field;
mod messages;
mod steps;

use std::sync::Arc;

use dragnet_ros2::cdr;
use dragnet_ros2::schema::RosMessage;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Grid;
use dragnet_search::observation::Source;
use serde::de::DeserializeOwned;

pub use error::ConvertError;
pub use field::Field;
pub use steps::NotSimulated;

use self::check::Check;
use self::field::Place;
use crate::dragnet_msgs as wire;
use crate::message::{Message, MessageKind};
use crate::step::{Sensed, Step, StepReply};

/// The bytes of a message.
#[must_use]
pub fn encode(message: &Message) -> Vec<u8> {
    match message {
        Message::Observation(observation) => cdr::encode(&wire::Observation::from(&**observation)),
        Message::Intent(intent) => cdr::encode(&wire::Intent::from(intent)),
        Message::Heartbeat(heartbeat) => cdr::encode(&wire::Heartbeat::from(heartbeat)),
        Message::SyncRequest(request) => cdr::encode(&wire::SyncRequest::from(request)),
        Message::SyncReply(reply) => cdr::encode(&wire::SyncReply::from(reply)),
        Message::MissionStatus(status) => cdr::encode(&wire::MissionStatus::from(status)),
    }
}

/// The bytes of a step.
///
/// # Errors
/// If its event does not exist in simulated time.
pub fn encode_step(step: &Step) -> Result<Vec<u8>, NotSimulated> {
    wire::Step::try_from(step).map(|step| cdr::encode(&step))
}

/// The bytes of the reply to a step.
#[must_use]
pub fn encode_step_reply(reply: &StepReply) -> Vec<u8> {
    cdr::encode(&wire::StepReply::from(reply))
}

/// The bytes of simulated readings.
#[must_use]
pub fn encode_sensed(sensed: &Sensed) -> Vec<u8> {
    cdr::encode(&wire::Sensed::from(sensed))
}

/// Rejects a message whose author is not the participant of its key. Sync replies may repeat observations of any robot.
///
/// # Errors
/// If the message names another participant as its author.
pub fn check_sender(message: &Message, sender: Participant) -> Result<(), ConvertError> {
    let author = match message {
        Message::Observation(observation) => match observation.origin.source {
            Source::Operator => Participant::Coordinator,
            Source::Robot(robot) => Participant::Robot(robot),
        },
        Message::Intent(intent) => Participant::Robot(intent.robot),
        Message::Heartbeat(heartbeat) => Participant::Robot(heartbeat.robot),
        Message::SyncRequest(request) => request.from,
        Message::SyncReply(_) => sender,
        Message::MissionStatus(_) => Participant::Coordinator,
    };
    if author == sender {
        Ok(())
    } else {
        Err(ConvertError::Sender { message: message.kind(), author, sender })
    }
}

/// Decodes messages of a mission on one map.
#[derive(Clone, Copy, Debug)]
pub struct Codec {
    grid: Grid,
    /// Robots of the team, numbered from 1.
    robots: u16,
}

impl Codec {
    /// A codec for messages about this grid, for any team.
    #[must_use]
    pub const fn new(grid: Grid) -> Self {
        Self { grid, robots: u16::MAX }
    }

    /// A codec for messages of this scenario's team: the lengths of lists are limited accordingly.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let robots = u16::try_from(scenario.robots().len()).unwrap_or(u16::MAX);
        Self { grid: scenario.terrain().grid(), robots }
    }

    /// Whether a participant belongs to the team.
    #[must_use]
    pub const fn knows(&self, participant: Participant) -> bool {
        match participant {
            Participant::Robot(robot) => robot.number() <= self.robots,
            Participant::Coordinator => true,
        }
    }

    /// The grid of the mission's map.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Decodes a message of a kind.
    ///
    /// # Errors
    /// If the bytes are invalid: naming message and field, the value and the allowed values.
    pub fn decode(&self, kind: MessageKind, bytes: &[u8]) -> Result<Message, ConvertError> {
        match kind {
            MessageKind::Observation => {
                let (wire, check) = self.read::<wire::Observation>(bytes)?;
                Ok(Message::Observation(Arc::new(check.observation(&wire)?)))
            }
            MessageKind::Intent => {
                let (wire, check) = self.read::<wire::Intent>(bytes)?;
                Ok(Message::Intent(check.intent(&wire)?))
            }
            MessageKind::Heartbeat => {
                let (wire, check) = self.read::<wire::Heartbeat>(bytes)?;
                Ok(Message::Heartbeat(check.heartbeat(&wire)?))
            }
            MessageKind::SyncRequest => {
                let (wire, check) = self.read::<wire::SyncRequest>(bytes)?;
                Ok(Message::SyncRequest(check.sync_request(&wire)?))
            }
            MessageKind::SyncReply => {
                let (wire, check) = self.read::<wire::SyncReply>(bytes)?;
                Ok(Message::SyncReply(check.sync_reply(&wire)?))
            }
            MessageKind::MissionStatus => {
                let (wire, check) = self.read::<wire::MissionStatus>(bytes)?;
                Ok(Message::MissionStatus(check.mission_status(&wire)?))
            }
        }
    }

    /// Decodes a step.
    ///
    /// # Errors
    /// As [`Codec::decode`].
    pub fn decode_step(&self, bytes: &[u8]) -> Result<Step, ConvertError> {
        let (wire, check) = self.read::<wire::Step>(bytes)?;
        check.step(&wire)
    }

    /// Decodes the reply to a step.
    ///
    /// # Errors
    /// As [`Codec::decode`].
    pub fn decode_step_reply(&self, bytes: &[u8]) -> Result<StepReply, ConvertError> {
        let (wire, check) = self.read::<wire::StepReply>(bytes)?;
        check.step_reply(wire)
    }

    /// Decodes simulated readings.
    ///
    /// # Errors
    /// As [`Codec::decode`].
    pub fn decode_sensed(&self, bytes: &[u8]) -> Result<Sensed, ConvertError> {
        let (wire, check) = self.read::<wire::Sensed>(bytes)?;
        check.sensed(&wire)
    }

    /// The version is checked first: a message of another version may have other fields.
    fn read<T: RosMessage + DeserializeOwned>(self, bytes: &[u8]) -> Result<(T, Check), ConvertError> {
        let refused = |source| ConvertError::Bytes { message: T::NAME, source };
        let check = Check { grid: self.grid, robots: self.robots, message: T::NAME, place: Place::Message };
        if let Some(&version) = cdr::body(bytes).map_err(refused)?.first() {
            check.version(version)?;
        }
        Ok((cdr::decode(bytes).map_err(refused)?, check))
    }
}

#[cfg(test)]
mod tests;
