//! Messages of a robot's sensors and navigation, checked: decoded values are in range, in meters and radians.
//!
//! Lengths are checked against a bound before anything is allocated for them, and an invalid message is rejected as a
//! whole: the error names the message, the field, its value and the allowed values.

mod battery;
mod camera;
mod check;
mod map;
mod motion;
mod navigation;
mod optics;
mod picture;
mod transforms;

use serde::de::DeserializeOwned;

pub use battery::Battery;
pub use camera::{DetectedBox, Detections, Hypothesis};
pub use map::Occupancy;
pub use motion::{Fix, Odometry, PlanarCovariance, PlanarPose, PoseEstimate, Velocity};
pub use navigation::{GoalId, GoalState, GoalStatus};
pub use optics::{CameraInfo, Distortion};
pub use picture::Image;
pub use transforms::{Transform, Transforms};

use super::qos::Qos;
use crate::cdr::{self, DecodeError};
use crate::schema::MessageType;
use crate::schema::RosMessage;
use crate::wire::{robot, standard, vision};

/// The content of a message.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// `nav_msgs/Odometry`: the robot's pose and velocity.
    Odometry(Odometry),
    /// `geometry_msgs/PoseWithCovarianceStamped`: the robot's pose.
    Pose(PoseEstimate),
    /// `sensor_msgs/NavSatFix`: the robot's position on the earth.
    Fix(Fix),
    /// `nav_msgs/OccupancyGrid`: traversable cells.
    Map(Occupancy),
    /// `vision_msgs/Detection2DArray`: a detector's boxes in an image.
    Detections(Detections),
    /// `sensor_msgs/Image` or `sensor_msgs/CompressedImage`.
    Image(Image),
    /// `action_msgs/GoalStatusArray`: goals of an action, those of Nav2.
    Goals(Vec<GoalStatus>),
    /// `tf2_msgs/TFMessage` of `/tf`: where frames are at a time.
    Transforms(Transforms),
    /// `tf2_msgs/TFMessage` of `/tf_static`: where frames are at all times.
    StaticTransforms(Transforms),
    /// `sensor_msgs/CameraInfo`: a camera's calibration.
    CameraInfo(CameraInfo),
    /// `std_msgs/Bool` of an emergency stop: whether the robot is stopped.
    Stop(bool),
    /// `sensor_msgs/BatteryState`.
    Battery(Battery),
}

/// The kind of message that a topic is subscribed for.
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
    /// [`Input::Transforms`].
    Transforms,
    /// [`Input::StaticTransforms`].
    StaticTransforms,
    /// [`Input::CameraInfo`].
    CameraInfo,
    /// [`Input::Stop`].
    Stop,
    /// [`Input::Battery`].
    Battery,
}

impl InputKind {
    /// All kinds.
    pub const ALL: [Self; 13] = [
        Self::Odometry,
        Self::Pose,
        Self::Fix,
        Self::Map,
        Self::Detections,
        Self::Image,
        Self::CompressedImage,
        Self::Goals,
        Self::Transforms,
        Self::StaticTransforms,
        Self::CameraInfo,
        Self::Stop,
        Self::Battery,
    ];

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
            Self::Transforms | Self::StaticTransforms => MessageType::of::<standard::TFMessage>(),
            Self::CameraInfo => MessageType::of::<robot::CameraInfo>(),
            Self::Stop => MessageType::of::<robot::Bool>(),
            Self::Battery => MessageType::of::<robot::BatteryState>(),
        }
    }

    /// The quality of service of the subscription. Of images and positions only the newest is needed. AMCL's pose is
    /// latched, and published only when the vehicle moves; volatile publishers are received too.
    #[must_use]
    pub const fn qos(self) -> Qos {
        match self {
            Self::Odometry | Self::Fix | Self::Detections | Self::CameraInfo | Self::Battery => Qos::SENSOR,
            Self::Image | Self::CompressedImage => Qos { depth: 1, ..Qos::SENSOR },
            Self::Pose | Self::Map | Self::Goals | Self::Stop => Qos::LATCHED,
            Self::Transforms => Qos::TRANSFORMS,
            Self::StaticTransforms => Qos::STATIC_TRANSFORMS,
        }
    }

    /// The maximum size of a message of this kind, bytes: longer ones are rejected before they are copied.
    #[must_use]
    pub const fn max_bytes(self) -> usize {
        match self {
            Self::Odometry | Self::Pose | Self::Fix | Self::CameraInfo | Self::Stop | Self::Battery => {
                8 << 10
            }
            Self::Detections | Self::Transforms | Self::StaticTransforms => 1 << 20,
            Self::Goals => 256 << 10,
            Self::Map | Self::Image | Self::CompressedImage => cdr::MAX_BYTES,
        }
    }

    /// Decodes and checks a message of this kind.
    ///
    /// # Errors
    /// If it is too long, is not a message of this kind, or contains an invalid value.
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
            Self::Transforms => Transforms::check(self.decode(bytes)?).map(Input::Transforms),
            Self::StaticTransforms => Transforms::check(self.decode(bytes)?).map(Input::StaticTransforms),
            Self::CameraInfo => CameraInfo::check(&self.decode(bytes)?).map(Input::CameraInfo),
            Self::Stop => self.decode(bytes).map(|robot::Bool { data }| Input::Stop(data)),
            Self::Battery => Battery::check(&self.decode(bytes)?).map(Input::Battery),
        }
    }

    /// Checks the size of a message of this kind.
    ///
    /// # Errors
    /// If it is too long.
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

/// Why a message is rejected.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The message is longer than a message of this kind can be.
    #[error("{message}: {found} bytes; allowed are at most {most}")]
    Length {
        /// Its ROS name.
        message: &'static str,
        /// Its size, bytes.
        found: usize,
        /// The maximum.
        most: usize,
    },
    /// The bytes are not a message of this type: its publisher uses another type.
    #[error("not the bytes of {message}: {source}")]
    Bytes {
        /// Its ROS name.
        message: &'static str,
        /// The decoding error.
        source: DecodeError,
    },
    /// An invalid value.
    #[error("{message}: {field} is {found}; allowed is {allowed}")]
    Value {
        /// Its ROS name.
        message: &'static str,
        /// The field.
        field: String,
        /// The value.
        found: String,
        /// The allowed values.
        allowed: String,
    },
}

#[cfg(test)]
mod tests;
