//! Bearings from a camera on a vehicle that rolls and pitches.

use std::f64::consts::FRAC_PI_2;

use super::Camera;

/// The roll and the pitch of a vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Roll, radians, right side down.
    pub roll_radians: f64,
    /// Pitch, radians, nose up.
    pub pitch_radians: f64,
}

impl Camera {
    /// The horizontal bearing of a pixel: radians counterclockwise from the vehicle's heading, from the camera's position.
    /// Columns and rows count from the left and upper edge, as those of [`super::DetectionBox`].
    ///
    /// Where vehicle and camera are level this is [`Camera::bearing_radians`] of the column. A camera that looks down, or
    /// on a vehicle that leans, sees the same column at another bearing in every row.
    ///
    /// `None` if the pixel shows what is straight above or below, which has no bearing.
    #[must_use]
    pub fn level_bearing_radians(&self, column: f64, row: f64, attitude: Attitude) -> Option<f64> {
        let settings = &self.settings;
        let forward = self.focal_length_pixels;
        let left = f64::from(settings.width_pixels) / 2.0 - column;
        let up = f64::from(settings.height_pixels) / 2.0 - row;
        // From the camera to the vehicle: forward, left, up.
        let (forward, up) = turned(forward, up, -settings.pitch_radians);
        let (forward, left) = turned(forward, left, settings.mounting.heading_radians);
        // To the horizon: first roll, then pitch.
        let (left, up) = turned(left, up, attitude.roll_radians);
        let (forward, up) = turned(forward, up, attitude.pitch_radians);
        let level_pixels = forward.hypot(left);
        // Written so that NaN fails as well.
        let has_bearing =
            level_pixels.atan2(up.abs()) > MIN_RADIANS && up.abs().atan2(level_pixels) < FRAC_PI_2;
        has_bearing.then(|| left.atan2(forward))
    }
}

/// Angle from the vertical below which a direction has no bearing worth the name, radians.
const MIN_RADIANS: f64 = 0.01;

/// A vector turned from its first axis toward its second.
fn turned(first: f64, second: f64, radians: f64) -> (f64, f64) {
    let (sine, cosine) = radians.sin_cos();
    (cosine * first - sine * second, sine * first + cosine * second)
}

#[cfg(test)]
mod tests {
    use dragnet_lattice::plane::Pose;

    use super::super::CameraSettings;
    use super::*;

    fn camera(yaw_degrees: f64, pitch_degrees: f64) -> Camera {
        let settings = CameraSettings {
            name: "front".to_owned(),
            width_pixels: 1000,
            height_pixels: 600,
            field_of_view_radians: 90.0_f64.to_radians(),
            mounting: Pose::new(0.0, 0.0, yaw_degrees.to_radians()),
            z_meters: 0.0,
            pitch_radians: pitch_degrees.to_radians(),
            min_range_meters: 1.0,
            max_range_meters: 100.0,
        };
        Camera::new(settings).unwrap()
    }

    fn degrees(camera: &Camera, pixel: [f64; 2], [roll, pitch]: [f64; 2]) -> Option<f64> {
        let attitude = Attitude { roll_radians: roll.to_radians(), pitch_radians: pitch.to_radians() };
        camera.level_bearing_radians(pixel[0], pixel[1], attitude).map(|radians| radians.to_degrees().round())
    }

    #[test]
    fn a_level_camera_measures_columns() {
        for yaw in [0.0, 120.0, -90.0] {
            let camera = camera(yaw, 0.0);
            for (column, row) in [(0.0, 0.0), (300.0, 600.0), (1000.0, 20.0)] {
                let found = camera.level_bearing_radians(column, row, Attitude::default()).unwrap();
                assert!((found - camera.bearing_radians(column)).abs() < 1e-12, "{yaw} {column}");
            }
        }
    }

    #[test]
    fn a_vehicle_that_leans_turns_what_it_sees() {
        let ahead = camera(0.0, 0.0);
        // Rolled to the right by a quarter, the upper edge of the image is its right one.
        assert_eq!(degrees(&ahead, [500.0, 0.0], [90.0, 0.0]), Some(-31.0));
        assert_eq!(degrees(&ahead, [0.0, 300.0], [90.0, 0.0]), Some(0.0));
        // A camera to the left: the nose up is its image turned.
        assert_eq!(degrees(&camera(90.0, 0.0), [500.0, 0.0], [0.0, 90.0]), Some(121.0));
        // What a pitched camera shows at its edge is farther to the side the lower it is.
        assert_eq!(degrees(&camera(0.0, 45.0), [0.0, 300.0], [0.0, 0.0]), Some(55.0));
        assert_eq!(degrees(&ahead, [0.0, 300.0], [0.0, -45.0]), Some(55.0));
        assert_eq!(degrees(&ahead, [500.0, 300.0], [0.0, -90.0]), None);
        assert_eq!(degrees(&ahead, [500.0, f64::NAN], [0.0, 0.0]), None);
    }
}
