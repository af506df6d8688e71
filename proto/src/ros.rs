//! A robot's own ROS 2 network over plain Zenoh, without ROS installed: its names and keys, and what is said under them.
//!
//! - [`name`]: names of topics, nodes and namespaces, as ROS has them;
//! - [`qos`], [`rmw_zenoh`], [`bridge`]: under which key each topic travels by either way in, and what goes with it;
//! - [`input`]: what a robot's sensors and its navigation say, checked, in metres and radians;
//! - [`output`]: what Dragnet says to them;
//! - [`errand`]: what has become of a waypoint that was handed to Nav2.

pub mod bridge;
pub mod errand;
pub mod input;
pub mod name;
pub mod output;
pub mod qos;
pub mod rmw_zenoh;

use crate::schema::RosMessage;

/// A message as both sides name it.
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

    /// As DDS mangles it, `nav_msgs::msg::dds_::Odometry_`.
    #[must_use]
    pub fn dds_name(&self) -> String {
        match self.name.rsplit_once('/') {
            Some((package, name)) => format!("{}::dds_::{name}_", package.replace('/', "::")),
            None => self.name.to_owned(),
        }
    }
}
