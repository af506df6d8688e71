//! Markers that viewers draw, as defined by ROS 2.

use serde::{Deserialize, Serialize};

use super::bytes;
use super::robot::CompressedImage;
use super::standard::{Header, Point, Pose, Vector3};

/// `builtin_interfaces/msg/Duration`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    /// Whole seconds.
    pub sec: i32,
    /// Nanoseconds to add, `0..1_000_000_000`.
    pub nanosec: u32,
}

/// `std_msgs/msg/ColorRGBA`, each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRgba {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

/// `visualization_msgs/msg/UVCoordinate`, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    /// From the left of a texture.
    pub u: f32,
    /// From its top.
    pub v: f32,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name.
    pub filename: String,
    /// Its bytes.
    #[serde(with = "bytes")]
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/Marker`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When, and in which frame.
    pub header: Header,
    /// Name of a group of markers.
    pub ns: String,
    /// Its number in the group.
    pub id: i32,
    /// The shape, such as [`Marker::SPHERE_LIST`].
    pub r#type: i32,
    /// What is done, such as [`Marker::ADD`].
    pub action: i32,
    /// Where.
    pub pose: Pose,
    /// Size.
    pub scale: Vector3,
    /// Color.
    pub color: ColorRgba,
    /// How long it stays; zero for ever.
    pub lifetime: Duration,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// Of shapes that have them.
    pub points: Vec<Point>,
    /// Of points.
    pub colors: Vec<ColorRgba>,
    /// Of meshes.
    pub texture_resource: String,
    /// Of meshes.
    pub texture: CompressedImage,
    /// Of meshes.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// Of texts.
    pub text: String,
    /// Of meshes.
    pub mesh_resource: String,
    /// Of meshes.
    pub mesh_file: MeshFile,
    /// Of meshes.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A ball at each of its points.
    pub const SPHERE_LIST: i32 = 7;
    /// It is added, or changed.
    pub const ADD: i32 = 0;
    /// It is removed.
    pub const DELETE: i32 = 2;
}
