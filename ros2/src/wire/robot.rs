//! Messages on a robot's own ROS 2 network: sensors, navigation, and outputs. Lengths are meters and angles radians
//! unless a field says otherwise.

use serde::{Deserialize, Serialize};

use super::bytes;
use super::standard::{Header, Pose, Time, Vector3};

/// Row-major covariance of `x`, `y`, `z` and the rotations about them: on the wire the same as ROS's flat `float64[36]`.
pub type Covariance = [[f64; 6]; 6];

/// `geometry_msgs/msg/PoseWithCovariance`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Its covariance, in fixed axes.
    pub covariance: Covariance,
}

/// `geometry_msgs/msg/PoseWithCovarianceStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    /// When, and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: PoseWithCovariance,
}

/// `geometry_msgs/msg/Twist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Meters per second.
    pub linear: Vector3,
    /// Radians per second.
    pub angular: Vector3,
}

/// `geometry_msgs/msg/TwistWithCovariance`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The velocity.
    pub twist: Twist,
    /// Its covariance.
    pub covariance: Covariance,
}

/// `nav_msgs/msg/Odometry`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// When, and the frame of the pose.
    pub header: Header,
    /// The frame of the velocity: the robot's own.
    pub child_frame_id: String,
    /// The robot's pose.
    pub pose: PoseWithCovariance,
    /// The robot's velocity, forward, to its left and up.
    pub twist: TwistWithCovariance,
}

/// `sensor_msgs/msg/NavSatStatus`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NavSatStatus {
    /// Below 0 there is no fix.
    pub status: i8,
    /// Bits of the constellations.
    pub service: u16,
}

/// `sensor_msgs/msg/NavSatFix`: a position in WGS84.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NavSatFix {
    /// When, and the frame of the antenna.
    pub header: Header,
    /// Whether there is a fix.
    pub status: NavSatStatus,
    /// Degrees, north positive.
    pub latitude: f64,
    /// Degrees, east positive.
    pub longitude: f64,
    /// Above the ellipsoid; NaN if unknown.
    pub altitude: f64,
    /// Covariance of east, north and up, square meters.
    pub position_covariance: [[f64; 3]; 3],
    /// 0 if the covariance is unknown.
    pub position_covariance_type: u8,
}

/// `sensor_msgs/msg/Image`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// When, and the frame of the camera.
    pub header: Header,
    /// Rows.
    pub height: u32,
    /// Columns.
    pub width: u32,
    /// The pixel format, such as `rgb8`.
    pub encoding: String,
    /// 1 if numbers of several bytes begin with the highest one.
    pub is_bigendian: u8,
    /// Bytes from a row to the next.
    pub step: u32,
    /// Row by row from the top, shape `[height * step]`.
    #[serde(with = "bytes")]
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When, and the frame of the camera.
    pub header: Header,
    /// Such as `jpeg`, or `bgr8; jpeg compressed bgr8`.
    pub format: String,
    /// The bytes of the image file.
    #[serde(with = "bytes")]
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/RegionOfInterest`: a part of a camera's full image, pixels of that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegionOfInterest {
    /// Columns left of it.
    pub x_offset: u32,
    /// Rows above it.
    pub y_offset: u32,
    /// Rows; 0 for the full image.
    pub height: u32,
    /// Columns; 0 for the full image.
    pub width: u32,
    /// Whether the rectified image has the part.
    pub do_rectify: bool,
}

/// `sensor_msgs/msg/CameraInfo`: the calibration of a camera. Pixels count from the center of the upper left one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraInfo {
    /// When, and the optical frame: x to the right, y down, z out of the camera.
    pub header: Header,
    /// Rows of the full image.
    pub height: u32,
    /// Columns of the full image.
    pub width: u32,
    /// The model of distortion, such as `plumb_bob`.
    pub distortion_model: String,
    /// Its coefficients.
    pub d: Vec<f64>,
    /// Pixels from directions: `[fx, 0, cx], [0, fy, cy], [0, 0, 1]`. All 0 if the camera is not calibrated.
    pub k: [[f64; 3]; 3],
    /// Rotation to the rectified camera.
    pub r: [[f64; 3]; 3],
    /// Pixels of the rectified image from directions.
    pub p: [[f64; 4]; 3],
    /// Columns that are combined to one; 0 means 1.
    pub binning_x: u32,
    /// Rows that are combined to one; 0 means 1.
    pub binning_y: u32,
    /// The part of the full image.
    pub roi: RegionOfInterest,
}

/// `std_msgs/msg/Bool`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bool {
    /// The value.
    pub data: bool,
}

/// `sensor_msgs/msg/BatteryState`; NaN where a number is not measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BatteryState {
    /// When.
    pub header: Header,
    /// Volts.
    pub voltage: f32,
    /// Degrees Celsius.
    pub temperature: f32,
    /// Amperes, negative when discharging.
    pub current: f32,
    /// Ampere hours.
    pub charge: f32,
    /// Ampere hours, the last full charge.
    pub capacity: f32,
    /// Ampere hours, as designed.
    pub design_capacity: f32,
    /// Charge, `0..=1`.
    pub percentage: f32,
    /// 1 charging, 2 discharging, 3 not charging, 4 full.
    pub power_supply_status: u8,
    /// 1 good; others are faults.
    pub power_supply_health: u8,
    /// The chemistry.
    pub power_supply_technology: u8,
    /// Whether there is a battery.
    pub present: bool,
    /// Volts, of each cell.
    pub cell_voltage: Vec<f32>,
    /// Degrees Celsius, of each cell.
    pub cell_temperature: Vec<f32>,
    /// The slot.
    pub location: String,
    /// The serial number.
    pub serial_number: String,
}

/// `unique_identifier_msgs/msg/UUID`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Uuid {
    /// Its bytes.
    pub uuid: [u8; 16],
}

/// `action_msgs/msg/GoalInfo`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalInfo {
    /// The goal.
    pub goal_id: Uuid,
    /// When it was accepted.
    pub stamp: Time,
}

/// `action_msgs/msg/GoalStatus`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalStatus {
    /// The goal.
    pub goal_info: GoalInfo,
    /// 1 accepted, 2 executing, 3 canceling, 4 succeeded, 5 canceled, 6 aborted.
    pub status: i8,
}

/// `action_msgs/msg/GoalStatusArray`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalStatusArray {
    /// Active goals, and those that ended recently.
    pub status_list: Vec<GoalStatus>,
}

/// `diagnostic_msgs/msg/KeyValue`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// The name.
    pub key: String,
    /// The value.
    pub value: String,
}

/// `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// 0 OK, 1 a warning, 2 an error, 3 stale.
    pub level: u8,
    /// The part.
    pub name: String,
    /// A short description.
    pub message: String,
    /// The device.
    pub hardware_id: String,
    /// Further values.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/msg/DiagnosticArray`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// One for each part.
    pub status: Vec<DiagnosticStatus>,
}
