//! `vision_msgs` 4, of ROS 2 Humble and later: detections in an image, and objects in space.

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
    /// The position.
    pub position: Point2D,
    /// The rotation, radians.
    pub theta: f64,
}

/// `vision_msgs/msg/BoundingBox2D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundingBox2D {
    /// Its center.
    pub center: Pose2D,
    /// Its width before rotation, pixels.
    pub size_x: f64,
    /// Its height before rotation, pixels.
    pub size_y: f64,
}

/// `vision_msgs/msg/ObjectHypothesis`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectHypothesis {
    /// The class.
    pub class_id: String,
    /// The detector's score, `0..=1` by convention.
    pub score: f64,
}

/// `vision_msgs/msg/ObjectHypothesisWithPose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectHypothesisWithPose {
    /// The class and its score.
    pub hypothesis: ObjectHypothesis,
    /// Its pose for that class.
    pub pose: PoseWithCovariance,
}

/// `vision_msgs/msg/Detection2D`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection2D {
    /// When, and the frame of the camera.
    pub header: Header,
    /// Hypotheses of its class.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// The box in the image.
    pub bbox: BoundingBox2D,
    /// Constant over images, if the detector tracks it.
    pub id: String,
}

/// `vision_msgs/msg/Detection2DArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection2DArray {
    /// When, and the frame of the camera.
    pub header: Header,
    /// All detections in one image.
    pub detections: Vec<Detection2D>,
}

/// `vision_msgs/msg/BoundingBox3D`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundingBox3D {
    /// Its center.
    pub center: Pose,
    /// Its edges.
    pub size: Vector3,
}

/// `vision_msgs/msg/Detection3D`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Detection3D {
    /// When, and in which frame.
    pub header: Header,
    /// Hypotheses of its class.
    pub results: Vec<ObjectHypothesisWithPose>,
    /// The bounding box.
    pub bbox: BoundingBox3D,
    /// Constant over messages.
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
