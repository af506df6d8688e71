//! Dragnet's own messages can be read by their schemas alone.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

#[path = "../../ros2/tests/schemas/reader.rs"]
mod reader;

use dragnet_proto::dragnet_msgs as ours;
use reader::check;

#[test]
fn every_message_of_dragnet_matches_its_schema() {
    check::<ours::Observation>();
    check::<ours::ObjectPosition>();
    check::<ours::Intent>();
    check::<ours::Heartbeat>();
    check::<ours::SyncRequest>();
    check::<ours::SyncReply>();
    check::<ours::Detection>();
    check::<ours::MissionStatus>();
    check::<ours::Verdicts>();
    check::<ours::Orders>();
    check::<ours::Zones>();
    check::<ours::Mark>();
    check::<ours::Marks>();
    check::<ours::Step>();
    check::<ours::StepReply>();
    check::<ours::Sensed>();
}
