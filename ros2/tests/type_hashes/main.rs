//! The type hashes of all messages equal those of rosbags, which has ROS 2's definitions and computes hashes
//! independently.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

mod rosbags;

use dragnet_ros2::input::InputKind;
use dragnet_ros2::output::OutputKind;
use dragnet_ros2::schema::{MessageType, NAMES, type_hash};

#[test]
fn hashes_are_those_of_rosbags() {
    for (name, theirs) in rosbags::hashes(NAMES, &[]) {
        assert_eq!(theirs.hash, type_hash(&name, &[]), "{name}");
        let is_ros = !["foxglove_msgs/", "vision_msgs/"].iter().any(|own| name.starts_with(own));
        assert_eq!(theirs.is_known, is_ros, "{name}");
    }
}

/// Every message that is used on a robot's network is checked against rosbags.
#[test]
fn every_message_of_a_robots_network_is_among_them() {
    let outputs = [
        OutputKind::Goal,
        OutputKind::Path,
        OutputKind::Belief,
        OutputKind::Objects,
        OutputKind::Tracks,
        OutputKind::Diagnostics,
    ];
    let spoken = InputKind::ALL.map(InputKind::message).into_iter().chain(outputs.map(OutputKind::message));
    for MessageType { name, hash } in spoken {
        assert!(NAMES.contains(&name), "{name}");
        assert_eq!(hash, type_hash(name, &[]), "{name}");
    }
}
