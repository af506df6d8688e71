//! Cameras that the vehicle's network describes: their frames wait until calibration and mounting are known.
//!
//! A transform of an image's time may arrive after its detections, and a tree's publisher may start late. So a frame
//! waits for a second; then it is rejected, with what is missing.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use dragnet_ros2::input::{CameraInfo, Distortion as RosDistortion};
use dragnet_vehicle::camera::{DetectionBox, Distortion, Lens, MountedCamera};
use dragnet_vehicle::pilot::{CameraDetections, CameraFrame};
use dragnet_vehicle::settings::MeasuredCamera;
use nalgebra::Isometry3;

use super::frames::Frames;

/// How long a frame waits, nanoseconds of mission time.
const WAIT_NS: u64 = 1_000_000_000;
/// The most frames that wait, of all cameras.
const MOST_WAITING: usize = 128;

/// The cameras, by name.
#[derive(Clone, Debug)]
pub(crate) struct MeasuredCameras {
    cameras: BTreeMap<Arc<str>, Eye>,
    /// By arrival.
    waiting: VecDeque<WaitingFrame>,
}

#[derive(Clone, Debug)]
struct Eye {
    settings: MeasuredCamera,
    lens: Option<Lens>,
    /// The optical frame, if its calibration has named it.
    frame: Option<String>,
    /// The last camera, with its mounting.
    mounted: Option<(Isometry3<f64>, Arc<MountedCamera>)>,
}

/// Boxes of an image.
#[derive(Clone, Debug)]
pub(crate) struct WaitingFrame {
    pub(crate) camera: Arc<str>,
    /// When the image was taken, nanoseconds of mission time.
    pub(crate) time_ns: u64,
    /// The same by the clock of stamps.
    pub(crate) stamp_ns: i64,
    /// When it arrived, nanoseconds of mission time.
    pub(crate) came_ns: u64,
    /// The frame that it names; may be empty.
    pub(crate) frame: String,
    pub(crate) boxes: Vec<DetectionBox>,
}

/// Why a frame is rejected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Unmeasured {
    pub(crate) camera: Arc<str>,
    /// The same for frames that lack the same.
    pub(crate) kind: &'static str,
    pub(crate) reason: String,
}

/// What is missing, and whether it may still arrive.
struct Missing {
    may_pass: bool,
    kind: &'static str,
    reason: String,
}

impl MeasuredCameras {
    pub(crate) fn new(cameras: &[MeasuredCamera]) -> Self {
        let eyes = cameras.iter().map(|camera| {
            let eye =
                Eye { settings: camera.clone(), lens: camera.lens().cloned(), frame: None, mounted: None };
            (Arc::from(camera.name()), eye)
        });
        Self { cameras: eyes.collect(), waiting: VecDeque::new() }
    }

    pub(crate) fn contains(&self, camera: &str) -> bool {
        self.cameras.contains_key(camera)
    }

    /// Columns and rows of a camera's images, if they are known.
    pub(crate) fn size_pixels(&self, camera: &str) -> Option<[u32; 2]> {
        let lens = self.cameras.get(camera)?.lens.as_ref()?;
        Some([lens.width_pixels, lens.height_pixels])
    }

    /// Sets a camera's calibration. Returns whether it has changed.
    pub(crate) fn calibrate(&mut self, camera: &str, info: &CameraInfo) -> bool {
        // A camera whose settings describe its lens has no such topic.
        let Some(eye) = self.cameras.get_mut(camera) else { return false };
        let frame = (!info.frame.is_empty()).then(|| info.frame.clone());
        let lens = lens(info);
        let has_changed = eye.lens.as_ref().is_some_and(|before| *before != lens || eye.frame != frame);
        if eye.lens.as_ref() != Some(&lens) {
            eye.mounted = None;
        }
        (eye.lens, eye.frame) = (Some(lens), frame);
        has_changed
    }

    /// Adds a frame; returns the oldest one if too many wait.
    pub(crate) fn put(&mut self, frame: WaitingFrame) -> Option<Unmeasured> {
        self.waiting.push_back(frame);
        if self.waiting.len() <= MOST_WAITING {
            return None;
        }
        let camera = self.waiting.pop_front()?.camera;
        Some(Unmeasured { camera, kind: "waiting", reason: format!("{MOST_WAITING} frames wait already") })
    }

    /// The frames whose cameras are known by now, and those that have waited in vain.
    pub(crate) fn take(&mut self, now_ns: u64, frames: &Frames) -> Vec<Result<CameraFrame, Unmeasured>> {
        let mut taken = Vec::new();
        for frame in std::mem::take(&mut self.waiting) {
            match self.mounted(&frame, frames) {
                Ok(camera) => taken.push(Ok(measured(frame, camera))),
                // The clock may have been set back.
                Err(missing) if missing.may_pass && now_ns.abs_diff(frame.came_ns) < WAIT_NS => {
                    self.waiting.push_back(frame);
                }
                Err(Missing { kind, reason, .. }) => {
                    taken.push(Err(Unmeasured { camera: frame.camera, kind, reason }));
                }
            }
        }
        taken
    }

    fn mounted(&mut self, frame: &WaitingFrame, frames: &Frames) -> Result<Arc<MountedCamera>, Missing> {
        let missing = |may_pass, kind, reason| Err(Missing { may_pass, kind, reason });
        let Some(eye) = self.cameras.get_mut(&frame.camera) else {
            return missing(false, "unknown", "the settings have no such camera".to_owned());
        };
        let Some(lens) = &eye.lens else {
            return missing(true, "calibration", "no valid camera_info has arrived".to_owned());
        };
        let mounting = match eye.settings.vehicle_from_camera() {
            Some(mounting) => *mounting,
            None => eye.mounting(frame, frames)?,
        };
        if let Some((before, camera)) = &eye.mounted
            && *before == mounting
        {
            return Ok(Arc::clone(camera));
        }
        match eye.settings.mounted(lens.clone(), &mounting) {
            Ok(camera) => {
                let camera = Arc::new(camera);
                eye.mounted = Some((mounting, Arc::clone(&camera)));
                Ok(camera)
            }
            Err(error) => missing(false, "impossible", error.to_string()),
        }
    }
}

impl Eye {
    /// The pose of the camera at the time of a frame.
    fn mounting(&self, frame: &WaitingFrame, frames: &Frames) -> Result<Isometry3<f64>, Missing> {
        let missing = |may_pass, kind, reason| Err(Missing { may_pass, kind, reason });
        let of_frame = (!frame.frame.is_empty()).then_some(&frame.frame);
        let name = match (of_frame, &self.frame) {
            (Some(seen), Some(calibrated)) if !is_same(seen, calibrated) => {
                let reason = format!(
                    "its detections name the frame {seen:?}, its camera_info {calibrated:?}: of two cameras?"
                );
                return missing(false, "two_frames", reason);
            }
            (Some(name), _) | (None, Some(name)) => name,
            (None, None) => {
                let reason = "neither its detections nor a camera_info names its frame".to_owned();
                return missing(false, "unnamed", reason);
            }
        };
        frames.mounting(name, frame.stamp_ns).map_err(|error| Missing {
            may_pass: error.may_pass(),
            kind: error.kind(),
            reason: error.to_string(),
        })
    }
}

fn measured(frame: WaitingFrame, camera: Arc<MountedCamera>) -> CameraFrame {
    CameraFrame {
        time_ns: frame.time_ns,
        camera: frame.camera.to_string(),
        head_radians: 0.0,
        detections: CameraDetections::Measured { camera, boxes: frame.boxes },
    }
}

/// A leading slash is from ROS 1.
fn is_same(one: &str, other: &str) -> bool {
    one.trim_start_matches('/') == other.trim_start_matches('/')
}

/// The lens of a calibration.
pub(crate) fn lens(info: &CameraInfo) -> Lens {
    let distortion = match info.distortion {
        RosDistortion::None => Distortion::NONE,
        RosDistortion::PlumbBob([k1, k2, p1, p2, k3]) => {
            Distortion::Radial { radial: [k1, k2, k3, 0.0, 0.0, 0.0], tangential: [p1, p2] }
        }
        RosDistortion::RationalPolynomial([k1, k2, p1, p2, k3, k4, k5, k6]) => {
            Distortion::Radial { radial: [k1, k2, k3, k4, k5, k6], tangential: [p1, p2] }
        }
        RosDistortion::Equidistant(coefficients) => Distortion::Equidistant(coefficients),
    };
    Lens {
        width_pixels: info.width_pixels,
        height_pixels: info.height_pixels,
        focal_pixels: info.focal_pixels,
        center_pixels: info.center_pixels,
        distortion,
    }
}
