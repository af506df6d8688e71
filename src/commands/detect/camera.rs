//! A camera as a table of settings.

use std::path::Path;

use dragnet_vehicle::camera::{Camera, CameraError, CameraSettings};
use dragnet_vehicle::plane::Pose;
use serde::Deserialize;

use crate::commands::Failure;

const MOST_BYTES: u64 = 1 << 16;

/// A camera, but for the size of its images.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rig {
    name: String,
    /// Between the left and the right edge of its images.
    field_of_view_degrees: f64,
    /// Where it is on the vehicle, forward of its middle.
    #[serde(default)]
    x_meters: f64,
    /// And to the left.
    #[serde(default)]
    y_meters: f64,
    /// Where it looks, counter-clockwise from forward.
    #[serde(default)]
    heading_degrees: f64,
    nearest_meters: f64,
    farthest_meters: f64,
}

impl Rig {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let failed = |reason: String| Failure::Input(format!("--camera {}: {reason}", path.display()));
        let text = dragnet_files::read_at_most(path, MOST_BYTES)
            .map_err(|error| failed(format!("cannot read it: {error}")))?;
        let rig: Self = toml::from_slice(&text).map_err(|error| failed(error.to_string()))?;
        // Whatever is wrong is so for images of any size.
        rig.camera(1, 1).map_err(|error| failed(error.to_string()))?;
        Ok(rig)
    }

    /// The camera of images with so many columns and rows.
    pub(super) fn camera(&self, width_pixels: u32, height_pixels: u32) -> Result<Camera, CameraError> {
        Camera::new(CameraSettings {
            name: self.name.clone(),
            width_pixels,
            height_pixels,
            field_of_view_radians: self.field_of_view_degrees.to_radians(),
            mounting: Pose::new(self.x_meters, self.y_meters, self.heading_degrees.to_radians()),
            nearest_meters: self.nearest_meters,
            farthest_meters: self.farthest_meters,
            // Bearings need neither.
            z_meters: 0.0,
            pitch_radians: 0.0,
        })
    }
}
