//! Keys of `zenoh-bridge-ros2dds`: a topic's name alone, without type, token or attachment.
//!
//! The bridge puts its own `namespace` before all names; it is that of [`super::name::TopicName`] here.

use super::name::TopicName;

/// The key of a topic: `robot1/odom` for `/robot1/odom`.
#[must_use]
pub fn data_key(topic: &TopicName) -> String {
    topic.chunks().to_owned()
}
