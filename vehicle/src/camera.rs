//! A camera on the vehicle: the bearing of each image column, and the field of view.
//!
//! A pinhole: the bearing of a column `u` is `atan((u - width / 2) / f)` to the right of the middle, with the focal
//! length `f = (width / 2) / tan(field_of_view / 2)` in pixels. Lens distortion must be removed before, and heights are
//! not used: a camera measures bearings only. A camera that is measured, with its distortion and tilt, is a
//! [`MountedCamera`].

mod attitude;
mod boxes;
mod lens;
mod mounted;
mod view;

pub use attitude::Attitude;
pub use boxes::{BoxRefusal, DetectionBox, Detections, TooManyBoxes};
pub use lens::{Distortion, Lens};
pub use mounted::{CameraRanges, MountedCamera, MountedError};
pub use view::{View, ViewError};

use std::f64::consts::{FRAC_PI_2, PI};

use dragnet_lattice::plane::{Pose, wrapped_radians};

/// The settings of a camera, before they are checked.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSettings {
    /// Its name; not empty.
    pub name: String,
    /// Columns of the image that detections are given in, at least 1.
    pub width_pixels: u32,
    /// Rows of that image, at least 1.
    pub height_pixels: u32,
    /// Angle between its left and its right edge, radians, above 0 and below pi.
    pub field_of_view_radians: f64,
    /// Its position in the vehicle's frame (x forward, y left), and its yaw, counter-clockwise from forward.
    pub mounting: Pose,
    /// Its height above the ground, meters, at least 0; 0 if unknown.
    pub z_meters: f64,
    /// Its angle below the horizon, radians, within a right angle.
    pub pitch_radians: f64,
    /// Shortest range of a detection, meters, above 0.
    pub min_range_meters: f64,
    /// Longest range of a detection, meters, above `min_range_meters`.
    pub max_range_meters: f64,
}

/// A valid camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    settings: CameraSettings,
    focal_length_pixels: f64,
}

/// Why a camera is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The name is empty.
    #[error("a camera has no name")]
    NoName,
    /// Neither its table nor the vehicle's network says it.
    #[error(
        "camera {name}: {key} is missing, which only a camera of a network with its `camera_info` can be without"
    )]
    Missing {
        /// Name of the camera.
        name: String,
        /// The key.
        key: &'static str,
    },
    /// The image has no pixels.
    #[error("camera {name}: an image of {width} x {height} pixels holds nothing")]
    NoPixels {
        /// Name of the camera.
        name: String,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// An impossible field of view.
    #[error(
        "camera {name}: a field of view of {radians} radians: allowed is above 0 and below pi (180 degrees)"
    )]
    FieldOfView {
        /// Name of the camera.
        name: String,
        /// The given value.
        radians: f64,
    },
    /// An invalid mounting.
    #[error("camera {name}: its mounting is not a number: {mounting:?}")]
    Mounting {
        /// Name of the camera.
        name: String,
        /// The given value.
        mounting: Pose,
    },
    /// An invalid height or pitch.
    #[error(
        "camera {name}: z_meters = {z_meters}, looking {pitch_radians} radians down: allowed are 0 to 1000 m, and \
         less than a right angle up or down"
    )]
    Height {
        /// Name of the camera.
        name: String,
        /// The given value.
        z_meters: f64,
        /// The given value.
        pitch_radians: f64,
    },
    /// Invalid ranges.
    #[error("camera {name}: it sees from {nearest} m to {farthest} m: needed is 0 < nearest < farthest")]
    Ranges {
        /// Name of the camera.
        name: String,
        /// The given value, meters.
        nearest: f64,
        /// The given value, meters.
        farthest: f64,
    },
}

impl Camera {
    /// A camera with these settings.
    ///
    /// # Errors
    /// If one of them is out of its range.
    pub fn new(settings: CameraSettings) -> Result<Self, CameraError> {
        let name = || settings.name.clone();
        if settings.name.is_empty() {
            return Err(CameraError::NoName);
        }
        let (width, height) = (settings.width_pixels, settings.height_pixels);
        if width == 0 || height == 0 {
            return Err(CameraError::NoPixels { name: name(), width, height });
        }
        let radians = settings.field_of_view_radians;
        let focal_length_pixels = f64::from(width) / 2.0 / (radians / 2.0).tan();
        // Written so that NaN fails as well.
        if !(radians > 0.0 && radians < PI && focal_length_pixels.is_finite()) {
            return Err(CameraError::FieldOfView { name: name(), radians });
        }
        if !settings.mounting.is_finite() {
            return Err(CameraError::Mounting { name: name(), mounting: settings.mounting });
        }
        let CameraSettings { z_meters, pitch_radians, .. } = settings;
        if !((0.0..=1000.0).contains(&z_meters) && pitch_radians.abs() < FRAC_PI_2) {
            return Err(CameraError::Height { name: name(), z_meters, pitch_radians });
        }
        let (nearest, farthest) = (settings.min_range_meters, settings.max_range_meters);
        if !view::are_ranges(nearest, farthest) {
            return Err(CameraError::Ranges { name: name(), nearest, farthest });
        }
        Ok(Self { settings, focal_length_pixels })
    }

    /// Its settings.
    #[must_use]
    pub const fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// Distance of the image from the pinhole, pixels.
    #[must_use]
    pub const fn focal_length_pixels(&self) -> f64 {
        self.focal_length_pixels
    }

    /// The bearing of a column: radians in the vehicle's frame, from the camera's position. Columns go from 0 at the
    /// left edge of the first pixel to the width at the right edge of the last.
    #[must_use]
    pub fn bearing_radians(&self, column_pixels: f64) -> f64 {
        let right_pixels = column_pixels - f64::from(self.settings.width_pixels) / 2.0;
        let right_radians = right_pixels.atan2(self.focal_length_pixels);
        wrapped_radians(self.settings.mounting.heading_radians - right_radians)
    }

    /// The column of a bearing in radians in the vehicle's frame, if it is in view: `0.0..=width`.
    #[must_use]
    pub fn column_pixels(&self, bearing_radians: f64) -> Option<f64> {
        let right_radians = wrapped_radians(self.settings.mounting.heading_radians - bearing_radians);
        // Behind a camera the tangent repeats.
        let in_view = right_radians.abs() <= self.settings.field_of_view_radians / 2.0;
        let middle_pixels = f64::from(self.settings.width_pixels) / 2.0;
        in_view.then(|| middle_pixels + self.focal_length_pixels * right_radians.tan())
    }

    /// Whether an object is in view: its bearing in radians in the vehicle's frame and its range in meters, both from
    /// the camera's position.
    #[must_use]
    pub fn sees(&self, bearing_radians: f64, range_meters: f64) -> bool {
        let ranges = self.settings.min_range_meters..=self.settings.max_range_meters;
        ranges.contains(&range_meters) && self.column_pixels(bearing_radians).is_some()
    }

    /// Standard deviation of a bearing, radians, from that of a column in pixels: in the middle of the image, where a
    /// pixel is widest.
    #[must_use]
    pub fn bearing_deviation_radians(&self, column_std_pixels: f64) -> f64 {
        column_std_pixels.atan2(self.focal_length_pixels)
    }

    /// The camera's view of the map from a vehicle at this pose.
    ///
    /// # Errors
    /// If the vehicle's pose is not finite.
    pub fn view(&self, vehicle: &Pose) -> Result<View, ViewError> {
        let settings = &self.settings;
        let half_radians = settings.field_of_view_radians / 2.0;
        View::new(
            vehicle.of_part(&settings.mounting),
            half_radians,
            settings.min_range_meters,
            settings.max_range_meters,
        )
        .map(|view| view.with_ground_from(self.ground_meters()))
    }

    /// Range from which on the ground is in the middle column of its image, meters: `h / tan(pitch + v / 2)` with the
    /// vertical field of view `v`. Nearer ground is below the image. Infinite if the camera faces above the horizon.
    #[must_use]
    pub fn ground_meters(&self) -> f64 {
        let half_rows = f64::from(self.settings.height_pixels) / 2.0;
        let down_radians = self.settings.pitch_radians + half_rows.atan2(self.focal_length_pixels);
        match self.settings.z_meters {
            z_meters if z_meters <= 0.0 => 0.0,
            _ if down_radians <= 0.0 => f64::INFINITY,
            _ if down_radians >= FRAC_PI_2 => 0.0,
            z_meters => z_meters / down_radians.tan(),
        }
    }
}

#[cfg(test)]
mod tests;
