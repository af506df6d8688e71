//! What a vehicle's cameras and its localization tell: with noise, misses and things that are not there.
//!
//! Both cameras of the paper (section IV) look the same way from a head that turns all the time, so that they
//! see all around, as the paper's robot does (Fig. 3). The detector finds a thing by its size in the image: a
//! person's height in pixels, a logistic curve around [`HALF_FOUND_PIXELS`]. False alarms come at any column,
//! independently in each image.

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

/// Speed of the head: once around in 3 s.
pub const HEAD_RADIANS_PER_SECOND: f64 = TAU / 3.0;

/// Of a mannequin, meters.
const THING_HEIGHT_METERS: f64 = 1.7;
const THING_WIDTH_METERS: f64 = 0.5;
/// Of this height in the image every other one is found, pixels.
const HALF_FOUND_PIXELS: f64 = 50.0;
/// And by so much more the odds grow by a factor of e, pixels.
const SLOPE_PIXELS: f64 = 10.0;
/// However large it is in the image, it may be missed: trees stand in between.
const MOST_FOUND: f64 = 0.95;
/// An image holds something that is not there.
const FALSE_ALARM: f64 = 0.005;

/// Standard deviation of what the localization tells, meters and radians.
const PLACE_DEVIATION_METERS: f64 = 0.1;
const HEADING_DEVIATION_RADIANS: f64 = 0.005;

/// Probability that a thing so high in the image is found in it.
#[must_use]
pub fn detection_probability(height_pixels: f64) -> f64 {
    MOST_FOUND / (1.0 + ((HALF_FOUND_PIXELS - height_pixels) / SLOPE_PIXELS).exp())
}

/// The senses of one vehicle.
#[derive(Clone, Debug)]
pub(super) struct SimulatedCameras {
    cameras: Vec<(Camera, f64)>,
    noise: Stream,
}

impl SimulatedCameras {
    pub(super) fn new(settings: &Checked, seed: u64, robot: RobotId) -> Self {
        Self { cameras: settings.cameras.clone(), noise: stream(seed, Purpose::Noise, robot.number()) }
    }

    /// Where the vehicle takes itself to be.
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

    /// An image of each camera, as its detector tells it.
    pub(super) fn look(
        &mut self,
        now: MissionTime,
        pose: &Pose,
        things_meters: &[Vector2<f64>],
    ) -> Vec<CameraFrame> {
        let head_radians = wrapped_radians(now.as_seconds() * HEAD_RADIANS_PER_SECOND);
        let head = Pose { heading_radians: wrapped_radians(pose.heading_radians + head_radians), ..*pose };
        let cameras = self.cameras.clone();
        let frame = |(camera, column_deviation): &(Camera, f64)| {
            let mut boxes: Vec<DetectionBox> = things_meters
                .iter()
                .filter_map(|&thing| self.detect(camera, *column_deviation, &head, thing))
                .collect();
            boxes.extend(self.imagine(camera));
            CameraFrame {
                time_ns: now.0,
                camera: camera.settings().name.clone(),
                head_radians,
                sights: CameraDetections::Boxes(boxes),
            }
        };
        cameras.iter().map(frame).collect()
    }

    fn detect(
        &mut self,
        camera: &Camera,
        column_deviation: f64,
        head: &Pose,
        thing: Vector2<f64>,
    ) -> Option<DetectionBox> {
        let eye = head.of_part(&camera.settings().mounting);
        let range_meters = (thing - eye.position_meters()).norm();
        let bearing = wrapped_radians(bearing_radians(eye.position_meters(), thing) - head.heading_radians);
        // All are drawn, seen or not: a thing out of view moves no other one's noise.
        let (luck, error) = (self.noise.random::<f64>(), self.normal() * column_deviation);
        if !camera.sees(bearing, range_meters) {
            return None;
        }
        let pixels = |meters: f64| camera.focal_length_pixels() * meters / range_meters;
        if luck >= detection_probability(pixels(THING_HEIGHT_METERS)) {
            return None;
        }
        let column = camera.column_pixels(bearing)? + error;
        boxed(camera, column, pixels(THING_WIDTH_METERS), pixels(THING_HEIGHT_METERS))
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

/// A box around a column, cut at the edges of the image to both sides alike.
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
    fn things_are_found_as_often_as_their_size_in_the_image_says() {
        let checked = super::super::settings(2.0).check(None).unwrap();
        let mut eyes = SimulatedCameras::new(&checked, 1, RobotId::FIRST);
        let wide = checked.cameras[0].0.clone();
        let head = Pose::new(0.0, 0.0, 0.0);
        let mut shares = Vec::new();
        for range in [20.0, 60.0, 75.0] {
            let thing = Vector2::new(range, 1.0);
            let found = (0..4000).filter(|_| eyes.detect(&wide, 4.0, &head, thing).is_some()).count();
            let height = wide.focal_length_pixels() * THING_HEIGHT_METERS / range;
            let share = found as f64 / 4000.0;
            assert!((share - detection_probability(height)).abs() < 0.03, "{range} {share}");
            shares.push(share);
        }
        assert!(shares[0] > 0.9 && shares[2] < 0.6, "{shares:?}");
        let behind = Vector2::new(-20.0, 0.0);
        assert!((0..100).all(|_| eyes.detect(&wide, 4.0, &head, behind).is_none()));
    }
}
