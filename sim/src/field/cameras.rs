//! A vehicle's cameras, detector and localization: with noise, misses and false alarms.
//!
//! Both cameras of the paper (section IV) face the same direction from a head that turns all the time, so that they see
//! all around, as the paper's robot does (Fig. 3). The detector finds an object by its size in the image: a person's
//! height in pixels, a logistic curve around [`HALF_FOUND_PIXELS`]. False alarms occur at any column, independently in
//! each image.

use std::f64::consts::TAU;

use dragnet_lattice::plane::{Pose, bearing_radians, wrapped_radians};
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_vehicle::camera::{Camera, DetectionBox};
use dragnet_vehicle::pilot::{CameraDetections, CameraFrame, PoseEstimate};
use dragnet_vehicle::settings::Checked;
use nalgebra::Vector2;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// Speed of the head: one turn in 3 s.
pub const HEAD_RADIANS_PER_SECOND: f64 = TAU / 3.0;

/// Of a mannequin, meters.
const OBJECT_HEIGHT_METERS: f64 = 1.7;
const OBJECT_WIDTH_METERS: f64 = 0.5;
/// Height in the image at which half of the objects are detected, pixels.
const HALF_FOUND_PIXELS: f64 = 50.0;
/// Increase of the height that multiplies the odds by e, pixels.
const SLOPE_PIXELS: f64 = 10.0;
/// Maximum detection probability, since trees may be in between.
const MOST_FOUND: f64 = 0.95;
/// Probability of a false alarm in an image.
const FALSE_ALARM: f64 = 0.005;

/// Standard deviation of the simulated localization, meters and radians.
const PLACE_DEVIATION_METERS: f64 = 0.1;
const HEADING_DEVIATION_RADIANS: f64 = 0.005;

/// Probability that an object of this height in the image is detected.
#[must_use]
pub fn detection_probability(height_pixels: f64) -> f64 {
    MOST_FOUND / (1.0 + ((HALF_FOUND_PIXELS - height_pixels) / SLOPE_PIXELS).exp())
}

/// The simulated sensors of one vehicle.
#[derive(Clone, Debug)]
pub(super) struct SimulatedCameras {
    cameras: Vec<(Camera, f64)>,
    noise: Stream,
}

impl SimulatedCameras {
    pub(super) fn new(settings: &Checked, seed: u64, robot: RobotId) -> Self {
        Self { cameras: settings.cameras.clone(), noise: stream(seed, Purpose::Noise, robot.number()) }
    }

    /// The vehicle's pose estimate.
    pub(super) fn fix(&mut self, now: MissionTime, pose: &Pose) -> PoseEstimate {
        let mut error = |deviation: f64| self.normal() * deviation;
        PoseEstimate {
            time_ns: now.0,
            pose: Pose::new(
                pose.x_meters + error(PLACE_DEVIATION_METERS),
                pose.y_meters + error(PLACE_DEVIATION_METERS),
                wrapped_radians(pose.heading_radians + error(HEADING_DEVIATION_RADIANS)),
            ),
            deviation_meters: PLACE_DEVIATION_METERS,
            heading_deviation_radians: HEADING_DEVIATION_RADIANS,
        }
    }

    /// An image of each camera, as detected boxes.
    pub(super) fn observe(
        &mut self,
        now: MissionTime,
        pose: &Pose,
        objects_meters: &[Vector2<f64>],
    ) -> Vec<CameraFrame> {
        let head_radians = wrapped_radians(now.as_seconds() * HEAD_RADIANS_PER_SECOND);
        let head = Pose { heading_radians: wrapped_radians(pose.heading_radians + head_radians), ..*pose };
        let cameras = self.cameras.clone();
        let frame = |(camera, column_deviation): &(Camera, f64)| {
            let mut boxes: Vec<DetectionBox> = objects_meters
                .iter()
                .filter_map(|&object| self.detect(camera, *column_deviation, &head, object))
                .collect();
            boxes.extend(self.imagine(camera));
            CameraFrame {
                time_ns: now.0,
                camera: camera.settings().name.clone(),
                head_radians,
                detections: CameraDetections::Boxes(boxes),
            }
        };
        cameras.iter().map(frame).collect()
    }

    fn detect(
        &mut self,
        camera: &Camera,
        column_deviation: f64,
        head: &Pose,
        object: Vector2<f64>,
    ) -> Option<DetectionBox> {
        let eye = head.of_part(&camera.settings().mounting);
        let range_meters = (object - eye.position_meters()).norm();
        let bearing = wrapped_radians(bearing_radians(eye.position_meters(), object) - head.heading_radians);
        // All are drawn, in view or not: an object out of view changes no other one's noise.
        let (luck, error) = (self.noise.random::<f64>(), self.normal() * column_deviation);
        if !camera.sees(bearing, range_meters) {
            return None;
        }
        let pixels = |meters: f64| camera.focal_length_pixels() * meters / range_meters;
        if luck >= detection_probability(pixels(OBJECT_HEIGHT_METERS)) {
            return None;
        }
        let column = camera.column_pixels(bearing)? + error;
        boxed(camera, column, pixels(OBJECT_WIDTH_METERS), pixels(OBJECT_HEIGHT_METERS))
    }

    fn imagine(&mut self, camera: &Camera) -> Option<DetectionBox> {
        let (luck, column) = (self.noise.random::<f64>(), self.noise.random::<f64>());
        let width = f64::from(camera.settings().width_pixels);
        if luck < FALSE_ALARM { boxed(camera, column * width, 20.0, 60.0) } else { None }
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.noise)
    }
}

/// A box around a column, cut symmetrically at the edges of the image.
fn boxed(camera: &Camera, column: f64, width: f64, height: f64) -> Option<DetectionBox> {
    let (columns, rows) =
        (f64::from(camera.settings().width_pixels), f64::from(camera.settings().height_pixels));
    let half_width = (width / 2.0).min(column).min(columns - column);
    let half_height = (height / 2.0).min(rows / 2.0);
    let is_seen = half_width > 0.0 && half_height > 0.0;
    is_seen.then(|| DetectionBox {
        left: column - half_width,
        top: rows / 2.0 - half_height,
        right: column + half_width,
        bottom: rows / 2.0 + half_height,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_are_detected_as_often_as_their_size_in_the_image_implies() {
        let checked = super::super::settings(2.0).check(None).unwrap();
        let mut eyes = SimulatedCameras::new(&checked, 1, RobotId::FIRST);
        let wide = checked.cameras[0].0.clone();
        let head = Pose::new(0.0, 0.0, 0.0);
        let mut shares = Vec::new();
        for range in [20.0, 60.0, 75.0] {
            let object = Vector2::new(range, 1.0);
            let found = (0..4000).filter(|_| eyes.detect(&wide, 4.0, &head, object).is_some()).count();
            let height = wide.focal_length_pixels() * OBJECT_HEIGHT_METERS / range;
            let share = found as f64 / 4000.0;
            assert!((share - detection_probability(height)).abs() < 0.03, "{range} {share}");
            shares.push(share);
        }
        assert!(shares[0] > 0.9 && shares[2] < 0.6, "{shares:?}");
        let behind = Vector2::new(-20.0, 0.0);
        assert!((0..100).all(|_| eyes.detect(&wide, 4.0, &head, behind).is_none()));
    }
}
