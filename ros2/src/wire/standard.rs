//! Messages of other packages that Dragnet sends or records, as defined by ROS 2 and Foxglove. Lengths are meters.

use serde::{Deserialize, Serialize};

use super::bytes;

const NANOSECONDS: i128 = 1_000_000_000;

/// `builtin_interfaces/msg/Time`: Unix time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds; negative is before 1970.
    pub sec: i32,
    /// Nanoseconds to add, `0..1_000_000_000`.
    pub nanosec: u32,
}

impl Time {
    /// A Unix time in nanoseconds. Clamped to the years 1901 to 2038, the range of the message.
    #[must_use]
    pub fn at_unix_ns(unix_ns: i128) -> Self {
        let seconds = unix_ns.div_euclid(NANOSECONDS);
        let past = if seconds < 0 { i32::MIN } else { i32::MAX };
        Self {
            sec: i32::try_from(seconds).unwrap_or(past),
            nanosec: u32::try_from(unix_ns.rem_euclid(NANOSECONDS)).unwrap_or(0),
        }
    }
}

/// `std_msgs/msg/Header`: when, and in which frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When.
    pub stamp: Time,
    /// Name of the frame.
    pub frame_id: String,
}

/// `geometry_msgs/msg/Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Up.
    pub z: f64,
}

/// `geometry_msgs/msg/Vector3`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Up.
    pub z: f64,
}

/// `geometry_msgs/msg/Quaternion`, of length 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// `i`.
    pub x: f64,
    /// `j`.
    pub y: f64,
    /// `k`.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl Default for Quaternion {
    /// No rotation.
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/msg/Pose`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// The position.
    pub position: Point,
    /// The orientation.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When, and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// `geometry_msgs/msg/Transform`: parent from child.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Origin of the child in the parent.
    pub translation: Vector3,
    /// Rotation of the child in the parent.
    pub rotation: Quaternion,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// Parent from child.
    pub transform: Transform,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// Any number of them.
    pub transforms: Vec<TransformStamped>,
}

/// `nav_msgs/msg/MapMetaData`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapMetaData {
    /// When the map was loaded.
    pub map_load_time: Time,
    /// Edge of a cell.
    pub resolution: f32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The lower left corner of cell 0.
    pub origin: Pose,
}

/// `nav_msgs/msg/OccupancyGrid`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    /// When, and in which frame.
    pub header: Header,
    /// Size and place of the grid.
    pub info: MapMetaData,
    /// `0..=100`, or -1 for unknown; row-major from the origin, shape `[height * width]`.
    #[serde(with = "bytes::signed")]
    pub data: Vec<i8>,
}

/// `nav_msgs/msg/Path`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// When, and in which frame.
    pub header: Header,
    /// In the order of travel.
    pub poses: Vec<PoseStamped>,
}

/// `foxglove_msgs/msg/GeoJSON`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GeoJson {
    /// Text of a collection of features.
    pub geojson: String,
}

/// `foxglove_msgs/msg/Vector2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector2 {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
}

/// `foxglove_msgs/msg/PackedElementField`: one number within each cell of a [`Grid`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedElementField {
    /// The name in a viewer.
    pub name: String,
    /// Bytes from the start of the cell.
    pub offset: u32,
    /// Type of the number, such as [`PackedElementField::FLOAT32`].
    pub r#type: u8,
}

impl PackedElementField {
    /// A little-endian `f32`.
    pub const FLOAT32: u8 = 7;
}

/// `foxglove_msgs/msg/Grid`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// When.
    pub timestamp: Time,
    /// In which frame.
    pub frame_id: String,
    /// The lower left corner of the first cell.
    pub pose: Pose,
    /// Cells in a row.
    pub column_count: u32,
    /// Edges of a cell.
    pub cell_size: Vector2,
    /// Bytes from a row to the next.
    pub row_stride: u32,
    /// Bytes from a cell to the next.
    pub cell_stride: u32,
    /// The fields of each cell.
    pub fields: Vec<PackedElementField>,
    /// The cells, row-major, shape `[rows * row_stride]`.
    #[serde(with = "bytes")]
    pub data: Vec<u8>,
}
