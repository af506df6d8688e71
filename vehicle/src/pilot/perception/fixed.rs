//! Detections that stay at one place of the image while the camera turns: of dirt on the lens, or of the vehicle itself.

use std::collections::BTreeMap;

use dragnet_lattice::plane::turn_radians;

use super::window::{KEPT, Window};
use crate::pilot::diagnostic::Fault;

/// Width of a place in the image, radians.
const PLACE_RADIANS: f64 = 0.03;
/// Share of the frames with a detection at one place from which it is of no object,
const LEAST_SHARE: f64 = 0.7;
/// and how far the camera has to turn meanwhile, radians.
const LEAST_TURN_RADIANS: f64 = std::f64::consts::PI;
/// Smaller changes of its heading are errors of the vehicle's pose, which would add up while it stands, radians.
const LEAST_STEP_RADIANS: f64 = 0.1;

/// The places of one camera's detections.
#[derive(Clone, Debug, Default)]
pub(super) struct FixedDetections {
    window: Window,
    turned_radians: f64,
    /// To which it has turned last.
    heading_radians: Option<f64>,
    /// Number of frames with a detection at each place.
    places: BTreeMap<i32, f64>,
}

impl FixedDetections {
    /// Adds a frame of a camera that faces this way, with the bearings of its detections relative to that.
    #[expect(clippy::cast_possible_truncation, reason = "bearings are angles")]
    pub(super) fn add(&mut self, heading_radians: f64, bearings_radians: &[f64]) {
        self.window.add();
        self.turned_radians *= KEPT;
        let step_radians =
            turn_radians(*self.heading_radians.get_or_insert(heading_radians), heading_radians).abs();
        if step_radians >= LEAST_STEP_RADIANS {
            self.turned_radians += step_radians;
            self.heading_radians = Some(heading_radians);
        }
        self.places.retain(|_, count| {
            *count *= KEPT;
            *count > 0.01
        });
        let mut places: Vec<i32> =
            bearings_radians.iter().map(|bearing| (bearing / PLACE_RADIANS).round() as i32).collect();
        places.sort_unstable();
        places.dedup();
        for place in places {
            *self.places.entry(place).or_insert(0.0) += 1.0;
        }
    }

    /// What is wrong if there is such a detection.
    pub(super) fn fault(&self) -> Option<Fault> {
        if !self.window.is_enough() || self.turned_radians < LEAST_TURN_RADIANS {
            return None;
        }
        let frames = self.window.frames();
        // On the border of two places it is in either.
        let beside = |place: i32| self.places.get(&(place + 1)).unwrap_or(&0.0);
        let shares = self.places.iter().map(|(&place, count)| (place, (count + beside(place)) / frames));
        let (place, share) = shares.max_by(|a, b| a.1.total_cmp(&b.1))?;
        if share < LEAST_SHARE {
            return None;
        }
        let degrees = (f64::from(place) * PLACE_RADIANS).to_degrees();
        let (percent, side) = (share.min(1.0) * 100.0, if degrees < 0.0 { "right" } else { "left" });
        let message = format!(
            "{percent:.0} % of its frames have a detection {:.0} degrees {side} of ahead, wherever it faces: look for dirt \
             on the lens, or parts of the vehicle",
            degrees.abs()
        );
        Some(Fault::new("fixed", &message, &[("bearing_degrees", degrees)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is wrong after 400 frames of a camera that turns by so much in each, with a detection in so many of ten, at a
    /// bearing that moves by so much.
    fn fault(turn_radians: f64, of_ten: u32, motion_radians: f64) -> Option<Fault> {
        fault_facing(|frame| turn_radians * f64::from(frame), of_ten, motion_radians)
    }

    /// The same of a camera that faces this way in each frame.
    fn fault_facing(heading_radians: impl Fn(u32) -> f64, of_ten: u32, motion_radians: f64) -> Option<Fault> {
        let mut fixed = FixedDetections::default();
        for frame in 0..400 {
            let bearing = 0.3 + motion_radians * f64::from(frame % 100);
            let bearings = if frame % 10 < of_ten { vec![bearing] } else { Vec::new() };
            fixed.add(heading_radians(frame), &bearings);
        }
        fixed.fault()
    }

    #[test]
    fn a_detection_that_turns_with_the_camera_is_of_no_object() {
        let dirt = fault(0.05, 9, 0.0).unwrap().to_string();
        assert!(dirt.starts_with("90 % of its frames have a detection 17 degrees left of ahead"), "{dirt}");
        assert!(fault(0.001, 9, 0.0).is_none(), "it faces the same way: there may be an object");
        let uncertain = |frame| if frame % 2 == 0 { 0.02 } else { -0.02 };
        assert!(fault_facing(uncertain, 9, 0.0).is_none(), "it stands, and its heading is uncertain");
        assert!(fault(0.05, 5, 0.0).is_none(), "as often as not it is elsewhere");
        assert!(fault(0.05, 10, 0.01).is_none(), "it moves through the image");
    }
}
