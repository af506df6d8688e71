//! The plane that a robot drives on: angles and poses.
//!
//! Map frame: meters east and north of the map's south-western corner. Angles are radians, counter-clockwise from east.
//! A vehicle's own frame has x forward and y to the left, angles counter-clockwise from forward.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Vector2};

/// The same angle within `-pi..=pi`, radians. An angle in this range is returned unchanged.
#[must_use]
pub fn wrapped_radians(angle_radians: f64) -> f64 {
    if angle_radians.abs() <= PI {
        return angle_radians;
    }
    angle_radians - TAU * (angle_radians / TAU).round()
}

/// The shorter turn from one heading to another, in `-pi..=pi`; counter-clockwise is positive.
#[must_use]
pub fn turn_radians(from_radians: f64, to_radians: f64) -> f64 {
    wrapped_radians(to_radians - from_radians)
}

/// A position and a heading on the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Meters east of the map's south-western corner.
    pub x_meters: f64,
    /// Meters north of it.
    pub y_meters: f64,
    /// Radians, counter-clockwise from east.
    pub heading_radians: f64,
}

impl Pose {
    /// A pose at these meters east and north.
    #[must_use]
    pub const fn new(east_meters: f64, north_meters: f64, heading_radians: f64) -> Self {
        Self { x_meters: east_meters, y_meters: north_meters, heading_radians }
    }

    /// Meters east and north of the map's south-western corner.
    #[must_use]
    pub const fn position_meters(&self) -> Vector2<f64> {
        Vector2::new(self.x_meters, self.y_meters)
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub const fn is_finite(&self) -> bool {
        self.x_meters.is_finite() && self.y_meters.is_finite() && self.heading_radians.is_finite()
    }

    /// The pose on the map of a part with this pose in the vehicle's frame.
    #[must_use]
    pub fn of_part(&self, part: &Self) -> Self {
        let (sin, cos) = self.heading_radians.sin_cos();
        let (forward, left) = (part.x_meters, part.y_meters);
        Self {
            x_meters: self.x_meters + (cos * forward - sin * left),
            y_meters: self.y_meters + (sin * forward + cos * left),
            heading_radians: wrapped_radians(self.heading_radians + part.heading_radians),
        }
    }

    /// The covariance of a position in this pose's own frame, rotated to the frame of the pose.
    #[must_use]
    pub fn covariance_of_part(&self, covariance: &Matrix2<f64>) -> Matrix2<f64> {
        let (sin, cos) = self.heading_radians.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        turn * covariance * turn.transpose()
    }

    /// The same pose relative to another one.
    #[must_use]
    pub fn seen_from(&self, frame: &Self) -> Self {
        let (sin, cos) = frame.heading_radians.sin_cos();
        let (east, north) = (self.x_meters - frame.x_meters, self.y_meters - frame.y_meters);
        Self {
            x_meters: cos * east + sin * north,
            y_meters: cos * north - sin * east,
            heading_radians: turn_radians(frame.heading_radians, self.heading_radians),
        }
    }
}

/// Direction from one point to another, radians in `-pi..=pi`, counter-clockwise from east. Between equal
/// points it is 0.
#[must_use]
pub fn bearing_radians(from_meters: Vector2<f64>, to_meters: Vector2<f64>) -> f64 {
    let offset = to_meters - from_meters;
    offset.y.atan2(offset.x)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    use super::*;

    #[test]
    fn wrapping_turns_by_whole_turns_only() {
        for (angle, expected) in
            [(0.5, 0.5), (PI, PI), (-PI, -PI), (PI + 0.5, 0.5 - PI), (-7.0 * PI, PI), (9.0, 9.0 - TAU)]
        {
            let wrapped = wrapped_radians(angle);
            assert!((wrapped.abs() - f64::abs(expected)).abs() < 1e-12, "{angle} {wrapped}");
            assert!((wrapped.sin() - angle.sin()).abs() < 1e-12, "{angle} {wrapped}");
        }
        assert!(wrapped_radians(f64::NAN).is_nan());
    }

    #[test]
    fn a_part_turns_with_its_vehicle() {
        let vehicle = Pose::new(10.0, 20.0, FRAC_PI_2);
        let camera = vehicle.of_part(&Pose::new(2.0, 1.0, 0.25));
        assert!((camera.position_meters() - Vector2::new(9.0, 22.0)).norm() < 1e-12);
        assert!((camera.heading_radians - (FRAC_PI_2 + 0.25)).abs() < 1e-12);
        let part = camera.seen_from(&vehicle);
        assert!((part.position_meters() - Vector2::new(2.0, 1.0)).norm() < 1e-12);
        assert!((part.heading_radians - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_covariance_turns_with_its_frame() {
        let along_x = Matrix2::new(4.0, 0.0, 0.0, 1.0);
        let turned = Pose::new(10.0, 20.0, FRAC_PI_4).covariance_of_part(&along_x);
        assert!((turned - Matrix2::new(2.5, 1.5, 1.5, 2.5)).norm() < 1e-12, "{turned}");
    }
}
