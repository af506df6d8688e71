//! From frames of the cameras to looks.
//!
//! A frame waits until the pose at its time is known. One that holds something that cannot be (a box that is
//! no number, ten thousand boxes) is left out as a whole: what its detector missed meanwhile, nobody knows.

use std::collections::{BTreeMap, VecDeque};

use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

use super::diagnostic::Fault;
use super::localization::{At, Localization};
use super::{CameraFrame, Fix, Sights, seconds, stamp};
use crate::camera::{BoxRefusal, Camera, Detections};
use crate::evidence::coverage::Coverage;
use crate::evidence::{self, EvidenceError, Look, Seen};
use crate::plane::{Pose, wrapped_radians};
use crate::settings::Checked;
use crate::tracker::Tracker;
use crate::tracker::frame::Frame;
use crate::tracker::settings::{Settings as TrackerSettings, SettingsError as TrackerError};
use crate::tracker::track::Track;

/// So many frames may wait for a pose.
const MOST_WAITING: usize = 256;
/// At this range a place that is not known exactly turns a bearing by as much as it is off, metres: about a
/// cell. Nearer things are seen from many sides anyway.
const LEVER_METERS: f64 = 15.0;

/// What the cameras have shown.
#[derive(Clone, Debug)]
pub(super) struct Perception {
    eyes: Vec<Eye>,
    by_name: BTreeMap<String, usize>,
    tracker_settings: TrackerSettings,
    tracker: Tracker,
    /// A frame that is stamped farther from now is none of now.
    most_age_ns: u64,
    waiting: VecDeque<(usize, CameraFrame, Detections)>,
    coverage: Coverage,
    /// When the last look ended: the time of its last frame, and one.
    since_ns: u64,
}

#[derive(Clone, Debug)]
struct Eye {
    camera: Camera,
    /// Standard deviation of a bearing for that of the boxes alone, radians.
    deviation_radians: f64,
    /// When it last gave a frame that could be used; before the first, when it was expected to begin.
    heard_ns: Option<u64>,
    /// The time of its last frame.
    stamp_ns: Option<u64>,
    /// Whether the last frame was good.
    is_good: bool,
}

impl Perception {
    pub(super) fn new(settings: &Checked) -> Result<Self, TrackerError> {
        let eyes: Vec<Eye> = settings
            .cameras
            .iter()
            .map(|(camera, column_deviation_pixels)| Eye {
                deviation_radians: camera.bearing_deviation_radians(*column_deviation_pixels),
                camera: camera.clone(),
                heard_ns: None,
                stamp_ns: None,
                is_good: false,
            })
            .collect();
        let by_name = eyes.iter().enumerate().map(|(index, eye)| (eye.camera.settings().name.clone(), index));
        Ok(Self {
            by_name: by_name.collect(),
            eyes,
            tracker_settings: settings.tracker.clone(),
            tracker: Tracker::new(settings.tracker.clone())?,
            most_age_ns: settings.camera_silence_ns,
            waiting: VecDeque::new(),
            coverage: Coverage::default(),
            since_ns: 0,
        })
    }

    pub(super) fn tracks(&self) -> &[Track] {
        self.tracker.tracks()
    }

    /// From the first event on, frames are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        for eye in &mut self.eyes {
            eye.heard_ns.get_or_insert(now_ns);
        }
    }

    /// Where things were said to be means nothing any more, and neither does what was seen since the last
    /// look.
    pub(super) fn restart(&mut self, now_ns: u64) {
        if let Ok(tracker) = Tracker::new(self.tracker_settings.clone()) {
            self.tracker = tracker;
        }
        self.waiting.clear();
        self.coverage = Coverage::default();
        self.since_ns = 0;
        self.eyes.iter_mut().for_each(|eye| eye.heard_ns = Some(now_ns));
    }

    /// Each camera's name, and how long ago it gave a frame that could be used.
    pub(super) fn silences(&self, now_ns: u64) -> Vec<(String, u64)> {
        let silence = |eye: &Eye| now_ns.saturating_sub(eye.heard_ns.unwrap_or(now_ns));
        self.eyes.iter().map(|eye| (eye.camera.settings().name.clone(), silence(eye))).collect()
    }

    /// Whether a camera's last frame was good.
    pub(super) fn is_good(&self, name: &str) -> bool {
        self.by_name.get(name).is_some_and(|&index| self.eyes[index].is_good)
    }

    /// Takes in a frame, to wait for its pose.
    pub(super) fn receive(&mut self, now_ns: u64, frame: CameraFrame) -> Result<(), Fault> {
        let Some(&index) = self.by_name.get(&frame.camera) else {
            let known: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
            let message =
                format!("a frame of a camera that is not in the settings: there are {}", known.join(", "));
            return Err(Fault::new("stranger", &message, &[]));
        };
        let eye = &mut self.eyes[index];
        let before_ns = eye.stamp_ns.replace(frame.time_ns);
        let stamped = stamp::check(now_ns, frame.time_ns, before_ns, self.most_age_ns);
        let detections = stamped.and_then(|()| detections(&eye.camera, &frame));
        eye.is_good = detections.is_ok();
        let detections = detections?;
        eye.heard_ns = Some(now_ns);
        let place = self.waiting.partition_point(|(_, waiting, _)| waiting.time_ns <= frame.time_ns);
        self.waiting.insert(place, (index, frame, detections));
        if self.waiting.len() > MOST_WAITING {
            self.waiting.pop_front();
            let numbers = [("waiting_frames", MOST_WAITING as f64)];
            return Err(Fault::new("waiting", "frames come, but no pose of their time", &numbers));
        }
        Ok(())
    }

    /// Follows things through all frames whose poses are known; what became of those that could not be used.
    pub(super) fn look_out(
        &mut self,
        localization: &Localization,
        terrain: &Terrain,
        sensor: &Sensor,
    ) -> Vec<(String, Result<(), Fault>)> {
        let mut results = Vec::new();
        while let Some((index, frame, detections)) = self.waiting.pop_front() {
            let fix = match localization.at(frame.time_ns) {
                At::Known(fix) => fix,
                At::NotYet => {
                    self.waiting.push_front((index, frame, detections));
                    break;
                }
                At::Never => {
                    let numbers = [("time_seconds", seconds(frame.time_ns))];
                    let fault = Fault::new("late", "a frame older than all poses that are known", &numbers);
                    results.push((frame.camera, Err(fault)));
                    continue;
                }
            };
            let result = self.follow(index, &frame, &detections, &fix, terrain, sensor);
            if result.is_err() {
                self.eyes[index].is_good = false;
                results.push((frame.camera, result));
            }
        }
        results
    }

    fn follow(
        &mut self,
        index: usize,
        frame: &CameraFrame,
        detections: &Detections,
        fix: &Fix,
        terrain: &Terrain,
        sensor: &Sensor,
    ) -> Result<(), Fault> {
        let refused = |error: &dyn std::fmt::Display| Fault::new("refused", &error.to_string(), &[]);
        let eye = &self.eyes[index];
        // The head turns about the vehicle's reference point.
        let heading_radians = wrapped_radians(fix.pose.heading_radians + frame.head_radians);
        let head = Pose { heading_radians, ..fix.pose };
        let lever = fix.deviation_meters.atan2(LEVER_METERS);
        let deviation = eye.deviation_radians.hypot(fix.heading_deviation_radians).hypot(lever);
        let number = u16::try_from(index).unwrap_or(u16::MAX);
        let frame =
            Frame::of_camera(&eye.camera, number, &head, detections, frame.time_ns, deviation.min(0.5))
                .map_err(|error| refused(&error))?;
        self.tracker.handle(&frame).map_err(|error| refused(&error))?;
        self.coverage.add(terrain, sensor, &frame.view);
        Ok(())
    }

    /// Ends a look: its readings from where the vehicle stands.
    pub(super) fn look(
        &mut self,
        terrain: &Terrain,
        sensor: &Sensor,
        vehicle: &Pose,
    ) -> Result<Seen, EvidenceError> {
        let look = Look {
            vehicle: *vehicle,
            coverage: &self.coverage,
            fewest_sights: self.tracker_settings.confirming_hits,
            tracks: self.tracker.tracks(),
            since_ns: self.since_ns,
        };
        let seen = evidence::readings(terrain, sensor, &look)?;
        self.coverage = Coverage::default();
        self.since_ns = self.tracker.latest_ns().map_or(0, |latest_ns| latest_ns.saturating_add(1));
        Ok(seen)
    }
}

/// What a frame's boxes or bearings say, if all of them can be.
fn detections(camera: &Camera, frame: &CameraFrame) -> Result<Detections, Fault> {
    if !frame.head_radians.is_finite() {
        return Err(Fault::new("no_number", "the head's angle is no number", &[]));
    }
    match &frame.sights {
        Sights::Boxes(boxes) => {
            let detections = camera.detections(boxes).map_err(|error| {
                Fault::new("too_many", &error.to_string(), &[("boxes", boxes.len() as f64)])
            })?;
            let is_bad = |&&(_, why): &&(usize, BoxRefusal)| why != BoxRefusal::SameColumn;
            if let Some(&(number, why)) = detections.refused.iter().find(is_bad) {
                let message = format!("box {number} of {} cannot be: {why:?}", boxes.len());
                return Err(Fault::new("no_box", &message, &[("box", number as f64)]));
            }
            Ok(detections)
        }
        Sights::Bearings(bearings) if bearings.len() > Camera::MAX_BOXES => {
            let message = format!("{} bearings in one image: at most {}", bearings.len(), Camera::MAX_BOXES);
            Err(Fault::new("too_many", &message, &[("bearings", bearings.len() as f64)]))
        }
        Sights::Bearings(bearings) => {
            if let Some(number) = bearings.iter().position(|bearing| !bearing.is_finite()) {
                let message = format!("bearing {number} is no number");
                return Err(Fault::new("no_number", &message, &[("bearing", number as f64)]));
            }
            Ok(Detections { bearings_radians: bearings.clone(), refused: Vec::new() })
        }
    }
}
