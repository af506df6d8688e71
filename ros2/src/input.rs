//! What a robot's sensors and its navigation say, checked: a value in hand is in its range, in meters and radians.
//!
//! Lengths are held against a bound before anything is allocated for them, and a message that is not well formed is
//! refused as a whole: with its name, the field, what stood there and what is allowed.

mod camera;
mod check;
mod map;
mod motion;
mod navigation;
mod picture;

use serde::de::DeserializeOwned;

pub use camera::{DetectedBox, Detections, Hypothesis};
pub use map::Occupancy;
pub use motion::{Fix, Odometry, PlanarCovariance, PlanarPose, PoseEstimate, Velocity};
pub use navigation::{GoalId, GoalState, GoalStatus};
pub use picture::Image;

use super::qos::Qos;
use crate::cdr::{self, DecodeError};
use crate::schema::MessageType;
use crate::schema::RosMessage;
use crate::wire::{robot, standard, vision};

/// What a topic says.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// `nav_msgs/Odometry`: where the robot is, and how it moves.
    Odometry(Odometry),
    /// `geometry_msgs/PoseWithCovarianceStamped`: where the robot is.
    Pose(PoseEstimate),
    /// `sensor_msgs/NavSatFix`: where on earth it is.
    Fix(Fix),
    /// `nav_msgs/OccupancyGrid`: where robots can be.
    Map(Occupancy),
    /// `vision_msgs/Detection2DArray`: what a detector sees in an image.
    Detections(Detections),
    /// `sensor_msgs/Image` or `sensor_msgs/CompressedImage`.
    Image(Image),
    /// `action_msgs/GoalStatusArray`: goals of an action, those of Nav2.
    Goals(Vec<GoalStatus>),
}

/// What a topic is heard for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InputKind {
    /// [`Input::Odometry`].
    Odometry,
    /// [`Input::Pose`].
    Pose,
    /// [`Input::Fix`].
    Fix,
    /// [`Input::Map`].
    Map,
    /// [`Input::Detections`].
    Detections,
    /// [`Input::Image`], as `sensor_msgs/Image`.
    Image,
    /// [`Input::Image`], as `sensor_msgs/CompressedImage`.
    CompressedImage,
    /// [`Input::Goals`].
    Goals,
}

impl InputKind {
    /// Its type on the network.
    #[must_use]
    pub fn message(self) -> MessageType {
        match self {
            Self::Odometry => MessageType::of::<robot::Odometry>(),
            Self::Pose => MessageType::of::<robot::PoseWithCovarianceStamped>(),
            Self::Fix => MessageType::of::<robot::NavSatFix>(),
            Self::Map => MessageType::of::<standard::OccupancyGrid>(),
            Self::Detections => MessageType::of::<vision::Detection2DArray>(),
            Self::Image => MessageType::of::<robot::Image>(),
            Self::CompressedImage => MessageType::of::<robot::CompressedImage>(),
            Self::Goals => MessageType::of::<robot::GoalStatusArray>(),
        }
    }

    /// How it is heard. Of images and of places the newest one says all. AMCL's pose is latched, and comes only when the
    /// vehicle moves; publishers that latch nothing are heard alike.
    #[must_use]
    pub const fn qos(self) -> Qos {
        match self {
            Self::Odometry | Self::Fix | Self::Detections => Qos::SENSOR,
            Self::Image | Self::CompressedImage => Qos { depth: 1, ..Qos::SENSOR },
            Self::Pose | Self::Map | Self::Goals => Qos::LATCHED,
        }
    }

    /// The most bytes of such a message: what is longer is not even copied.
    #[must_use]
    pub const fn max_bytes(self) -> usize {
        match self {
            Self::Odometry | Self::Pose | Self::Fix => 8 << 10,
            Self::Detections => 1 << 20,
            Self::Goals => 256 << 10,
            Self::Map | Self::Image | Self::CompressedImage => cdr::MAX_BYTES,
        }
    }

    /// What the bytes of such a message say.
    ///
    /// # Errors
    /// If they are too many, no such message, or hold what cannot be.
    pub fn understand(self, bytes: &[u8]) -> Result<Input, InputError> {
        match self {
            Self::Odometry => Odometry::check(&self.decode(bytes)?).map(Input::Odometry),
            Self::Pose => PoseEstimate::check(&self.decode(bytes)?).map(Input::Pose),
            Self::Fix => Fix::check(&self.decode(bytes)?).map(Input::Fix),
            Self::Map => Occupancy::check(self.decode(bytes)?).map(Input::Map),
            Self::Detections => Detections::check(self.decode(bytes)?).map(Input::Detections),
            Self::Image => Image::check(&self.decode(bytes)?).map(Input::Image),
            Self::CompressedImage => Image::decompress(&self.decode(bytes)?).map(Input::Image),
            Self::Goals => navigation::check(&self.decode(bytes)?).map(Input::Goals),
        }
    }

    /// Whether such a message can have so many bytes.
    ///
    /// # Errors
    /// If it cannot.
    pub fn check_length(self, bytes: usize) -> Result<(), InputError> {
        let most = self.max_bytes();
        if bytes <= most {
            return Ok(());
        }
        Err(InputError::Length { message: self.message().name, found: bytes, most })
    }

    fn decode<T: RosMessage + DeserializeOwned>(self, bytes: &[u8]) -> Result<T, InputError> {
        self.check_length(bytes.len())?;
        cdr::decode(bytes).map_err(|source| InputError::Bytes { message: T::NAME, source })
    }
}

/// A message that is refused.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// More bytes than such a message has.
    #[error("{message}: {found} bytes; allowed are at most {most}")]
    Length {
        /// Its ROS name.
        message: &'static str,
        /// Bytes.
        found: usize,
        /// The most.
        most: usize,
    },
    /// Not the bytes of such a message at all: its publisher has another type.
    #[error("not the bytes of {message}: {source}")]
    Bytes {
        /// Its ROS name.
        message: &'static str,
        /// What is wrong with them.
        source: DecodeError,
    },
    /// A value that cannot be.
    #[error("{message}: {field} is {found}; allowed is {allowed}")]
    Value {
        /// Its ROS name.
        message: &'static str,
        /// Where it stood.
        field: String,
        /// The value.
        found: String,
        /// What it could have been.
        allowed: String,
    },
}

#[cfg(test)]
mod tests;
