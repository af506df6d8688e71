//! Conversion of domain messages to bytes and back. Decoding checks every field: decoded messages are well formed.
//!
//! Encoding a message cannot fail. Decoding needs the mission's [`Grid`]: cells are encoded as numbers, and numbers
//! that are not on the map are rejected.

mod check;
mod directive;
mod error;
mod field;
mod marks;
mod messages;
mod orders;
mod packed;
mod pictures;
mod steps;
mod verdicts;
mod zones;

use std::sync::Arc;

use dragnet_ros2::cdr;
use dragnet_ros2::schema::RosMessage;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Grid;
use dragnet_search::observation::Versions;
use serde::de::DeserializeOwned;

pub use error::ConvertError;
pub use field::Field;
pub use packed::PackedError;
pub use steps::NotSimulated;

use self::check::Check;
use self::field::Place;
use self::packed::{Map, Packed};
use crate::dragnet_msgs as wire;
use crate::message::{Heartbeat, Message, MessageKind, SyncReply};
use crate::picture::PicturePart;
use crate::radio;
use crate::step::{Sensed, Step, StepReply};

/// The bytes of a message as a ROS 2 message in CDR.
#[must_use]
pub fn encode(message: &Message) -> Vec<u8> {
    match message {
        Message::Observation(observation) => cdr::encode(&wire::Observation::from(&**observation)),
        Message::Intent(intent) => cdr::encode(&wire::Intent::from(intent)),
        Message::Heartbeat(heartbeat) => cdr::encode(&wire::Heartbeat::from(heartbeat)),
        Message::SyncRequest(request) => cdr::encode(&wire::SyncRequest::from(request)),
        Message::SyncReply(reply) => cdr::encode(&wire::SyncReply::from(reply)),
        Message::MissionStatus(status) => cdr::encode(&wire::MissionStatus::from(status)),
        Message::Verdicts(report) => cdr::encode(&wire::Verdicts::from(report)),
        Message::Orders(report) => cdr::encode(&wire::Orders::from(report)),
        Message::Zones(report) => cdr::encode(&wire::Zones::from(report)),
        Message::Marks(report) => cdr::encode(&wire::Marks::from(report)),
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

/// The bytes of a part of a picture.
#[must_use]
pub fn encode_picture(part: &PicturePart) -> Vec<u8> {
    cdr::encode(&wire::Picture::from(part))
}

/// Rejects a message whose author is not the participant of its key. Sync replies may repeat observations of any robot.
///
/// # Errors
/// If the message names another participant as its author.
pub fn check_sender(message: &Message, sender: Participant) -> Result<(), ConvertError> {
    let author = match message {
        Message::Observation(observation) => observation.origin.source.into(),
        Message::Intent(intent) => Participant::Robot(intent.robot),
        Message::Heartbeat(heartbeat) => Participant::Robot(heartbeat.robot),
        Message::SyncRequest(request) => request.from,
        Message::SyncReply(_) => sender,
        Message::MissionStatus(_) => Participant::Coordinator,
        Message::Verdicts(report) => report.from,
        Message::Orders(report) => report.from,
        Message::Zones(report) => report.from,
        Message::Marks(report) => report.from,
    };
    if author == sender {
        Ok(())
    } else {
        Err(ConvertError::Sender { message: message.kind(), author, sender })
    }
}

/// What each version after the first adds to a version vector: a number of 2 bytes, aligned to 8, and two of 8 bytes.
const VERSION_BYTES: usize = 24;

/// Decodes messages of a mission on one map.
#[derive(Clone, Debug)]
pub struct Codec {
    grid: Grid,
    /// Robots of the team, numbered from 1.
    robots: u16,
    /// How messages are packed, if they are.
    radio: Option<Packing>,
}

/// How messages are packed for radios.
#[derive(Clone, Debug)]
struct Packing {
    /// Rate of the team's radios.
    bytes_per_second: f64,
    /// Noise variance of each robot's sensor, by [`RobotId::index`].
    noise_variances: Arc<[f64]>,
    /// As [`radio::max_observations_of`].
    max_observations: usize,
}

impl Codec {
    /// A codec for messages about this grid, for any team.
    #[must_use]
    pub const fn new(grid: Grid) -> Self {
        Self { grid, robots: u16::MAX, radio: None }
    }

    /// A codec for messages of this scenario's team: the lengths of lists are limited accordingly, and messages are packed if
    /// its radios have a limited rate.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let robots = u16::try_from(scenario.robots().len()).unwrap_or(u16::MAX);
        let sensors = scenario.robots().iter().map(|robot| robot.class.sensor.noise_variance());
        let radio = scenario.network().bytes_per_second.map(|bytes_per_second| Packing {
            bytes_per_second,
            noise_variances: sensors.collect(),
            max_observations: radio::max_observations_of(scenario),
        });
        Self { grid: scenario.terrain().grid(), robots, radio }
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

    /// Rate of the team's radios, bytes per second, if it is limited.
    #[must_use]
    pub fn bytes_per_second(&self) -> Option<f64> {
        self.radio.as_ref().map(|packing| packing.bytes_per_second)
    }

    /// The maximum number of observations in one reply.
    #[must_use]
    pub fn max_observations(&self) -> usize {
        self.radio.as_ref().map_or(SyncReply::MAX_OBSERVATIONS, |packing| packing.max_observations)
    }

    /// The bytes of a message: packed, or as [`encode`].
    #[must_use]
    pub fn encode(&self, message: &Message) -> Vec<u8> {
        let Some(Packing { noise_variances, .. }) = &self.radio else { return encode(message) };
        let map = Map { grid: self.grid, noise_variances };
        match message {
            Message::Observation(observation) => packed::pack(&wire::Observation::from(&**observation), map),
            Message::Intent(intent) => packed::pack(&wire::Intent::from(intent), map),
            Message::Heartbeat(heartbeat) => packed::pack(&wire::Heartbeat::from(heartbeat), map),
            Message::SyncRequest(request) => packed::pack(&wire::SyncRequest::from(request), map),
            Message::SyncReply(reply) => packed::pack(&wire::SyncReply::from(reply), map),
            Message::MissionStatus(status) => packed::pack(&wire::MissionStatus::from(status), map),
            Message::Verdicts(report) => packed::pack(&wire::Verdicts::from(report), map),
            Message::Orders(report) => packed::pack(&wire::Orders::from(report), map),
            Message::Zones(report) => packed::pack(&wire::Zones::from(report), map),
            Message::Marks(report) => packed::pack(&wire::Marks::from(report), map),
        }
    }

    /// The number of bytes of a message. Most bytes of a large team are version vectors, whose length needs no encoding.
    #[must_use]
    pub fn encoded_len(&self, message: &Message) -> usize {
        match message {
            Message::Heartbeat(heartbeat) if self.radio.is_none() && heartbeat.versions.len() > 1 => {
                let versions: Versions = heartbeat.versions.iter().copied().take(1).collect();
                let short = Heartbeat { versions, ..heartbeat.clone() };
                encode(&Message::Heartbeat(short)).len() + (heartbeat.versions.len() - 1) * VERSION_BYTES
            }
            message => self.encode(message).len(),
        }
    }

    /// Decodes a message of a kind, packed or not.
    ///
    /// # Errors
    /// If the bytes are invalid: naming message and field, the value and the allowed values.
    pub fn decode(&self, kind: MessageKind, bytes: &[u8]) -> Result<Message, ConvertError> {
        match kind {
            MessageKind::Observation => {
                let (wire, check) = self.read_observation(bytes)?;
                Ok(Message::Observation(Arc::new(check.observation(&wire)?)))
            }
            MessageKind::Intent => {
                let (wire, check) = self.read_any::<wire::Intent>(wire::VERSION, bytes)?;
                Ok(Message::Intent(check.intent(&wire)?))
            }
            MessageKind::Heartbeat => {
                let (wire, check) = self.read_any::<wire::Heartbeat>(wire::VERSION, bytes)?;
                Ok(Message::Heartbeat(check.heartbeat(&wire)?))
            }
            MessageKind::SyncRequest => {
                let (wire, check) = self.read_any::<wire::SyncRequest>(wire::VERSION, bytes)?;
                Ok(Message::SyncRequest(check.sync_request(&wire)?))
            }
            MessageKind::SyncReply => {
                let (wire, check) = self.read_any::<wire::SyncReply>(wire::OBSERVATION_VERSION, bytes)?;
                Ok(Message::SyncReply(check.sync_reply(&wire)?))
            }
            MessageKind::MissionStatus => {
                let (wire, check) = self.read_any::<wire::MissionStatus>(wire::VERSION, bytes)?;
                Ok(Message::MissionStatus(check.mission_status(&wire)?))
            }
            MessageKind::Verdicts => {
                let (wire, check) = self.read_any::<wire::Verdicts>(wire::VERSION, bytes)?;
                Ok(Message::Verdicts(check.verdicts(&wire)?))
            }
            MessageKind::Orders => {
                let (wire, check) = self.read_any::<wire::Orders>(wire::VERSION, bytes)?;
                Ok(Message::Orders(check.orders(&wire)?))
            }
            MessageKind::Zones => {
                let (wire, check) = self.read_any::<wire::Zones>(wire::VERSION, bytes)?;
                Ok(Message::Zones(check.zones(&wire)?))
            }
            MessageKind::Marks => {
                let (wire, check) = self.read_any::<wire::Marks>(wire::VERSION, bytes)?;
                Ok(Message::Marks(check.marks(&wire)?))
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
        let (wire, check) = self.read_version::<wire::StepReply>(wire::STEP_REPLY_VERSION, bytes)?;
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

    /// Decodes a part of a picture.
    ///
    /// # Errors
    /// As [`Codec::decode`].
    pub fn decode_picture(&self, bytes: &[u8]) -> Result<PicturePart, ConvertError> {
        let (wire, check) = self.read::<wire::Picture>(bytes)?;
        check.picture(wire)
    }

    fn read_any<T: RosMessage + DeserializeOwned + Packed>(
        &self,
        version: u8,
        bytes: &[u8],
    ) -> Result<(T, Check), ConvertError> {
        if bytes.first() != Some(&packed::MARK) {
            return self.read_version(version, bytes);
        }
        let refused = |source| ConvertError::Packed { message: T::NAME, source };
        Ok((packed::unpack(bytes, self.grid).map_err(refused)?, self.check::<T>(version)))
    }

    /// Recordings and journals of earlier programs hold observations of an earlier version.
    fn read_observation(&self, bytes: &[u8]) -> Result<(wire::Observation, Check), ConvertError> {
        let version = cdr::body(bytes).ok().and_then(|body| body.first());
        if version != Some(&wire::EarlierObservation::VERSION) {
            return self.read_any(wire::OBSERVATION_VERSION, bytes);
        }
        let refused = |source| ConvertError::Bytes { message: wire::Observation::NAME, source };
        let earlier: wire::EarlierObservation = cdr::decode(bytes).map_err(refused)?;
        Ok((earlier.into(), self.check::<wire::Observation>(wire::OBSERVATION_VERSION)))
    }

    const fn check<T: RosMessage>(&self, version: u8) -> Check {
        let &Self { grid, robots, .. } = self;
        Check { grid, robots, version, message: T::NAME, place: Place::Message }
    }

    fn read<T: RosMessage + DeserializeOwned>(&self, bytes: &[u8]) -> Result<(T, Check), ConvertError> {
        self.read_version(wire::VERSION, bytes)
    }

    /// The version is checked first: a message of another version may have other fields.
    fn read_version<T: RosMessage + DeserializeOwned>(
        &self,
        version: u8,
        bytes: &[u8],
    ) -> Result<(T, Check), ConvertError> {
        let refused = |source| ConvertError::Bytes { message: T::NAME, source };
        let check = self.check::<T>(version);
        if let Some(&version) = cdr::body(bytes).map_err(refused)?.first() {
            check.version(version)?;
        }
        Ok((cdr::decode(bytes).map_err(refused)?, check))
    }
}

#[cfg(test)]
mod tests;
