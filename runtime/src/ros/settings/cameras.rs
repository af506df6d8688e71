//! Topics of cameras, and what the network says of the cameras themselves.

use dragnet_vehicle::settings::Measured;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A camera's topics, at least one.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Name of the camera, as in `[[vehicle.cameras]]`.
    #[schemars(extend("examples" = ["front"]))]
    pub name: String,
    /// `vision_msgs/Detection2DArray`: a detector's boxes in the camera's images.
    #[serde(default)]
    pub detections: String,
    /// `sensor_msgs/Image`: for the `[detector]`, or beside `detections` for pictures of finds.
    #[serde(default)]
    pub image: String,
    /// `sensor_msgs/CompressedImage`, JPEG or PNG, in its place.
    #[serde(default)]
    pub compressed_image: String,
    /// `sensor_msgs/CameraInfo` of the images that boxes refer to: the camera's calibration, in place of the size and the
    /// field of view in its table.
    #[serde(default)]
    pub camera_info: String,
    /// Source of the camera's pose on the vehicle; by default `tf` with a `camera_info`, else `settings`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounting: Option<Mounting>,
}

/// Source of a camera's pose on the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mounting {
    /// Its table in `[[vehicle.cameras]]`.
    Settings,
    /// The transform from `robot_frame` to its optical frame, which its messages name.
    Tf,
}

impl Camera {
    /// Source of its mounting.
    #[must_use]
    pub fn mounting(&self) -> Mounting {
        let usual = if self.camera_info.is_empty() { Mounting::Settings } else { Mounting::Tf };
        self.mounting.unwrap_or(usual)
    }

    /// What the network says of it, if anything.
    #[must_use]
    pub fn measured(&self) -> Option<Measured> {
        match (self.camera_info.is_empty(), self.mounting()) {
            (true, Mounting::Settings) => None,
            (true, Mounting::Tf) => Some(Measured::Mounting),
            (false, Mounting::Settings) => Some(Measured::Optics),
            (false, Mounting::Tf) => Some(Measured::OpticsAndMounting),
        }
    }
}
