//! A camera's view of the map: a sector of a ring.

use std::f64::consts::PI;

use nalgebra::Vector2;

use dragnet_lattice::plane::{Pose, bearing_radians, wrapped_radians};

/// A sector of a ring on the map, around a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    camera: Pose,
    half_radians: f64,
    min_range_meters: f64,
    max_range_meters: f64,
    /// The ground is in view from here on, meters.
    ground_meters: f64,
}

/// Why a view is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ViewError {
    /// The camera's pose is not finite.
    #[error("the camera's pose is not a number: {0:?}")]
    Pose(Pose),
    /// Invalid angle.
    #[error("half a field of view of {0} radians: allowed is above 0, up to pi")]
    Angle(f64),
    /// Invalid ranges.
    #[error("a view from {nearest} m to {farthest} m: needed is 0 < nearest < farthest")]
    Ranges {
        /// The given value, meters.
        nearest: f64,
        /// The given value, meters.
        farthest: f64,
    },
}

/// Whether ranges are valid, meters.
pub(super) fn are_ranges(min_range_meters: f64, max_range_meters: f64) -> bool {
    min_range_meters > 0.0 && min_range_meters < max_range_meters && max_range_meters.is_finite()
}

impl View {
    /// The view of a camera at a pose on the map, symmetric to its heading.
    ///
    /// # Errors
    /// If the pose is not finite, the angle is not above 0 and at most pi, or the ranges are not
    /// `0 < nearest < farthest`.
    pub fn new(
        camera: Pose,
        half_radians: f64,
        min_range_meters: f64,
        max_range_meters: f64,
    ) -> Result<Self, ViewError> {
        if !camera.is_finite() {
            return Err(ViewError::Pose(camera));
        }
        // Written so that NaN fails as well.
        if !(half_radians > 0.0 && half_radians <= PI) {
            return Err(ViewError::Angle(half_radians));
        }
        if !are_ranges(min_range_meters, max_range_meters) {
            return Err(ViewError::Ranges { nearest: min_range_meters, farthest: max_range_meters });
        }
        Ok(Self { camera, half_radians, min_range_meters, max_range_meters, ground_meters: 0.0 })
    }

    /// The view of a camera that sees the ground from this range on, meters.
    #[must_use]
    pub const fn with_ground_from(self, ground_meters: f64) -> Self {
        Self { ground_meters, ..self }
    }

    /// The pose of the camera on the map.
    #[must_use]
    pub const fn camera(&self) -> Pose {
        self.camera
    }

    /// The angle between its edges, radians.
    #[must_use]
    pub const fn width_radians(&self) -> f64 {
        2.0 * self.half_radians
    }

    /// Shortest range of a detection, meters.
    #[must_use]
    pub const fn min_range_meters(&self) -> f64 {
        self.min_range_meters
    }

    /// Longest range of a detection, meters.
    #[must_use]
    pub const fn max_range_meters(&self) -> f64 {
        self.max_range_meters
    }

    /// The angle of a direction, radians counter-clockwise from east, beyond the nearer edge, radians; not above 0 in
    /// view.
    #[must_use]
    pub fn radians_beyond(&self, bearing_radians: f64) -> f64 {
        wrapped_radians(bearing_radians - self.camera.heading_radians).abs() - self.half_radians
    }

    /// The same, widened by an angle on both sides and by a factor in its ranges; narrowed for an angle below 0 and a
    /// factor below 1.
    #[must_use]
    pub(crate) fn widened(self, beyond_radians: f64, times: f64) -> Self {
        Self {
            half_radians: (self.half_radians + beyond_radians).clamp(0.0, PI),
            min_range_meters: self.min_range_meters / times,
            max_range_meters: self.max_range_meters * times,
            ..self
        }
    }

    /// Whether an object on the ground at a point of the map would be in view.
    #[must_use]
    pub fn shows_ground(&self, point_meters: Vector2<f64>) -> bool {
        let range_meters = (point_meters - self.camera.position_meters()).norm();
        range_meters >= self.ground_meters && self.contains(point_meters)
    }

    /// Whether a point of the map is in view.
    #[must_use]
    pub fn contains(&self, point_meters: Vector2<f64>) -> bool {
        let range_meters = (point_meters - self.camera.position_meters()).norm();
        (self.min_range_meters..=self.max_range_meters).contains(&range_meters)
            && self.radians_beyond(bearing_radians(self.camera.position_meters(), point_meters)) <= 0.0
    }
}
