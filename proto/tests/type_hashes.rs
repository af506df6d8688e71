//! The type hashes of Dragnet's own messages equal those of rosbags, which computes them independently.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

#[path = "../../ros2/tests/type_hashes/rosbags.rs"]
mod rosbags;

use dragnet_proto::dragnet_msgs::{DEFINITIONS, NAMES};
use dragnet_ros2::schema::type_hash;

#[test]
fn hashes_are_those_of_rosbags() {
    for (name, theirs) in rosbags::hashes(NAMES, DEFINITIONS) {
        assert_eq!(theirs.hash, type_hash(&name, DEFINITIONS), "{name}");
        assert!(!theirs.is_known, "{name}");
    }
}
