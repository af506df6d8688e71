//! A camera whose lens and mounting are measured, rather than described by one angle each.
//!
//! Its boxes become bearings by their centers' directions, so that distortion, tilt and roll are removed. What is in
//! view is approximated by a [`Camera`], a pinhole that looks as far to both sides and as far down.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use dragnet_lattice::plane::{Pose, turn_radians, wrapped_radians};
use nalgebra::{Isometry3, UnitQuaternion, UnitVector3, Vector3};

use super::{BoxRefusal, Camera, CameraError, CameraSettings, DetectionBox, Detections, Lens, TooManyBoxes};

/// The widest view of a pinhole, radians: of a wider lens the rest is not used.
const MAX_VIEW_RADIANS: f64 = 3.0;
/// The smallest angle between a camera's axis and the vertical, radians.
const MIN_RADIANS: f64 = 0.1;

/// A camera with its lens, on the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct MountedCamera {
    lens: Lens,
    vehicle_from_camera: UnitQuaternion<f64>,
    /// What is in view.
    camera: Camera,
}

/// What is known of a camera beside its lens and mounting.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraRanges {
    /// Name of the camera.
    pub name: String,
    /// Shortest range of a detection, meters, above 0.
    pub min_range_meters: f64,
    /// Longest range of a detection, meters, above `min_range_meters`.
    pub max_range_meters: f64,
}

/// Why there is no such camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MountedError {
    /// The camera looks up or down.
    #[error(
        "it looks straight {0}: is its frame the optical one, x to the right, y down and z out of the camera?"
    )]
    Vertical(&'static str),
    /// The model of the lens has no direction for the middle of an edge of the image.
    #[error("the distortion of its lens ends within the image; calibrate it again")]
    Distortion,
    /// The lens sees nothing that the pinhole could.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

impl MountedCamera {
    /// A camera with this lens and this pose of its optical frame in the vehicle's frame.
    ///
    /// # Errors
    /// If it looks straight up or down, or its lens is no lens.
    pub fn new(
        ranges: CameraRanges,
        lens: Lens,
        vehicle_from_camera: &Isometry3<f64>,
    ) -> Result<Self, MountedError> {
        let rotation = vehicle_from_camera.rotation;
        let axis = rotation * Vector3::z();
        if axis.x.hypot(axis.y) < MIN_RADIANS.sin() {
            return Err(MountedError::Vertical(if axis.z > 0.0 { "up" } else { "down" }));
        }
        let edges = Edges::of(&lens, &rotation).ok_or(MountedError::Distortion)?;
        let (heading, pitch) = (axis.y.atan2(axis.x), down_radians(&UnitVector3::new_normalize(axis)));
        let view = (edges.left_radians - edges.right_radians).clamp(0.0, MAX_VIEW_RADIANS);
        let middle = heading + f64::midpoint(edges.left_radians, edges.right_radians);
        let place = vehicle_from_camera.translation.vector;
        let camera = Camera::new(CameraSettings {
            name: ranges.name,
            width_pixels: lens.width_pixels,
            height_pixels: rows(lens.width_pixels, view, edges.lower_down_radians - pitch),
            field_of_view_radians: view,
            mounting: Pose::new(place.x, place.y, wrapped_radians(middle)),
            // Below the reference point its height above the ground is unknown.
            z_meters: place.z.max(0.0),
            pitch_radians: pitch,
            min_range_meters: ranges.min_range_meters,
            max_range_meters: ranges.max_range_meters,
        })?;
        Ok(Self { lens, vehicle_from_camera: rotation, camera })
    }

    /// A pinhole that looks as far to both sides and as far down.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Its lens.
    #[must_use]
    pub const fn lens(&self) -> &Lens {
        &self.lens
    }

    /// The bearings of the centers of boxes. Those at the very edge of a wide or tilted image, beyond the sides of the
    /// view, are left out.
    ///
    /// # Errors
    /// If there are more than [`Camera::MAX_BOXES`]. Single invalid boxes are ignored and counted.
    pub fn detections(&self, boxes: &[DetectionBox]) -> Result<Detections, TooManyBoxes> {
        if boxes.len() > Camera::MAX_BOXES {
            return Err(TooManyBoxes(boxes.len()));
        }
        let size = [self.lens.width_pixels, self.lens.height_pixels];
        let mut detections = Detections::default();
        let mut known = BTreeSet::new();
        for (number, detection_box) in boxes.iter().enumerate() {
            match detection_box.center(size) {
                Err(refusal) => detections.refused.push((number, refusal)),
                Ok([column, row]) => {
                    let Some(bearing) = self.bearing_radians(column, row) else { continue };
                    if known.insert(bearing.to_bits()) {
                        detections.add(number, bearing);
                    } else {
                        detections.refused.push((number, BoxRefusal::SameColumn));
                    }
                }
            }
        }
        Ok(detections)
    }

    /// The bearing of a pixel within the view, radians counter-clockwise from the vehicle's heading.
    fn bearing_radians(&self, column: f64, row: f64) -> Option<f64> {
        let direction = self.vehicle_from_camera * self.lens.direction(column, row)?;
        let bearing = direction.y.atan2(direction.x);
        let settings = self.camera.settings();
        let aside = turn_radians(settings.mounting.heading_radians, bearing).abs();
        let has_bearing = down_radians(&direction).abs() < FRAC_PI_2 - MIN_RADIANS;
        (has_bearing && aside <= settings.field_of_view_radians / 2.0).then_some(bearing)
    }
}

/// How far a camera sees from its axis.
#[expect(clippy::struct_field_names, reason = "each ends with its unit")]
struct Edges {
    /// Counter-clockwise, of the leftmost edge.
    left_radians: f64,
    /// The same of the rightmost edge, usually below 0.
    right_radians: f64,
    /// Below the horizon, of the lowest edge.
    lower_down_radians: f64,
}

impl Edges {
    /// By the middles of the image's edges. A camera on its side has its columns above each other.
    fn of(lens: &Lens, rotation: &UnitQuaternion<f64>) -> Option<Self> {
        let [width, height] = [lens.width_pixels, lens.height_pixels].map(f64::from);
        let columns = [lens.direction(0.0, height / 2.0)?, lens.direction(width, height / 2.0)?];
        let rows = [lens.direction(width / 2.0, 0.0)?, lens.direction(width / 2.0, height)?];
        let is_upright = (rotation * Vector3::x()).z.abs() <= (rotation * Vector3::y()).z.abs();
        let (sides, ends) = if is_upright { (columns, rows) } else { (rows, columns) };
        // Within the plane of the axis and the image's horizontal, as the view of a level camera.
        let is_left_first = (rotation * if is_upright { Vector3::x() } else { Vector3::y() })
            .cross(&(rotation * Vector3::z()))
            .z
            > 0.0;
        let aside = |side: &UnitVector3<f64>| {
            let along = if is_upright { side.x } else { side.y };
            let right_radians = along.atan2(side.z);
            if is_left_first { -right_radians } else { right_radians }
        };
        let [one, other] = [aside(&sides[0]), aside(&sides[1])];
        let lower = ends.iter().map(|end| down_radians(&(rotation * *end))).fold(f64::NEG_INFINITY, f64::max);
        Some(Self { left_radians: one.max(other), right_radians: one.min(other), lower_down_radians: lower })
    }
}

/// The angle of a direction below the horizon.
fn down_radians(direction: &UnitVector3<f64>) -> f64 {
    -direction.z.atan2(direction.x.hypot(direction.y))
}

/// Rows of a pinhole of these columns and view whose lower edge is this far below its middle.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates, and 1 is the least"
)]
fn rows(width_pixels: u32, view_radians: f64, below_radians: f64) -> u32 {
    let focal_pixels = f64::from(width_pixels) / 2.0 / (view_radians / 2.0).tan();
    let half_rows = focal_pixels * below_radians.clamp(0.0, MAX_VIEW_RADIANS / 2.0).tan();
    ((2.0 * half_rows).round() as u32).max(1)
}

#[cfg(test)]
mod tests;
