//! What a vehicle learns of itself from its network: where it is and how its cameras are mounted, by transforms, and
//! their calibration.

use std::sync::Arc;

use dragnet_ros2::input::{CameraInfo, Transforms};
use dragnet_ros2::name::TopicName;
use dragnet_vehicle::camera::DetectionBox;
use dragnet_vehicle::frames::Validity;
use dragnet_vehicle::pilot::{Event, InputSource};

use super::measured::{Unmeasured, WaitingFrame};
use super::{Effect, Now, Taken, Vehicle};
use crate::ros::settings::{Localization, Stamps};

impl Vehicle {
    pub(super) fn receive_transforms(
        &mut self,
        now: Now,
        topic: &TopicName,
        transforms: Transforms,
    ) -> Vec<Effect> {
        let (stamps, mission_ns) = (self.stamps, signed(now.mission.0));
        let validity = |stamp_unix_ns| match stamps {
            Stamps::Clock => Validity::At(stamp_unix_ns),
            Stamps::Arrival => Validity::At(mission_ns),
        };
        let rejected = self.frames.receive(transforms, validity);
        let mut effects = self.reject(now, topic, &rejected);
        if self.places.source() == Localization::Tf
            && let Some((stamp_ns, pose)) = self.frames.news()
        {
            let mut moment = self.moment(now, stamp_ns);
            if self.stamps == Stamps::Arrival {
                moment.time_ns = u64::try_from(stamp_ns).unwrap_or(0);
            }
            let located = self.places.transformed(moment, &pose);
            effects.extend(self.locate(now, &located));
        }
        effects.extend(self.process_measured(now));
        effects
    }

    pub(super) fn receive_static_transforms(
        &mut self,
        now: Now,
        topic: &TopicName,
        transforms: Transforms,
    ) -> Vec<Effect> {
        let rejected = self.frames.receive(transforms, |_| Validity::Always);
        let mut effects = self.reject(now, topic, &rejected);
        effects.extend(self.process_measured(now));
        effects
    }

    fn reject(&mut self, now: Now, topic: &TopicName, reasons: &[String]) -> Vec<Effect> {
        for reason in reasons {
            self.aggregator.refuse(now.mission, topic, reason);
        }
        self.news()
    }

    pub(super) fn receive_calibration(
        &mut self,
        now: Now,
        camera: &Arc<str>,
        info: &CameraInfo,
    ) -> Vec<Effect> {
        if self.measured.calibrate(camera, info) {
            let (width, height) = (info.width_pixels, info.height_pixels);
            let message = format!(
                "the camera_info has changed: now {width} x {height} pixels, focal length {:.1} pixels, frame {:?}",
                info.focal_pixels[0], info.frame
            );
            // Two publishers may take turns.
            self.aggregator.note_as(now.mission, &calibration(camera), "changed", &message);
        } else {
            self.aggregator.well(now.mission, &calibration(camera));
        }
        let mut effects = self.news();
        effects.extend(self.process_measured(now));
        effects
    }

    /// A frame of a camera that the network describes.
    pub(super) fn measure(
        &mut self,
        now: Now,
        camera: &Arc<str>,
        taken: Taken,
        boxes: Vec<DetectionBox>,
    ) -> Vec<Effect> {
        let Taken { time_ns, stamp_ns, frame } = taken;
        let (camera, came_ns) = (Arc::clone(camera), now.mission.0);
        if let Some(lost) =
            self.measured.put(WaitingFrame { camera, time_ns, stamp_ns, came_ns, frame, boxes })
        {
            self.reject_frame(now, &lost);
        }
        self.process_measured(now)
    }

    /// Passes the frames to the pilot whose cameras are known by now.
    pub(super) fn process_measured(&mut self, now: Now) -> Vec<Effect> {
        let mut effects = Vec::new();
        for frame in self.measured.take(now.mission.0, &self.frames) {
            match frame {
                Ok(frame) => {
                    self.aggregator.well(now.mission, &subject(&frame.camera));
                    effects.extend(self.tell(now, Event::Frame(frame)));
                }
                Err(lost) => self.reject_frame(now, &lost),
            }
        }
        effects.extend(self.news());
        effects
    }

    fn reject_frame(&mut self, now: Now, lost: &Unmeasured) {
        let Unmeasured { camera, kind, reason } = lost;
        self.refuse(&InputSource::Camera(camera.to_string()), reason);
        self.aggregator.note_as(now.mission, &subject(camera), *kind, reason);
    }

    /// Without a calibration the size of a camera's images is unknown.
    pub(super) fn tell_uncalibrated(&mut self, now: Now, topic: &TopicName, camera: &str) -> Vec<Effect> {
        if self.measured.contains(camera) {
            let reason = "no valid camera_info has arrived";
            self.aggregator.count(topic, reason);
            self.aggregator.note_as(now.mission, &subject(camera), "calibration", reason);
        }
        self.news()
    }

    /// A time by the clock of stamps, by which frames are known.
    pub(super) const fn stamp_ns(&self, now: Now, stamp_unix_ns: i64) -> i64 {
        match self.stamps {
            Stamps::Clock => stamp_unix_ns,
            Stamps::Arrival => signed(now.mission.0),
        }
    }

    /// The same of a mission time.
    pub(super) const fn stamp_of(&self, now: Now, time_ns: u64) -> i64 {
        match self.stamps {
            Stamps::Clock => {
                now.unix_ns.saturating_add(signed(time_ns).saturating_sub(signed(now.mission.0)))
            }
            Stamps::Arrival => signed(time_ns),
        }
    }
}

/// The subject of diagnostics about a camera's calibration and mounting.
fn subject(camera: &str) -> String {
    format!("mounting of {camera}")
}

/// The subject of diagnostics about changes of a camera's calibration.
fn calibration(camera: &str) -> String {
    format!("calibration of {camera}")
}

/// Mission times are centuries below the bound.
const fn signed(time_ns: u64) -> i64 {
    if time_ns > i64::MAX as u64 { i64::MAX } else { time_ns.cast_signed() }
}
