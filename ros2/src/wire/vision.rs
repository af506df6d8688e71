//! `vision_msgs` 4, of ROS 2 Humble and later: what a detector sees in an image, and objects in space.

use serde::{Deserialize, Serialize};

use super::robot::PoseWithCovariance;
use super::standard::{Header, Pose, Vector3};

/// `vision_msgs/msg/Point2D`, pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point2D {
    /// To the right of the left edge.
    pub x: f64,
    /// Below the upper edge.
    pub y: f64,
}

/// `vision_msgs/msg/Pose2D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose2D {
    /// Where.
    pub position: Point2D,
    /// Turned so far, radians.
    pub theta: f64,
}

/// `vision_msgs/msg/BoundingBox2D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundingBox2D {
    /// Its middle.
    pub center: Pose2D,
    /// Its width before it is turned, pixels.
    pub size_x: f64,
    /// Its height before it is turned, pixels.
    pub size_y: f64,
}

/// `vision_msgs/msg/ObjectHypothesis`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectHypothesis {
    /// What it may be.
    pub class_id: String,
    /// How sure the detector is, `0..=1` by convention.
    pub score: f64,
}

/// `vision_msgs/msg/ObjectHypothesisWithPose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectHypothesisWithPose {
    /// What it may be.
    pub hypothesis: ObjectHypothesis,
    /// Where it would be then.
    pub pose: PoseWithCovariance,
}

/// `vision_msgs/msg/Detection2D`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection2D {
    /// When, and the frame of the camera.
    pub header: Header,
    /// What it may be.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// Where in the image.
    pub bbox: BoundingBox2D,
    /// The same in each image, if the detector follows it.
    pub id: String,
}

/// `vision_msgs/msg/Detection2DArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection2DArray {
    /// When, and the frame of the camera.
    pub header: Header,
    /// All that is seen in one image.
    pub detections: Vec<Detection2D>,
}

/// `vision_msgs/msg/BoundingBox3D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundingBox3D {
    /// Its middle.
    pub center: Pose,
    /// Its edges.
    pub size: Vector3,
}

/// `vision_msgs/msg/Detection3D`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection3D {
    /// When, and in which frame.
    pub header: Header,
    /// What it may be.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// Where.
    pub bbox: BoundingBox3D,
    /// The same in each message.
    pub id: String,
}

/// `vision_msgs/msg/Detection3DArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection3DArray {
    /// When, and in which frame.
    pub header: Header,
    /// All objects.
    pub detections: Vec<Detection3D>,
}
