//! A robot's vehicle in the field: what its network says goes to its pilot ([`dragnet_vehicle::pilot`]), what the pilot
//! says goes to the robot's mind or back to the network. Its mind hears of cells and looks alone, and knows nothing of
//! cameras and motors.
//!
//! A vehicle is told the time like all minds, and does nothing by itself. [`serve`] drives it on its network by the wall
//! clock, [`crate::dry_run`] by the clock of a recording.

pub mod detector;
mod diagnostics;
mod embodied;
pub(crate) mod ground;
mod objects;
pub(crate) mod place;
pub mod serve;
mod topics;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::{DetectedBox, GoalStatus, Image, Occupancy};
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
use dragnet_search::terrain::Terrain;
use dragnet_vehicle::camera::{Camera, DetectionBox};
use dragnet_vehicle::pilot::diagnostic::{Diagnostic as Said, NO_POSE};
use dragnet_vehicle::pilot::{
    Action, CameraDetections, CameraFrame, Event, InputSource, Pilot, PoseEstimate, Report as DriveReport,
};

use crate::ros::incoming::Incoming;
use crate::ros::settings::{Checked, Stamps};
use detector::{Look, Seen};
use diagnostics::DiagnosticsAggregator;
use place::{Located, Moment, Places, planar};
use topics::Topics;

pub(crate) use diagnostics::RefusedInput;
pub use embodied::{AgentOutputs, Embodied};

/// How often the pilot hears that time passes: silence is noticed so soon.
pub(crate) const TICK: Duration = Duration::from_millis(100);
/// How often people are shown what the robot believes, and what is wrong with it, at most.
pub(crate) const SHOW: Duration = Duration::from_secs(1);
/// A belief that does not change is shown again after so many times: on its way it may have been lost, and behind a bridge
/// nobody asks for what was said before.
const SHOW_AGAIN: u32 = 5;
/// A goal that nobody has taken up, or a path that nobody drives, is told again after so long.
const PATIENCE: Duration = Duration::from_secs(5);
/// Who has come no farther than this stands, meters: what localization wanders by.
const STILL_METERS: f64 = 0.25;
/// So near to a path's end whoever follows it may well have done so.
const NEAR_METERS: f64 = 1.0;
/// What is told of maps that the pilot never sees; what it says of others is its own.
const MAP_FRAME: &str = "map frame";

/// The time by the mission's clock and by the computer's, which may be set meanwhile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    pub(crate) mission: MissionTime,
    pub(crate) unix_ns: i64,
}

/// What a vehicle has for others, in this order.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Effect {
    /// For the robot's mind: where it stands, and what it saw since the last time.
    Sensed { cell: Cell, readings: Vec<Reading> },
    /// For the vehicle's network.
    Publish(Output),
    /// For a detector of this program's own, if it has one; what that sees comes back as [`Vehicle::see`].
    Look(Look),
    /// For the log: something has gone wrong, or is well again.
    Tell(Diagnostic),
}

/// A vehicle.
pub(crate) struct Vehicle {
    pilot: Pilot,
    places: Places,
    terrain: Arc<Terrain>,
    detection_threshold: f64,
    stamps: Stamps,
    board: DiagnosticsAggregator,
    topics: Topics,
    /// Times that the belief was not shown since it was.
    unchanged: u32,
    /// The last place that the network said.
    located: Option<Pose>,
    /// Goals that Nav2 told of last.
    goals: Vec<GoalStatus>,
    /// What Nav2 was asked for, and when.
    errand: Option<(NavigationGoal, Pose, MissionTime)>,
    drive: Option<Drive>,
}

/// A path that the vehicle is to drive.
struct Drive {
    poses: Vec<Pose>,
    /// Where it was when it last got on, and when.
    stood: (Pose, MissionTime),
}

impl Vehicle {
    pub(crate) fn new(pilot: Pilot, ros: &Checked, scenario: &Scenario) -> Self {
        Self {
            pilot,
            places: Places::new(
                ros.localization(),
                ros.uncorrected,
                scenario.origin(),
                scenario.georeference().copied(),
            ),
            terrain: Arc::new(scenario.terrain().clone()),
            detection_threshold: scenario.mission().detection_threshold,
            stamps: ros.stamps(),
            board: DiagnosticsAggregator::default(),
            topics: Topics::new(ros),
            unchanged: 0,
            located: None,
            goals: Vec::new(),
            errand: None,
            drive: None,
        }
    }

    /// The network says something on a topic.
    pub(crate) fn hear(&mut self, now: Now, topic: &TopicName, heard: Incoming) -> Vec<Effect> {
        self.topics.hears(topic, &heard);
        if let Incoming::Rejected { reason, .. } = heard {
            self.board.refuse(now.mission, topic, &reason);
            return self.news();
        }
        self.board.heard(now.mission, topic);
        let located = match heard {
            Incoming::Odometry(odometry) => {
                Ok(self.places.odometry(self.moment(now, odometry.place.stamp_unix_ns), &odometry))
            }
            Incoming::Pose(pose) => self.places.pose(self.moment(now, pose.stamp_unix_ns), &pose),
            Incoming::Fix(fix) => self.places.fix(self.moment(now, fix.stamp_unix_ns), &fix),
            Incoming::Map(map) => return self.hear_map(now, topic, &map),
            Incoming::Detections { camera, detections } => {
                let time_ns = self.time_ns(now, detections.stamp_unix_ns);
                return self.frame(now, &camera, time_ns, detections.boxes.iter().map(of_box).collect());
            }
            Incoming::Image { camera, image } => return self.hear_image(now, topic, camera, image),
            Incoming::Goals(goals) => return self.hear_goals(now, goals),
            Incoming::Rejected { .. } => return Vec::new(),
        };
        match located {
            Ok(located) => located.map(|located| self.locate(now, &located)).unwrap_or_default(),
            Err(reason) => {
                self.board.refuse(now.mission, topic, &reason);
                self.news()
            }
        }
    }

    /// The detector has looked at an image.
    pub(crate) fn see(&mut self, now: Now, seen: Seen) -> Vec<Effect> {
        let subject = format!("detector, {}", seen.camera);
        match seen.found {
            Ok(boxes) => {
                self.board.well(now.mission, &subject);
                self.frame(now, &seen.camera, seen.time_ns, boxes)
            }
            Err(reason) => {
                self.refuse(&InputSource::Camera(seen.camera.to_string()), &reason);
                self.board.note(now.mission, &subject, &reason);
                self.news()
            }
        }
    }

    /// The robot's mind has another route.
    pub(crate) fn follow(&mut self, now: Now, route: Vec<Cell>) -> Vec<Effect> {
        self.tell(now, Event::Route(route))
    }

    /// Time passes: to be called every [`TICK`].
    pub(crate) fn tick(&mut self, now: Now) -> Vec<Effect> {
        let mut effects = self.insist(now);
        self.board.settle(now.mission);
        effects.extend(self.news());
        effects.extend(self.tell(now, Event::Tick));
        effects
    }

    /// What people are shown: what is followed, and the belief if it has changed or stood for a while: to be called every [`SHOW`].
    /// The pilot gets the declared cells of a changed belief.
    pub(crate) fn show(&mut self, now: Now, belief: &Belief, has_changed: bool) -> Vec<Effect> {
        let mut shown = vec![Output::Diagnostics(self.board.all()), Output::Tracks(self.tracks())];
        self.unchanged += 1;
        if has_changed || self.unchanged >= SHOW_AGAIN {
            self.unchanged = 0;
            let start_unix_ns = now.unix_ns.saturating_sub_unsigned(now.mission.0);
            // Where the map lies in the frame that the robot is told of is known to `places`.
            let viewer = Viewer::new(&self.terrain, MapOrigin::default(), start_unix_ns);
            let drawn = viewer.belief(belief, now.mission);
            shown.push(Output::Belief(drawn, planar(&self.places.in_frame(&Pose::default()))));
            shown.push(Output::Objects(self.objects(belief)));
        }
        let mut effects: Vec<Effect> = shown.into_iter().map(Effect::Publish).collect();
        if has_changed {
            effects.extend(self.tell(now, Event::Declared(self.found(belief).collect())));
        }
        effects
    }

    /// Nothing is left to drive. Nav2 is sent to where the robot is, which is how topics call a goal off.
    pub(crate) fn halt(&mut self) -> Vec<Effect> {
        self.drive = None;
        let goal = self.errand.take().and(self.located).map(|here| Output::Goal(self.in_frame(&here)));
        goal.into_iter().chain([Output::Path(Vec::new())]).map(Effect::Publish).collect()
    }

    fn tell(&mut self, now: Now, event: Event) -> Vec<Effect> {
        let actions = self.pilot.handle(now.mission.0, event);
        actions.into_iter().flat_map(|action| self.act(now, action)).collect()
    }

    fn news(&mut self) -> Vec<Effect> {
        self.board.take_news().into_iter().map(Effect::Tell).collect()
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
        Moment { heard_ns: now.mission.0, time_ns: self.time_ns(now, stamp_unix_ns), age }
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

    fn frame(&mut self, now: Now, camera: &str, time_ns: u64, boxes: Vec<DetectionBox>) -> Vec<Effect> {
        let (camera, sights) = (camera.to_owned(), CameraDetections::Boxes(boxes));
        self.tell(now, Event::Frame(CameraFrame { time_ns, camera, head_radians: 0.0, sights }))
    }

    /// A detector's boxes mean something in images of the size that the camera's settings tell.
    fn hear_image(&mut self, now: Now, topic: &TopicName, camera: Arc<str>, image: Image) -> Vec<Effect> {
        let Some(settings) = self.pilot.camera(&camera).map(Camera::settings) else {
            return Vec::new();
        };
        let (width, height) = (settings.width_pixels, settings.height_pixels);
        let subject = format!("image, {camera}");
        if (image.width_pixels, image.height_pixels) != (width, height) {
            let found = format!("an image of {} x {} pixels", image.width_pixels, image.height_pixels);
            let allowed = format!("allowed is {width} x {height}, as in vehicle.cameras");
            let reason = format!("{found}; {allowed}");
            self.board.count(topic, &reason);
            self.board.note(now.mission, &subject, &reason);
            return self.news();
        }
        self.board.well(now.mission, &subject);
        let time_ns = self.time_ns(now, image.stamp_unix_ns);
        vec![Effect::Look(Look { camera, time_ns, image })]
    }

    fn hear_map(&mut self, now: Now, topic: &TopicName, map: &Occupancy) -> Vec<Effect> {
        match ground::cost_map(self.places.map(), map) {
            Ok(map) => {
                self.board.well(now.mission, MAP_FRAME);
                self.tell(now, Event::Map(map))
            }
            Err(reason) => {
                self.board.count(topic, &reason);
                self.board.note(now.mission, MAP_FRAME, &reason);
                self.news()
            }
        }
    }

    fn hear_goals(&mut self, now: Now, goals: Vec<GoalStatus>) -> Vec<Effect> {
        self.goals = goals;
        let Some((errand, ..)) = &mut self.errand else { return Vec::new() };
        errand.follow(&self.goals);
        let report = match errand.progress() {
            Progress::Unanswered => return Vec::new(),
            Progress::Underway => {
                self.board.well(now.mission, "goal");
                return self.news();
            }
            Progress::Reached => DriveReport::Arrived,
            Progress::Failed => DriveReport::Failed("the navigation gave up".to_owned()),
            Progress::Canceled => DriveReport::Failed("somebody called it off".to_owned()),
            Progress::Replaced => DriveReport::Failed("somebody sent the robot elsewhere".to_owned()),
        };
        self.errand = None;
        self.tell(now, Event::Drive(report))
    }

    fn act(&mut self, now: Now, action: Action) -> Vec<Effect> {
        match action {
            Action::Sensed { cell, readings } => vec![Effect::Sensed { cell, readings }],
            Action::Drive(plan) => {
                let path = self.path(&plan.poses);
                self.drive = self.located.map(|here| Drive { poses: plan.poses, stood: (here, now.mission) });
                vec![path]
            }
            Action::Go(pose) => self.go(now, pose),
            Action::Hold => self.halt(),
            Action::Tell(diagnostic) => {
                let diagnostic = self.explained(diagnostic);
                self.board.pin(&diagnostic);
                let mut effects = self.news();
                effects.push(Effect::Publish(Output::Diagnostics(self.board.all())));
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
            self.board.count(topic, reason);
        }
    }

    /// Where no pose comes, the network tells why.
    fn explained(&self, said: Said) -> Said {
        if said.message != NO_POSE {
            return said;
        }
        let why = self.topics.why_no_pose(self.places.missing(), self.board.refused());
        Said { message: format!("{NO_POSE}: {why}"), ..said }
    }

    /// What was refused, by topic.
    pub(crate) const fn refused(&self) -> &BTreeMap<TopicName, RefusedInput> {
        self.board.refused()
    }

    fn go(&mut self, now: Now, pose: Pose) -> Vec<Effect> {
        self.errand = Some((NavigationGoal::begin(&self.goals), pose, now.mission));
        vec![Effect::Publish(Output::Goal(self.in_frame(&pose)))]
    }

    fn path(&self, poses: &[Pose]) -> Effect {
        Effect::Publish(Output::Path(poses.iter().map(|pose| self.in_frame(pose)).collect()))
    }

    /// Tells a goal again that nobody has taken up, or what is left of a path that nobody drives. Whoever drives may have
    /// come late, or started again.
    fn insist(&mut self, now: Now) -> Vec<Effect> {
        let again = match &self.errand {
            Some((errand, pose, told))
                if errand.progress() == Progress::Unanswered && now.mission.since(*told) > PATIENCE =>
            {
                let pose = *pose;
                self.board.note(now.mission, "goal", "nobody takes up the goal; it is told again");
                self.go(now, pose)
            }
            _ => self.path_of_who_stands(now),
        };
        let mut effects = self.news();
        effects.extend(again);
        effects
    }

    fn path_of_who_stands(&mut self, now: Now) -> Vec<Effect> {
        let (Some(drive), Some(here)) = (&mut self.drive, self.located) else { return Vec::new() };
        let meters_from = |pose: &Pose| (pose.position_meters() - here.position_meters()).norm();
        let (stood, since) = drive.stood;
        if meters_from(&stood) > STILL_METERS {
            drive.stood = (here, now.mission);
            self.board.well(now.mission, "path");
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
        // Who stands at its end waits for the next.
        if rest.last().is_none_or(|end| meters_from(end) <= NEAR_METERS) {
            return Vec::new();
        }
        let message = "the vehicle does not drive its path; what is left of it is told again";
        self.board.note(now.mission, "path", message);
        vec![self.path(&rest)]
    }

    /// A pose on the search's map in the frame of the vehicle's network.
    fn in_frame(&self, pose: &Pose) -> dragnet_ros2::input::PlanarPose {
        planar(&self.places.in_frame(pose))
    }
}

fn of_box(found: &DetectedBox) -> DetectionBox {
    let DetectedBox { left, top, right, bottom, .. } = *found;
    DetectionBox { left, top, right, bottom }
}

#[cfg(test)]
mod tests;
