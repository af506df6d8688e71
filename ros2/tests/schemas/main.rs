//! A schema alone is sufficient to read a message: an independent reader, driven by the text of the schema, finds every
//! field by its name, type and position, and nothing else.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

mod reader;

use dragnet_ros2::wire::{robot, standard as others, vision};
use reader::check;

#[test]
fn every_message_matches_its_schema() {
    check::<others::Time>();
    check::<others::Header>();
    check::<others::Point>();
    check::<others::Quaternion>();
    check::<others::Pose>();
    check::<others::PoseStamped>();
    check::<others::Vector3>();
    check::<others::Transform>();
    check::<others::TransformStamped>();
    check::<others::TFMessage>();
    check::<others::MapMetaData>();
    check::<others::OccupancyGrid>();
    check::<others::Path>();
    check::<others::Vector2>();
    check::<others::PackedElementField>();
    check::<others::Grid>();
}

#[test]
fn every_message_of_a_robots_own_network_matches_its_schema() {
    check::<robot::PoseWithCovariance>();
    check::<robot::PoseWithCovarianceStamped>();
    check::<robot::Twist>();
    check::<robot::TwistWithCovariance>();
    check::<robot::Odometry>();
    check::<robot::NavSatStatus>();
    check::<robot::NavSatFix>();
    check::<robot::Image>();
    check::<robot::CompressedImage>();
    check::<robot::Uuid>();
    check::<robot::GoalInfo>();
    check::<robot::GoalStatus>();
    check::<robot::GoalStatusArray>();
    check::<robot::KeyValue>();
    check::<robot::DiagnosticStatus>();
    check::<robot::DiagnosticArray>();
    check::<vision::Point2D>();
    check::<vision::Pose2D>();
    check::<vision::BoundingBox2D>();
    check::<vision::ObjectHypothesis>();
    check::<vision::ObjectHypothesisWithPose>();
    check::<vision::Detection2D>();
    check::<vision::Detection2DArray>();
    check::<vision::BoundingBox3D>();
    check::<vision::Detection3D>();
    check::<vision::Detection3DArray>();
}
