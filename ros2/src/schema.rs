//! ROS names and definitions of all messages, for recordings and bridges.
//!
//! A schema is the definition of a message followed by those of all messages in it, as MCAP's encoding `ros2msg`
//! requires: a reader needs no other file.

mod markers;
mod robot;
mod standard;
mod type_hash;

use serde::Serialize;

use crate::wire::{markers as signs, robot as robots, standard as others, vision};

/// The encoding of schemas, as MCAP and Foxglove name it.
pub const ENCODING: &str = "ros2msg";
/// Width of the separator between the definitions of a schema.
const SEPARATOR_WIDTH: usize = 80;

/// Texts of `.msg` files by package and name, such as `nav_msgs/Path`.
pub type Definitions = &'static [(&'static str, &'static str)];

/// A wire struct that is a ROS 2 message.
pub trait RosMessage: Serialize {
    /// Package, `msg` and name, such as `nav_msgs/msg/OccupancyGrid`.
    const NAME: &'static str;
    /// Definitions of its package, if this crate does not have them.
    const DEFINITIONS: Definitions = &[];

    /// Its definition and those of all messages in it, encoding `ros2msg`.
    #[must_use]
    fn schema() -> String {
        schema(Self::NAME, Self::DEFINITIONS)
    }

    /// Its bytes, as [`crate::cdr::encode`]: of long messages that are encoded often, compiled where the message is
    /// defined.
    #[must_use]
    fn to_cdr(&self) -> Vec<u8>;

    /// `RIHS01_` and 64 hexadecimal digits: ROS 2 nodes compare it to check that they mean the same message.
    #[must_use]
    fn type_hash() -> String {
        type_hash(Self::NAME, Self::DEFINITIONS)
    }
}

/// The name and type hash of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageType {
    /// Package, `msg` and name, such as `nav_msgs/msg/Odometry`.
    pub name: &'static str,
    /// The hash of its definition, `RIHS01_` and 64 hexadecimal digits.
    pub hash: String,
}

impl MessageType {
    /// The type of a wire struct.
    #[must_use]
    pub fn of<T: RosMessage>() -> Self {
        Self { name: T::NAME, hash: T::type_hash() }
    }

    /// The name as mangled by DDS, such as `nav_msgs::msg::dds_::Odometry_`.
    #[must_use]
    pub fn dds_name(&self) -> String {
        match self.name.rsplit_once('/') {
            Some((package, name)) => format!("{}::dds_::{name}_", package.replace('/', "::")),
            None => self.name.to_owned(),
        }
    }
}

macro_rules! ros_messages {
    ($($message:ty => $name:literal,)*) => {
        $(impl RosMessage for $message {
            fn to_cdr(&self) -> Vec<u8> {
                $crate::cdr::encode(self)
            }
            const NAME: &'static str = $name;
        })*

        /// Names of all messages of this crate.
        pub const NAMES: &[&str] = &[$($name),*];
    };
}

ros_messages! {
    others::Time => "builtin_interfaces/msg/Time",
    others::Header => "std_msgs/msg/Header",
    others::Point => "geometry_msgs/msg/Point",
    others::Quaternion => "geometry_msgs/msg/Quaternion",
    others::Pose => "geometry_msgs/msg/Pose",
    others::PoseStamped => "geometry_msgs/msg/PoseStamped",
    others::Vector3 => "geometry_msgs/msg/Vector3",
    others::Transform => "geometry_msgs/msg/Transform",
    others::TransformStamped => "geometry_msgs/msg/TransformStamped",
    others::TFMessage => "tf2_msgs/msg/TFMessage",
    others::MapMetaData => "nav_msgs/msg/MapMetaData",
    others::OccupancyGrid => "nav_msgs/msg/OccupancyGrid",
    others::Path => "nav_msgs/msg/Path",
    others::GeoJson => "foxglove_msgs/msg/GeoJSON",
    others::Vector2 => "foxglove_msgs/msg/Vector2",
    others::PackedElementField => "foxglove_msgs/msg/PackedElementField",
    others::Grid => "foxglove_msgs/msg/Grid",
    signs::Duration => "builtin_interfaces/msg/Duration",
    signs::ColorRgba => "std_msgs/msg/ColorRGBA",
    signs::UvCoordinate => "visualization_msgs/msg/UVCoordinate",
    signs::MeshFile => "visualization_msgs/msg/MeshFile",
    signs::Marker => "visualization_msgs/msg/Marker",
    robots::PoseWithCovariance => "geometry_msgs/msg/PoseWithCovariance",
    robots::PoseWithCovarianceStamped => "geometry_msgs/msg/PoseWithCovarianceStamped",
    robots::Twist => "geometry_msgs/msg/Twist",
    robots::TwistWithCovariance => "geometry_msgs/msg/TwistWithCovariance",
    robots::Odometry => "nav_msgs/msg/Odometry",
    robots::NavSatStatus => "sensor_msgs/msg/NavSatStatus",
    robots::NavSatFix => "sensor_msgs/msg/NavSatFix",
    robots::Image => "sensor_msgs/msg/Image",
    robots::CompressedImage => "sensor_msgs/msg/CompressedImage",
    robots::RegionOfInterest => "sensor_msgs/msg/RegionOfInterest",
    robots::CameraInfo => "sensor_msgs/msg/CameraInfo",
    robots::Bool => "std_msgs/msg/Bool",
    robots::BatteryState => "sensor_msgs/msg/BatteryState",
    robots::Uuid => "unique_identifier_msgs/msg/UUID",
    robots::GoalInfo => "action_msgs/msg/GoalInfo",
    robots::GoalStatus => "action_msgs/msg/GoalStatus",
    robots::GoalStatusArray => "action_msgs/msg/GoalStatusArray",
    robots::KeyValue => "diagnostic_msgs/msg/KeyValue",
    robots::DiagnosticStatus => "diagnostic_msgs/msg/DiagnosticStatus",
    robots::DiagnosticArray => "diagnostic_msgs/msg/DiagnosticArray",
    vision::Point2D => "vision_msgs/msg/Point2D",
    vision::Pose2D => "vision_msgs/msg/Pose2D",
    vision::BoundingBox2D => "vision_msgs/msg/BoundingBox2D",
    vision::ObjectHypothesis => "vision_msgs/msg/ObjectHypothesis",
    vision::ObjectHypothesisWithPose => "vision_msgs/msg/ObjectHypothesisWithPose",
    vision::Detection2D => "vision_msgs/msg/Detection2D",
    vision::Detection2DArray => "vision_msgs/msg/Detection2DArray",
    vision::BoundingBox3D => "vision_msgs/msg/BoundingBox3D",
    vision::Detection3D => "vision_msgs/msg/Detection3D",
    vision::Detection3DArray => "vision_msgs/msg/Detection3DArray",
}

/// The definition of a message, of `known` or one of [`NAMES`], followed by those of all messages in it, in order of
/// first use.
#[must_use]
pub fn schema(name: &str, known: Definitions) -> String {
    let name = short(name);
    let own = definition(&name, known).to_owned();
    let parts =
        needed(&name, known).into_iter().map(|part| format!("MSG: {part}\n{}", definition(part, known)));
    let sections: Vec<String> = std::iter::once(own).chain(parts).collect();
    sections.join(&format!("\n{}\n", "=".repeat(SEPARATOR_WIDTH)))
}

/// The type hash of a message, of `known` or one of [`NAMES`], as [`RosMessage::type_hash`].
#[must_use]
pub fn type_hash(name: &str, known: Definitions) -> String {
    type_hash::type_hash(&short(name), known)
}

/// `nav_msgs/msg/Path` as written in definitions: `nav_msgs/Path`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// All messages within a message, in order of first use.
fn needed(name: &str, known: Definitions) -> Vec<&'static str> {
    let mut needed: Vec<&str> = Vec::new();
    let mut next = 0;
    let mut definition_next = definition(name, known);
    loop {
        for part in parts(definition_next) {
            if !needed.contains(&part) {
                needed.push(part);
            }
        }
        let Some(&part) = needed.get(next) else { return needed };
        definition_next = definition(part, known);
        next += 1;
    }
}

/// The text of one message without those in it.
fn definition(name: &str, known: Definitions) -> &'static str {
    let shared = standard::DEFINITIONS.iter().chain(&robot::DEFINITIONS).chain(&markers::DEFINITIONS);
    let mut all = known.iter().chain(shared);
    let found = all.find(|(known, _)| *known == name);
    debug_assert!(found.is_some(), "no definition of {name}");
    found.map_or("", |(_, text)| text)
}

/// Messages that a definition uses: types with a package.
fn parts(definition: &str) -> impl Iterator<Item = &str> {
    let lines = definition.lines().map(|line| line.split('#').next().unwrap_or_default());
    let types = lines.filter_map(|line| line.split_whitespace().next());
    types.filter(|name| name.contains('/')).filter_map(|name| name.split('[').next())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schema_holds_every_message_in_it_once() {
        for name in NAMES {
            let schema = schema(name, &[]);
            for part in parts(&schema) {
                assert_eq!(schema.matches(&format!("\nMSG: {part}\n")).count(), 1, "{name}: {part}");
            }
        }
    }

    /// Of `std_msgs/msg/Header`, as printed by `ros2 topic info --verbose`.
    #[test]
    fn a_type_hash_is_that_of_ros() {
        let hash = "RIHS01_f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01";
        assert_eq!(others::Header::type_hash(), hash);
    }

    #[test]
    fn a_schema_reads_as_mcap_wants_it() {
        let expected = format!(
            "builtin_interfaces/Time stamp\nstring frame_id\n\n{}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
            "=".repeat(80)
        );
        assert_eq!(others::Header::schema(), expected);
    }
}
