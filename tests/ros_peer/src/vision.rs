//! `vision_msgs` 4, which hiroz does not have for Jazzy: it derives their hashes from these structs.

use hiroz::MessageTypeInfo;
use hiroz::msg::{SerdeCdrSerdes, ZMessage};
use hiroz_msgs::geometry_msgs::{Pose, PoseWithCovariance, Vector3};
use hiroz_msgs::std_msgs::Header;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Point2D")]
pub struct Point2D {
    pub x: f64,
    pub y: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Pose2D")]
pub struct Pose2D {
    pub position: Point2D,
    pub theta: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/BoundingBox2D")]
pub struct BoundingBox2D {
    pub center: Pose2D,
    pub size_x: f64,
    pub size_y: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/ObjectHypothesis")]
pub struct ObjectHypothesis {
    pub class_id: String,
    pub score: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/ObjectHypothesisWithPose")]
pub struct ObjectHypothesisWithPose {
    pub hypothesis: ObjectHypothesis,
    pub pose: PoseWithCovariance,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Detection2D")]
pub struct Detection2D {
    pub header: Header,
    pub results: Vec<ObjectHypothesisWithPose>,
    pub bbox: BoundingBox2D,
    pub id: String,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Detection2DArray")]
pub struct Detection2DArray {
    pub header: Header,
    pub detections: Vec<Detection2D>,
}

impl ZMessage for Detection2DArray {
    type Serdes = SerdeCdrSerdes<Self>;
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/BoundingBox3D")]
pub struct BoundingBox3D {
    pub center: Pose,
    pub size: Vector3,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Detection3D")]
pub struct Detection3D {
    pub header: Header,
    pub results: Vec<ObjectHypothesisWithPose>,
    pub bbox: BoundingBox3D,
    pub id: String,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize, MessageTypeInfo)]
#[ros_msg(type_name = "vision_msgs/msg/Detection3DArray")]
pub struct Detection3DArray {
    pub header: Header,
    pub detections: Vec<Detection3D>,
}

impl ZMessage for Detection3DArray {
    type Serdes = SerdeCdrSerdes<Self>;
}
