//! From camera frames to observations.
//!
//! A frame waits until the pose at its time is known, and until every other camera has reached that time too, at most
//! as long as configured ([`waiting`]). An invalid frame (a box with NaN, ten thousand boxes) is ignored as a whole:
//! its detector may have missed anything.

mod false_alarms;
mod fixed;
mod waiting;
mod window;

use std::collections::{BTreeMap, BTreeSet};

use dragnet_search::cell::Cell;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;
use nalgebra::Vector2;

use super::diagnostic::{Fault, Subject};
use super::localization::{At, Localization};
use super::{Assigned, CameraDetections, CameraFrame, PoseEstimate, seconds, stamp};
use crate::camera::{BoxRefusal, Camera, Detections, TooManyBoxes};
use crate::evidence::account::Accounts;
use crate::evidence::finds::{Find, Finds, Vantage};
use crate::evidence::sight::Sight;
use crate::evidence::vista::Vista;
use crate::evidence::{self, EvidenceError, Seen};
use crate::settings::Checked;
use crate::tracker::frame::Frame;
use crate::tracker::pose_error::PoseError;
use crate::tracker::settings::{Settings as TrackerSettings, SettingsError as TrackerError};
use crate::tracker::track::Track;
use crate::tracker::{Surroundings, Tracker};
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plane::{Pose, wrapped_radians};
use false_alarms::FalseAlarms;
use fixed::FixedDetections;
use waiting::{Arrival, Waiting};

/// Walls hide tracks up to so many times the range of a camera.
const FARTHEST: f64 = 2.0;

/// The state of the cameras and the tracker.
#[derive(Clone, Debug)]
pub(super) struct Perception {
    eyes: Vec<Eye>,
    by_name: BTreeMap<String, usize>,
    tracker_settings: TrackerSettings,
    tracker: Tracker,
    /// Maximum difference between a frame's stamp and now.
    max_age_ns: u64,
    waiting: Waiting,
    finds: Finds,
    accounts: Accounts,
    /// What hides objects.
    sight: Sight,
    /// Whether the last observation contained undecided readings.
    has_undecided: bool,
    /// Cells that were last told to be doubted.
    doubted: BTreeSet<Cell>,
    /// Standard deviation of the last published position of the object in each cell, meters.
    published_std_meters: BTreeMap<Cell, f64>,
    /// The assigned detections of the frames that the last event has processed.
    assigned: Vec<Assigned>,
}

#[derive(Clone, Debug)]
struct Eye {
    name: String,
    /// As its table describes it; `None` if each frame brings its camera.
    camera: Option<Camera>,
    /// Standard deviation of a column of the boxes alone, pixels.
    column_std_pixels: f64,
    /// Time of its last valid frame; before the first, when it was expected to begin.
    received_ns: Option<u64>,
    /// The stamp of its last frame.
    stamp_ns: Option<u64>,
    /// Whether the last frame was valid.
    is_good: bool,
    false_alarms: FalseAlarms,
    fixed: FixedDetections,
}

impl Perception {
    pub(super) fn new(settings: &Checked, sight: Sight) -> Result<Self, TrackerError> {
        let described = settings
            .cameras
            .iter()
            .map(|(camera, std_pixels)| (camera.settings().name.clone(), Some(camera.clone()), *std_pixels));
        let measured = settings.measured_cameras.iter();
        let measured = measured.map(|camera| (camera.name().to_owned(), None, camera.column_std_pixels()));
        let eyes: Vec<Eye> = described
            .chain(measured)
            .map(|(name, camera, column_std_pixels)| Eye {
                name,
                camera,
                column_std_pixels,
                received_ns: None,
                stamp_ns: None,
                is_good: false,
                false_alarms: FalseAlarms::new(settings.tracker.false_alarms_per_frame),
                fixed: FixedDetections::default(),
            })
            .collect();
        let by_name = eyes.iter().enumerate().map(|(index, eye)| (eye.name.clone(), index));
        Ok(Self {
            by_name: by_name.collect(),
            waiting: Waiting::new(eyes.len(), settings.fusion_window_ns, settings.camera_timeout_ns),
            eyes,
            tracker_settings: settings.tracker.clone(),
            tracker: Tracker::new(settings.tracker.clone())?,
            max_age_ns: settings.camera_timeout_ns,
            finds: Finds::default(),
            accounts: Accounts::default(),
            sight,
            has_undecided: false,
            doubted: BTreeSet::new(),
            published_std_meters: BTreeMap::new(),
            assigned: Vec::new(),
        })
    }

    pub(super) const fn finds(&self) -> &Finds {
        &self.finds
    }

    /// Replaces the vehicle's own map.
    pub(super) fn set_walls(&mut self, terrain: &Terrain, map: CostMap) {
        self.sight.set_walls(terrain, map);
    }

    pub(super) const fn line_of_sight(&self) -> &LineOfSight {
        self.sight.line_of_sight()
    }

    /// Replaces the cells in which the team has declared objects.
    pub(super) fn set_declared(&mut self, cells: BTreeSet<Cell>) {
        self.finds.set_declared(cells);
    }

    /// The find that was reported in a cell.
    pub(super) fn find(&self, cell: Cell) -> Option<&Find> {
        self.finds.in_cell(cell)
    }

    pub(super) fn tracks(&self) -> &[Track] {
        self.tracker.tracks()
    }

    pub(super) fn assigned(&self) -> &[Assigned] {
        &self.assigned
    }

    pub(super) fn forget_assigned(&mut self) {
        self.assigned.clear();
    }

    /// From the first event on, frames are expected.
    pub(super) fn begin(&mut self, now_ns: u64) {
        for eye in &mut self.eyes {
            eye.received_ns.get_or_insert(now_ns);
        }
        self.waiting.begin(now_ns);
    }

    /// Tracks and frames since the last observation are discarded.
    pub(super) fn restart(&mut self, now_ns: u64) {
        if let Ok(tracker) = Tracker::new(self.tracker_settings.clone()) {
            self.tracker = tracker;
        }
        self.waiting.restart(now_ns);
        self.finds.restart();
        self.accounts = Accounts::default();
        self.has_undecided = false;
        self.doubted.clear();
        self.published_std_meters.clear();
        self.eyes.iter_mut().for_each(|eye| eye.received_ns = Some(now_ns));
    }

    /// Each camera's name, and the time since its last valid frame.
    pub(super) fn silences(&self, now_ns: u64) -> Vec<(String, u64)> {
        let silence = |eye: &Eye| now_ns.saturating_sub(eye.received_ns.unwrap_or(now_ns));
        self.eyes.iter().map(|eye| (eye.name.clone(), silence(eye))).collect()
    }

    /// Whether a camera's last frame was valid.
    pub(super) fn is_good(&self, name: &str) -> bool {
        self.by_name.get(name).is_some_and(|&index| self.eyes[index].is_good)
    }

    /// Adds a frame, to wait for its pose.
    pub(super) fn receive(&mut self, now_ns: u64, frame: CameraFrame) -> Result<(), Fault> {
        let Some(&index) = self.by_name.get(&frame.camera) else {
            let known: Vec<&str> = self.by_name.keys().map(String::as_str).collect();
            let message =
                format!("a frame of a camera that is not in the settings: there are {}", known.join(", "));
            return Err(Fault::new("unknown", &message, &[]));
        };
        let eye = &mut self.eyes[index];
        let before_ns = eye.stamp_ns.replace(frame.time_ns);
        let stamped = stamp::check(now_ns, frame.time_ns, before_ns, self.max_age_ns);
        let found = stamped.and_then(|()| detections(eye.camera.as_ref(), &frame));
        let time_ns = frame.time_ns;
        let arrival = found.map(|found| self.waiting.put(now_ns, index, frame, found));
        let eye = &mut self.eyes[index];
        let result = match arrival {
            Ok(Arrival::Waits | Arrival::Again) => Ok(()),
            Ok(Arrival::Late { by_ns }) => {
                let message = "a frame comes when later ones were taken in already: \
                               a longer tracker.fusion_window_seconds waits for it";
                let numbers = [("time_seconds", seconds(time_ns)), ("late_seconds", seconds(by_ns))];
                Err(Fault::new("late", message, &numbers))
            }
            Ok(Arrival::TooMany) => {
                let numbers = [("waiting_frames", Waiting::MOST as f64)];
                Err(Fault::new("waiting", "frames come, but no pose of their time", &numbers))
            }
            Err(fault) => Err(fault),
        };
        eye.is_good = result.is_ok();
        if result.is_ok() {
            eye.received_ns = Some(now_ns);
        }
        result
    }

    /// Processes all frames whose turn it is; returns the faults of those that are invalid, and what the detections of the
    /// others say of their cameras: more false alarms than in the settings, and some that turn with the camera.
    pub(super) fn process_frames(
        &mut self,
        now_ns: u64,
        localization: &Localization,
        terrain: &Terrain,
        sensor: &Sensor,
    ) -> Vec<(Subject, Option<Fault>)> {
        let mut results = Vec::new();
        while let Some(time_ns) = self.waiting.next_ns(now_ns) {
            let at = localization.at(time_ns);
            if at == At::NotYet {
                break;
            }
            let Some((index, frame, detections)) = self.waiting.take() else { break };
            let result = match at {
                At::Known { fix, interval_ns } => {
                    self.follow(index, &frame, &detections, (&fix, interval_ns), terrain, sensor)
                }
                // Cameras begin before localization does, whose own fault tells that it has not begun.
                At::TooEarly => continue,
                At::NotYet | At::Never => {
                    let numbers = [("time_seconds", seconds(frame.time_ns))];
                    Err(Fault::new(
                        "late",
                        "no pose is known of a frame's time: it is older than all poses, or poses were missing",
                        &numbers,
                    ))
                }
            };
            let eye = &mut self.eyes[index];
            if let Err(fault) = result {
                eye.is_good = false;
                results.push((Subject::Camera(frame.camera), Some(fault)));
            } else {
                results.push((Subject::FalseAlarms(frame.camera.clone()), eye.false_alarms.fault()));
                results.push((Subject::Lens(frame.camera), eye.fixed.fault()));
            }
        }
        results
    }

    fn follow(
        &mut self,
        index: usize,
        frame: &CameraFrame,
        detections: &Detections,
        (fix, interval_ns): (&PoseEstimate, u64),
        terrain: &Terrain,
        sensor: &Sensor,
    ) -> Result<(), Fault> {
        let refused = |error: &dyn std::fmt::Display| Fault::new("refused", &error.to_string(), &[]);
        let eye = &self.eyes[index];
        // The head turns about the vehicle's reference point.
        let heading_radians = wrapped_radians(fix.pose.heading_radians + frame.head_radians);
        let head = Pose { heading_radians, ..fix.pose };
        let pose_error = PoseError {
            heading_std_radians: fix.heading_deviation_radians,
            position_std_meters: fix.deviation_meters,
            correlation_seconds: self.tracker_settings.pose_correlation_seconds.max(seconds(interval_ns)),
        };
        let Some(camera) = camera_of(eye.camera.as_ref(), &frame.detections) else {
            return Err(Fault::new("unmeasured", UNMEASURED, &[]));
        };
        let deviation_radians = camera.bearing_deviation_radians(eye.column_std_pixels);
        let number = u16::try_from(index).unwrap_or(u16::MAX);
        let (name, time_ns) = (&frame.camera, frame.time_ns);
        let frame = Frame::of_camera(
            camera,
            number,
            &head,
            detections,
            time_ns,
            deviation_radians.clamp(1e-6, 0.5),
            pose_error,
        )
        .map_err(|error| refused(&error))?;
        let accounts = &self.accounts;
        let vista = Vista::new(
            self.sight.walls(),
            frame.view.camera().position_meters(),
            FARTHEST * frame.view.max_range_meters(),
        );
        let surroundings = Surroundings {
            unseen: &|point| accounts.missed_at(terrain, point),
            is_hidden: &|point| vista.hides(point),
        };
        let outcome = self.tracker.handle_among(&frame, &surroundings).map_err(|error| refused(&error))?;
        self.assigned.extend(outcome.born.iter().chain(&outcome.seen).map(|&(track, bearing)| Assigned {
            camera: name.clone(),
            time_ns,
            detection: detections.boxes[bearing],
            track,
        }));
        let eye = &mut self.eyes[index];
        eye.fixed.add(head.heading_radians, &detections.bearings_radians);
        eye.false_alarms.add(outcome.born.len(), outcome.confirmed.len());
        let missed = self.tracker_settings.miss_probability;
        self.accounts.add(terrain, self.sight.walls(), sensor, &frame.view, missed);
        Ok(())
    }

    /// Ends an observation: returns its readings from the vehicle's position and, if it has left a cell, the last ones from
    /// there.
    pub(super) fn observation(
        &mut self,
        terrain: &Terrain,
        sensor: &Sensor,
        vehicle: &Pose,
        left: Option<Cell>,
    ) -> Result<(Option<Seen>, Seen), EvidenceError> {
        let here = evidence::standing_cell(terrain, vehicle)?;
        self.place_tracks(terrain, sensor, here);
        // Cells beside the route are not reported: from one that was left long ago nothing can be observed now.
        let left = left.filter(|&left| terrain.grid().manhattan(left, here) <= MOST_LEFT_BEHIND);
        let last = left.and_then(|left| self.farewell(terrain, sensor, left, here));
        let seen = evidence::readings(terrain, sensor, vehicle, &mut self.finds, &mut self.accounts)?;
        self.has_undecided = seen.has_undecided();
        self.sight.note(terrain.grid(), &self.accounts);
        Ok((last, seen))
    }

    /// News of objects while the vehicle still stands in the cell of the last observation, if there is any.
    pub(super) fn observe_again(&mut self, terrain: &Terrain, sensor: &Sensor, from: Cell) -> (Seen, bool) {
        self.place_tracks(terrain, sensor, from);
        let seen = evidence::objects(terrain, sensor, from, &mut self.finds, &mut self.accounts);
        self.sight.note(terrain.grid(), &self.accounts);
        let had_undecided = std::mem::replace(&mut self.has_undecided, seen.has_undecided());
        let is_news = seen.is_evidence() || seen.has_undecided() != had_undecided;
        (seen, is_news)
    }

    /// Cells that it has published to be empty, that may hold an object after all, and that it does not read from this cell; each is
    /// returned once.
    pub(super) fn take_doubted(&mut self, terrain: &Terrain, sensor: &Sensor, from: Cell) -> Vec<Cell> {
        let doubted = evidence::doubted(terrain, sensor, from, &self.finds, &self.accounts);
        let news = doubted.difference(&self.doubted).copied().collect();
        self.doubted = doubted;
        news
    }

    /// Positions of objects that were published in a cell, new or notably better known than when they were last returned, by
    /// cell.
    pub(super) fn take_positions(&mut self, terrain: &Terrain) -> Vec<ObjectPosition> {
        let Self { finds, accounts, published_std_meters: published, .. } = self;
        published.retain(|&cell, _| finds.in_cell(cell).is_some());
        let cells: BTreeSet<Cell> = finds.iter().map(|find| find.cell).collect();
        let news = |cell: Cell| {
            let find = finds.in_cell(cell).filter(|_| evidence::is_published(cell, accounts))?;
            let std_meters = find.std_meters();
            let is_news = published.get(&cell).is_none_or(|&before| std_meters < IMPROVED_SHARE * before);
            let position = find.position().filter(|it| is_news && it.is_near_its_cell(terrain))?;
            published.insert(cell, std_meters);
            Some(position)
        };
        cells.into_iter().filter_map(news).take(ObjectPosition::MAX_IN_OBSERVATION).collect()
    }

    /// The last readings from a cell that the vehicle has left, if an object that it does not see from the next one is
    /// not published yet.
    fn farewell(&mut self, terrain: &Terrain, sensor: &Sensor, from: Cell, to: Cell) -> Option<Seen> {
        let is_out_of_sight = |cell| evidence::is_out_of_sight(terrain, sensor, to, cell);
        let Self { finds, accounts, .. } = self;
        if !evidence::unpublished(finds, accounts).any(is_out_of_sight) {
            return None;
        }
        let seen = evidence::objects(terrain, sensor, from, finds, accounts);
        (!seen.readings.is_empty()).then_some(seen)
    }

    /// Positions of objects that were found outside of the search area since the last call, meters east and north.
    pub(super) fn take_outside(&mut self) -> &[Vector2<f64>] {
        self.finds.take_outside()
    }

    fn place_tracks(&mut self, terrain: &Terrain, sensor: &Sensor, from: Cell) {
        let now_ns = self.tracker.latest_ns().unwrap_or(0);
        self.finds.update(self.tracker.tracks(), &Vantage { now_ns, terrain, sensor, from });
    }
}

/// Most cells between the one that a vehicle has left and its own for which it has just left it: a step across a corner.
const MOST_LEFT_BEHIND: u32 = 2;
/// Share of the published standard deviation of an object's position below which it is published again.
const IMPROVED_SHARE: f64 = 2.0 / 3.0;
/// The message when a frame's camera is described nowhere.
const UNMEASURED: &str = "a frame without its camera, whose lens or mounting is not in the settings";

/// The camera of a frame: its own, or that of the settings.
fn camera_of<'a>(described: Option<&'a Camera>, detections: &'a CameraDetections) -> Option<&'a Camera> {
    match detections {
        CameraDetections::Measured { camera, .. } => Some(camera.camera()),
        CameraDetections::Boxes(_) | CameraDetections::Bearings(_) => described,
    }
}

/// The bearings of a frame's boxes, if all of them are valid.
fn detections(described: Option<&Camera>, frame: &CameraFrame) -> Result<Detections, Fault> {
    if !frame.head_radians.is_finite() {
        return Err(Fault::new("no_number", "the head's angle is no number", &[]));
    }
    match &frame.detections {
        CameraDetections::Boxes(boxes) => {
            let Some(camera) = described else { return Err(Fault::new("unmeasured", UNMEASURED, &[])) };
            valid(camera.detections(boxes), boxes.len())
        }
        CameraDetections::Measured { camera, boxes } => valid(camera.detections(boxes), boxes.len()),
        CameraDetections::Bearings(bearings) if bearings.len() > Camera::MAX_BOXES => {
            let message = format!("{} bearings in one image: at most {}", bearings.len(), Camera::MAX_BOXES);
            Err(Fault::new("too_many", &message, &[("bearings", bearings.len() as f64)]))
        }
        CameraDetections::Bearings(bearings) => {
            if let Some(number) = bearings.iter().position(|bearing| !bearing.is_finite()) {
                let message = format!("bearing {number} is no number");
                return Err(Fault::new("no_number", &message, &[("bearing", number as f64)]));
            }
            Ok(Detections::of_bearings(bearings.clone()))
        }
    }
}

/// The detections of so many boxes, if all of them are valid.
fn valid(detections: Result<Detections, TooManyBoxes>, boxes: usize) -> Result<Detections, Fault> {
    let detections =
        detections.map_err(|error| Fault::new("too_many", &error.to_string(), &[("boxes", boxes as f64)]))?;
    let is_bad = |&&(_, why): &&(usize, BoxRefusal)| why != BoxRefusal::SameColumn;
    if let Some(&(number, why)) = detections.refused.iter().find(is_bad) {
        let message = format!("box {number} of {boxes} cannot be: {why}");
        return Err(Fault::new("no_box", &message, &[("box", number as f64)]));
    }
    Ok(detections)
}
