//! A robot's vehicle in the field: messages of its network go to its pilot ([`dragnet_vehicle::pilot`]); the pilot's
//! observations go to the agent, and its paths and goals to the network. The agent receives cells and readings only.
//!
//! A vehicle is driven by the caller's time, like a state machine. [`serve`] drives it on its network by the wall
//! clock, [`crate::dry_run`] by the clock of a recording.

pub mod detector;
mod diagnostics;
mod embodied;
pub(crate) mod frames;
pub(crate) mod ground;
mod interlocks;
pub(crate) mod measured;
mod network;
mod objects;
mod pictures;
pub(crate) mod place;
pub mod serve;
mod topics;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use dragnet_lattice::plane::Pose;
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::Event as AgentEvent;
use dragnet_ros2::input::{DetectedBox, Detections, GoalStatus, Image, Occupancy};
use dragnet_ros2::name::TopicName;
use dragnet_ros2::navigation_goal::{NavigationGoal, Progress};
use dragnet_ros2::output::{Diagnostic, Output};
use dragnet_ros2::viewer::Viewer;
use dragnet_scenario::Scenario;
use dragnet_scenario::map_file::MapOrigin;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Reading;
use dragnet_search::object_position::ObjectPositions;
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::camera::{Camera, DetectionBox};
use dragnet_vehicle::pilot::diagnostic::{Diagnostic as PilotDiagnostic, NO_POSE};
use dragnet_vehicle::pilot::{
    Action, CameraDetections, CameraFrame, Event, InputSource, Pilot, PoseEstimate, Report as DriveReport,
};

use crate::ros::incoming::Incoming;
use crate::ros::settings::{Checked, Localization, Stamps};
use detector::{DetectionRequest, Seen};
use diagnostics::DiagnosticsAggregator;
use frames::Frames;
use interlocks::Interlocks;
use measured::MeasuredCameras;
use pictures::Pictures;
use place::{Located, Moment, Places, planar};
use topics::Topics;

pub(crate) use diagnostics::RefusedInput;
pub use embodied::{AgentOutputs, Embodied};
pub(crate) use pictures::FindPicture;

/// Period of the pilot's tick, which bounds how soon a timeout is noticed.
pub(crate) const TICK: Duration = Duration::from_millis(100);
/// Period in which belief and diagnostics are published.
pub(crate) const SHOW: Duration = Duration::from_secs(1);
/// Number of periods after which an unchanged belief is published again: it may have been lost, and behind a bridge
/// late subscribers do not receive it.
const SHOW_AGAIN: u32 = 5;
/// Time after which a goal that was not accepted, or a path that is not driven, is published again.
const PATIENCE: Duration = Duration::from_secs(5);
/// Distance up to which a vehicle counts as standing, meters: the noise of localization.
const STILL_METERS: f64 = 0.25;
/// Distance from a path's end at which it may have been driven.
const NEAR_METERS: f64 = 1.0;
/// Subject of diagnostics about maps that the pilot never receives; the pilot reports others itself.
const MAP_FRAME: &str = "map frame";

/// The time by the mission's clock and by the computer's, which may be set meanwhile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    pub(crate) mission: MissionTime,
    pub(crate) unix_ns: i64,
}

/// The effects of a vehicle, in order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Effect {
    /// For the agent: the vehicle's cell, and the readings since the last observation.
    Sensed { cell: Cell, readings: Vec<Reading> },
    /// For the agent: another event of its vehicle.
    Report(AgentEvent<Message>),
    /// For the vehicle's network.
    Publish(Output),
    /// For this program's own detector, if any; its detections come back through [`Vehicle::see`].
    Detect(DetectionRequest),
    /// For the operator: a picture of a find.
    Picture(FindPicture),
    /// For the log: a fault begins or ends.
    Tell(Diagnostic),
}

/// A vehicle.
pub(crate) struct Vehicle {
    pilot: Pilot,
    places: Places,
    frames: Frames,
    measured: MeasuredCameras,
    interlocks: Interlocks,
    terrain: Arc<Terrain>,
    detection_threshold: f64,
    stamps: Stamps,
    aggregator: DiagnosticsAggregator,
    topics: Topics,
    /// Number of periods since the belief was last published.
    unchanged: u32,
    /// The last pose by localization.
    located: Option<Pose>,
    /// The last goals of Nav2.
    goals: Vec<GoalStatus>,
    /// The goal that was sent to Nav2, and when.
    sent_goal: Option<(NavigationGoal, Pose, MissionTime)>,
    drive: Option<Drive>,
    pictures: Pictures,
}

/// A path that the vehicle is to drive.
struct Drive {
    poses: Vec<Pose>,
    /// Its last pose after progress, and when.
    stood: (Pose, MissionTime),
}

impl Vehicle {
    pub(crate) fn new(pilot: Pilot, ros: &Checked, scenario: &Scenario) -> Self {
        Self {
            frames: Frames::new(ros),
            measured: MeasuredCameras::new(pilot.measured_cameras()),
            interlocks: Interlocks::new(ros),
            pilot,
            places: Places::new(
                ros.localization(),
                ros.uncorrected,
                ros.unstated,
                scenario.origin(),
                scenario.georeference().copied(),
            ),
            terrain: Arc::new(scenario.terrain().clone()),
            detection_threshold: scenario.mission().detection_threshold,
            stamps: ros.stamps(),
            aggregator: DiagnosticsAggregator::default(),
            topics: Topics::new(ros),
            unchanged: 0,
            located: None,
            goals: Vec::new(),
            sent_goal: None,
            drive: None,
            pictures: Pictures::new(ros.cameras_with_pictures()),
        }
    }

    /// A message of the network arrives on a topic.
    pub(crate) fn receive(&mut self, now: Now, topic: &TopicName, received: Incoming) -> Vec<Effect> {
        self.topics.on_message(topic, &received);
        if let Incoming::Rejected { reason, .. } = received {
            self.aggregator.refuse(now.mission, topic, &reason);
            return self.news();
        }
        self.aggregator.received(now.mission, topic);
        let located = match received {
            Incoming::Odometry(odometry) => {
                Ok(self.places.odometry(self.moment(now, odometry.place.stamp_unix_ns), &odometry))
            }
            Incoming::Pose(pose) => self.places.pose(self.moment(now, pose.stamp_unix_ns), &pose),
            Incoming::Fix(fix) => self.places.fix(self.moment(now, fix.stamp_unix_ns), &fix),
            Incoming::Map(map) => return self.receive_map(now, topic, &map),
            Incoming::Detections { camera, detections } => {
                let Detections { stamp_unix_ns, frame, boxes } = detections;
                let taken = Taken {
                    time_ns: self.time_ns(now, stamp_unix_ns),
                    stamp_ns: self.stamp_ns(now, stamp_unix_ns),
                    frame,
                };
                let size = self.size_pixels(&camera);
                self.pictures.take_boxes(&camera, taken.time_ns, stamp_unix_ns, &boxes, size);
                return self.frame(now, &camera, taken, &boxes);
            }
            Incoming::Transforms(transforms) => return self.receive_transforms(now, topic, transforms),
            Incoming::StaticTransforms(transforms) => {
                return self.receive_static_transforms(now, topic, transforms);
            }
            Incoming::CameraInfo { camera, info } => return self.receive_calibration(now, &camera, &info),
            Incoming::Stop(is_stopped) => return self.receive_stop(now, is_stopped),
            Incoming::Battery(battery) => return self.receive_battery(now, topic, &battery),
            Incoming::Image { camera, image } => return self.receive_image(now, topic, camera, image),
            Incoming::Goals(goals) => return self.receive_goals(now, goals),
            Incoming::Rejected { .. } => return Vec::new(),
        };
        match located {
            Ok(located) => located.map(|located| self.locate(now, &located)).unwrap_or_default(),
            Err(reason) => {
                self.aggregator.refuse(now.mission, topic, &reason);
                self.news()
            }
        }
    }

    /// The detector has processed an image.
    pub(crate) fn see(&mut self, now: Now, seen: Seen) -> Vec<Effect> {
        let subject = format!("detector, {}", seen.camera);
        match seen.found {
            Ok(boxes) => {
                self.aggregator.well(now.mission, &subject);
                let taken = Taken {
                    time_ns: seen.time_ns,
                    stamp_ns: self.stamp_of(now, seen.time_ns),
                    frame: String::new(),
                };
                self.pictures.put(&seen.camera, taken.time_ns, seen.crops);
                self.frame(now, &seen.camera, taken, &boxes)
            }
            Err(reason) => {
                self.refuse(&InputSource::Camera(seen.camera.to_string()), &reason);
                self.aggregator.note(now.mission, &subject, &reason);
                self.news()
            }
        }
    }

    /// The agent has a new route, or knows of other closed cells.
    pub(crate) fn heed(&mut self, now: Now, event: Event) -> Vec<Effect> {
        self.tell(now, event)
    }

    /// To be called every [`TICK`].
    pub(crate) fn tick(&mut self, now: Now) -> Vec<Effect> {
        let mut effects = self.insist(now);
        effects.extend(self.process_measured(now));
        effects.extend(self.tell_stop(now));
        self.aggregator.settle(now.mission);
        effects.extend(self.news());
        effects.extend(self.tell(now, Event::Tick));
        effects
    }

    /// The tracks, and the belief if it has changed or was not published for a while: to be called every [`SHOW`].
    /// The pilot gets the declared cells of a changed belief.
    pub(crate) fn show(
        &mut self,
        now: Now,
        belief: &Belief,
        positions: &ObjectPositions,
        has_changed: bool,
    ) -> Vec<Effect> {
        self.tell_images(now);
        let mut shown = vec![Output::Diagnostics(self.aggregator.all()), Output::Tracks(self.tracks())];
        let mut news = None;
        self.unchanged += 1;
        if has_changed || self.unchanged >= SHOW_AGAIN {
            self.unchanged = 0;
            let start_unix_ns = now.unix_ns.saturating_sub_unsigned(now.mission.0);
            // The map's pose in the robot's frame is known to `places`.
            let viewer = Viewer::new(&self.terrain, MapOrigin::default(), start_unix_ns);
            let drawn = viewer.belief(&belief.probabilities(), now.mission);
            shown.push(Output::Belief(drawn, planar(&self.places.in_frame(&Pose::default()))));
            let declared: BTreeSet<Cell> = self.found(belief).collect();
            shown.push(Output::Objects(self.objects(belief, positions, &declared)));
            news = has_changed.then_some(Event::Declared(declared));
        }
        let mut effects: Vec<Effect> = shown.into_iter().map(Effect::Publish).collect();
        effects.extend(self.pictures.news(&self.pilot).into_iter().map(Effect::Picture));
        if let Some(event) = news {
            effects.extend(self.tell(now, event));
        }
        effects
    }

    /// Stops the vehicle. Nav2 gets the robot's own pose as goal, which is how a goal is canceled by topics.
    pub(crate) fn halt(&mut self) -> Vec<Effect> {
        self.drive = None;
        let goal = self.sent_goal.take().and(self.located).map(|here| Output::Goal(self.in_frame(&here)));
        goal.into_iter().chain([Output::Path(Vec::new())]).map(Effect::Publish).collect()
    }

    fn tell(&mut self, now: Now, event: Event) -> Vec<Effect> {
        let actions = self.pilot.handle(now.mission.0, event);
        self.pictures.follow(&self.pilot);
        actions.into_iter().flat_map(|action| self.act(now, action)).collect()
    }

    fn news(&mut self) -> Vec<Effect> {
        self.aggregator.take_news().into_iter().map(Effect::Tell).collect()
    }

    /// Mission time of a stamp: as long ago as the stamp is by the computer's clock.
    fn time_ns(&self, now: Now, stamp_unix_ns: i64) -> u64 {
        match self.stamps {
            Stamps::Arrival => now.mission.0,
            Stamps::Clock => now.mission.0.saturating_add_signed(stamp_unix_ns.saturating_sub(now.unix_ns)),
        }
    }

    fn moment(&self, now: Now, stamp_unix_ns: i64) -> Moment {
        let age = match self.stamps {
            Stamps::Arrival => Duration::ZERO,
            Stamps::Clock => {
                Duration::from_nanos(u64::try_from(now.unix_ns.saturating_sub(stamp_unix_ns)).unwrap_or(0))
            }
        };
        Moment { received_ns: now.mission.0, time_ns: self.time_ns(now, stamp_unix_ns), age }
    }

    fn locate(&mut self, now: Now, located: &Located) -> Vec<Effect> {
        self.located = Some(located.pose);
        let fix = PoseEstimate {
            time_ns: located.time_ns,
            pose: located.pose,
            deviation_meters: located.deviation_meters,
            heading_deviation_radians: located.heading_deviation_radians,
        };
        self.tell(now, Event::Pose(fix))
    }

    fn frame(&mut self, now: Now, camera: &Arc<str>, taken: Taken, boxes: &[DetectedBox]) -> Vec<Effect> {
        let boxes: Vec<DetectionBox> = boxes.iter().map(of_box).collect();
        if self.measured.contains(camera) {
            return self.measure(now, camera, taken, boxes);
        }
        let Taken { time_ns, .. } = taken;
        let (camera, detections) = (camera.to_string(), CameraDetections::Boxes(boxes));
        self.tell(now, Event::Frame(CameraFrame { time_ns, camera, head_radians: 0.0, detections }))
    }

    /// A camera's finds have no pictures if its images do not come, or have other stamps than its boxes.
    fn tell_images(&mut self, now: Now) {
        let names: Vec<String> = self.pilot.cameras().map(str::to_owned).collect();
        for camera in names.iter().filter(|camera| self.pictures.are_for(camera)) {
            let subject = format!("pictures, {camera}");
            if self.pictures.lack(camera) {
                let message =
                    "no image comes with the stamp of its boxes, so that its finds have no pictures";
                self.aggregator.note(now.mission, &subject, message);
            } else {
                self.aggregator.well(now.mission, &subject);
            }
        }
    }

    /// Columns and rows of the images that a camera's boxes refer to, if they are known.
    fn size_pixels(&self, camera: &str) -> Option<[u32; 2]> {
        let described = self.pilot.camera(camera).map(Camera::settings);
        let described = described.map(|settings| [settings.width_pixels, settings.height_pixels]);
        described.or_else(|| self.measured.size_pixels(camera))
    }

    /// A detector's boxes require images of the size in the camera's settings.
    fn receive_image(&mut self, now: Now, topic: &TopicName, camera: Arc<str>, image: Image) -> Vec<Effect> {
        if self.pictures.are_for(&camera) {
            self.pictures.take_image(camera, image);
            return Vec::new();
        }
        let Some([width, height]) = self.size_pixels(&camera) else {
            return self.tell_uncalibrated(now, topic, &camera);
        };
        let subject = format!("image, {camera}");
        if (image.width_pixels, image.height_pixels) != (width, height) {
            let found = format!("an image of {} x {} pixels", image.width_pixels, image.height_pixels);
            let allowed = format!("allowed is {width} x {height}, as in vehicle.cameras or camera_info");
            let reason = format!("{found}; {allowed}");
            self.aggregator.count(topic, &reason);
            self.aggregator.note(now.mission, &subject, &reason);
            return self.news();
        }
        self.aggregator.well(now.mission, &subject);
        let time_ns = self.time_ns(now, image.stamp_unix_ns);
        vec![Effect::Detect(DetectionRequest { camera, time_ns, image })]
    }

    fn receive_map(&mut self, now: Now, topic: &TopicName, map: &Occupancy) -> Vec<Effect> {
        match ground::cost_map(self.places.map(), map) {
            Ok(map) => {
                self.aggregator.well(now.mission, MAP_FRAME);
                self.tell(now, Event::Map(map))
            }
            Err(reason) => {
                self.aggregator.count(topic, &reason);
                self.aggregator.note(now.mission, MAP_FRAME, &reason);
                self.news()
            }
        }
    }

    fn receive_goals(&mut self, now: Now, goals: Vec<GoalStatus>) -> Vec<Effect> {
        self.goals = goals;
        let Some((sent_goal, ..)) = &mut self.sent_goal else { return Vec::new() };
        sent_goal.follow(&self.goals);
        let report = match sent_goal.progress() {
            Progress::Unanswered => return Vec::new(),
            Progress::Underway => {
                self.aggregator.well(now.mission, "goal");
                return self.news();
            }
            Progress::Reached => DriveReport::Arrived,
            Progress::Failed => DriveReport::Failed("the navigation gave up".to_owned()),
            Progress::Canceled => DriveReport::Failed("it was canceled".to_owned()),
            Progress::Replaced => DriveReport::Failed("another goal replaced it".to_owned()),
        };
        self.sent_goal = None;
        self.tell(now, Event::Drive(report))
    }

    fn act(&mut self, now: Now, action: Action) -> Vec<Effect> {
        match action {
            Action::Sensed { cell, readings } => vec![Effect::Sensed { cell, readings }],
            Action::RouteFailed { blocked } => vec![Effect::Report(AgentEvent::RouteFailed { blocked })],
            Action::Doubted { cells } => vec![Effect::Report(AgentEvent::Doubted { cells })],
            Action::LineOfSight(seen) => vec![Effect::Report(AgentEvent::LineOfSight(seen))],
            Action::Located(positions) => vec![Effect::Report(AgentEvent::Located(positions))],
            Action::Drive(plan) => {
                let path = self.path(&plan.poses);
                self.drive = self.located.map(|here| Drive { poses: plan.poses, stood: (here, now.mission) });
                vec![path]
            }
            Action::Go(pose) => self.go(now, pose),
            Action::Hold => self.halt(),
            Action::Tell(diagnostic) => {
                let diagnostic = self.explained(now, diagnostic);
                self.aggregator.pin(&diagnostic);
                let mut effects = self.news();
                effects.push(Effect::Publish(Output::Diagnostics(self.aggregator.all())));
                effects
            }
            Action::Refuse(source, reason) => {
                self.refuse(&source, &reason);
                Vec::new()
            }
        }
    }

    fn refuse(&mut self, source: &InputSource, reason: &str) {
        if let Some(topic) = self.topics.of(source) {
            self.aggregator.count(topic, reason);
        }
    }

    /// If there is no pose, the network's state gives the reason.
    fn explained(&self, now: Now, pilot_diagnostic: PilotDiagnostic) -> PilotDiagnostic {
        if pilot_diagnostic.message != NO_POSE {
            return pilot_diagnostic;
        }
        let missing = match self.places.source() {
            Localization::Tf => Some(self.frames.why_no_pose(self.stamp_of(now, now.mission.0))),
            _ => self.places.missing().map(str::to_owned),
        };
        let why = self.topics.why_no_pose(missing.as_deref(), self.aggregator.refused());
        PilotDiagnostic { message: format!("{NO_POSE}: {why}"), ..pilot_diagnostic }
    }

    /// Rejected messages, by topic.
    pub(crate) const fn refused(&self) -> &BTreeMap<TopicName, RefusedInput> {
        self.aggregator.refused()
    }

    fn go(&mut self, now: Now, pose: Pose) -> Vec<Effect> {
        self.sent_goal = Some((NavigationGoal::begin(&self.goals), pose, now.mission));
        vec![Effect::Publish(Output::Goal(self.in_frame(&pose)))]
    }

    fn path(&self, poses: &[Pose]) -> Effect {
        Effect::Publish(Output::Path(poses.iter().map(|pose| self.in_frame(pose)).collect()))
    }

    /// Publishes a goal again that was not accepted, or the rest of a path that is not driven. The subscriber may have
    /// joined late, or restarted.
    fn insist(&mut self, now: Now) -> Vec<Effect> {
        let again = match &self.sent_goal {
            Some((sent_goal, pose, reported))
                if sent_goal.progress() == Progress::Unanswered
                    && now.mission.since(*reported) > PATIENCE =>
            {
                let pose = *pose;
                self.aggregator.note(now.mission, "goal", "the goal was not accepted; it is published again");
                self.go(now, pose)
            }
            _ => self.path_of_a_resting_robot(now),
        };
        let mut effects = self.news();
        effects.extend(again);
        effects
    }

    fn path_of_a_resting_robot(&mut self, now: Now) -> Vec<Effect> {
        let (Some(drive), Some(here)) = (&mut self.drive, self.located) else { return Vec::new() };
        let meters_from = |pose: &Pose| (pose.position_meters() - here.position_meters()).norm();
        let (stood, since) = drive.stood;
        if meters_from(&stood) > STILL_METERS {
            drive.stood = (here, now.mission);
            self.aggregator.well(now.mission, "path");
            return Vec::new();
        }
        if now.mission.since(since) <= PATIENCE {
            return Vec::new();
        }
        drive.stood.1 = now.mission;
        let nearest = drive
            .poses
            .iter()
            .enumerate()
            .min_by(|(_, one), (_, other)| meters_from(one).total_cmp(&meters_from(other)));
        let rest = drive.poses[nearest.map_or(0, |(place, _)| place)..].to_vec();
        if rest.last().is_none_or(|end| meters_from(end) <= NEAR_METERS) {
            // It waits for the next one, or has ended this one before its last cell: the pilot knows.
            self.drive = None;
            return self.tell(now, Event::Drive(DriveReport::Arrived));
        }
        let message = "the vehicle does not drive its path; the rest of it is published again";
        self.aggregator.note(now.mission, "path", message);
        vec![self.path(&rest)]
    }

    /// A pose on the search's map, converted to the frame of the vehicle's network.
    fn in_frame(&self, pose: &Pose) -> dragnet_ros2::input::PlanarPose {
        planar(&self.places.in_frame(pose))
    }
}

/// When an image was taken, and the frame that it names.
struct Taken {
    /// Nanoseconds of mission time.
    time_ns: u64,
    /// The same by the clock of stamps.
    stamp_ns: i64,
    /// May be empty.
    frame: String,
}

fn of_box(found: &DetectedBox) -> DetectionBox {
    let DetectedBox { left, top, right, bottom, .. } = *found;
    DetectionBox { left, top, right, bottom }
}

#[cfg(test)]
mod tests;
