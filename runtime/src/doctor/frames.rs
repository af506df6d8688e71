//! Checks of a vehicle's frames: its pose by transforms, and its cameras by calibration and mounting. Messages are
//! processed as by the running robot.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_vehicle::camera::MountedCamera;
use dragnet_vehicle::frames::Validity;
use dragnet_vehicle::pilot::CameraDetections;
use dragnet_vehicle::settings::MeasuredCamera;

use super::Finding;
use crate::ros::incoming::Incoming;
use crate::ros::settings::{Checked, Localization, Stamps};
use crate::unix_time;
use crate::vehicle::frames::Frames;
use crate::vehicle::measured::{MeasuredCameras, WaitingFrame};

/// The age of a pose above which it is stale, seconds: what a robot tolerates by default.
const MOST_AGE_SECONDS: f64 = 1.0;

/// The messages about frames and cameras.
pub(super) struct HeardFrames {
    stamps: Stamps,
    localization: Localization,
    frames: Frames,
    cameras: MeasuredCameras,
    /// The last frame of each camera that the network describes: its camera, or what is missing.
    seen: BTreeMap<Arc<str>, Option<Result<Arc<MountedCamera>, String>>>,
}

impl HeardFrames {
    pub(super) fn new(ros: &Checked, cameras: &[MeasuredCamera]) -> Self {
        Self {
            stamps: ros.stamps(),
            localization: ros.localization(),
            frames: Frames::new(ros),
            cameras: MeasuredCameras::new(cameras),
            seen: cameras.iter().map(|camera| (camera.name().into(), None)).collect(),
        }
    }

    pub(super) fn take(&mut self, received: &Incoming) {
        let now_ns = unix_time::now_ns();
        let time_ns = |stamp_ns| match self.stamps {
            Stamps::Clock => stamp_ns,
            Stamps::Arrival => now_ns,
        };
        match received {
            Incoming::Transforms(transforms) => {
                drop(self.frames.receive(transforms.clone(), |stamp_ns| Validity::At(time_ns(stamp_ns))));
            }
            Incoming::StaticTransforms(transforms) => {
                drop(self.frames.receive(transforms.clone(), |_| Validity::Always));
            }
            Incoming::CameraInfo { camera, info } => drop(self.cameras.calibrate(camera, info)),
            Incoming::Detections { camera, detections } if self.cameras.contains(camera) => {
                let frame = WaitingFrame {
                    camera: Arc::clone(camera),
                    time_ns: 0,
                    stamp_ns: time_ns(detections.stamp_unix_ns),
                    came_ns: now_ns.unsigned_abs(),
                    frame: detections.frame.clone(),
                    boxes: Vec::new(),
                };
                drop(self.cameras.put(frame));
            }
            _ => {}
        }
        self.process(now_ns.unsigned_abs());
    }

    /// Waiting frames, at a time.
    fn process(&mut self, now_ns: u64) {
        for frame in self.cameras.take(now_ns, &self.frames) {
            match frame {
                Ok(frame) => {
                    if let CameraDetections::Measured { camera, .. } = frame.detections {
                        self.seen.insert(frame.camera.into(), Some(Ok(camera)));
                    }
                }
                Err(lost) => drop(self.seen.insert(lost.camera, Some(Err(lost.reason)))),
            }
        }
    }

    pub(super) fn findings(mut self, listen: Duration) -> Vec<Finding> {
        let now_ns = unix_time::now_ns();
        // Frames that still wait have waited long enough.
        self.process(u64::MAX);
        let mut findings = Vec::new();
        let rejected = self.frames.rejected().map(str::to_owned);
        if self.localization == Localization::Tf {
            findings.push(self.pose(now_ns));
        }
        if let Some(rejected) = rejected {
            let advice =
                "let one node publish each transform; `ros2 run tf2_tools view_frames` draws all of them";
            findings.push(Finding::warn("frames", format!("a transform is rejected: {rejected}"), advice));
        }
        let seconds = listen.as_secs_f64();
        findings.extend(self.seen.iter().map(|(name, seen)| camera(name, seen.as_ref(), seconds)));
        findings
    }

    /// The vehicle's pose, and how old it is.
    fn pose(&mut self, now_ns: i64) -> Finding {
        let advice = "start what publishes it (localization, odometry, robot_state_publisher), or correct \
                      ros.map_frame and ros.robot_frame";
        let chain = self.frames.chain();
        match (chain, self.frames.news()) {
            (Ok(chain), Some((time_ns, _))) => {
                let age_seconds = now_ns.saturating_sub(time_ns) as f64 / 1e9;
                if age_seconds.abs() <= MOST_AGE_SECONDS {
                    return Finding::pass("pose", format!("{chain}, {age_seconds:.2} s ago"));
                }
                let why = self.frames.why_no_pose(now_ns);
                Finding::fail("pose", format!("{chain}: {why}"), advice)
            }
            _ => Finding::fail("pose", self.frames.why_no_pose(now_ns), advice),
        }
    }
}

fn camera(name: &str, seen: Option<&Result<Arc<MountedCamera>, String>>, seconds: f64) -> Finding {
    let subject = format!("camera {name}");
    match seen {
        Some(Ok(camera)) => Finding::pass(subject, description(camera)),
        Some(Err(reason)) => {
            let advice = "start what publishes it (the camera's driver, robot_state_publisher); or give the camera's size, \
                          field of view and mounting in vehicle.cameras";
            Finding::fail(subject, reason, advice)
        }
        None => {
            let found = format!("no detections in {seconds:.0} s, so that its mounting was not looked for");
            Finding::warn(subject, found, "start its detector")
        }
    }
}

/// How a camera looks, for a comparison with the vehicle.
fn description(camera: &MountedCamera) -> String {
    let settings = camera.camera().settings();
    let (place, lens) = (settings.mounting, camera.lens());
    // Not -0.
    let whole_degrees = |radians: f64| radians.to_degrees().round() + 0.0;
    format!(
        "{} x {} pixels, {:.0} degrees wide; {:.2} m forward, {:.2} m left, {:.2} m up; it looks {:.0} degrees left of ahead \
         and {:.0} degrees down",
        lens.width_pixels,
        lens.height_pixels,
        settings.field_of_view_radians.to_degrees(),
        place.x_meters,
        place.y_meters,
        settings.z_meters,
        whole_degrees(place.heading_radians),
        whole_degrees(settings.pitch_radians),
    )
}
