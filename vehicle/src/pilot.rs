//! The pilot: connects a vehicle's sensors and its agent.
//!
//! It handles sensor data and the agent's routes, each with its time, and returns observations for the agent and paths
//! to drive. State changes only in [`Pilot::handle`].
//!
//! **Observations.** The pilot reports a cell to the agent when the vehicle enters it, with a reading of every cell
//! that the cameras have observed well enough since the last observation ([`crate::evidence`]). Cells beside the route
//! that a turn cuts are not reported, or the agent would take each for a detour and decide anew; their frames count in
//! the next observation. Only a vehicle that has left its route reports its actual cell.
//!
//! While a vehicle without a route stands, it reports news of objects from its last reported cell: that one was found,
//! or has left its cell, or that the cell of one has become known or undecided. It checks for such news every other
//! second (`standing`). Evidence of empty cells waits for the next observation: whatever hides an object from one
//! position keeps hiding it.
//!
//! **Driving.** A route is driven in straight runs, from the center of one cell to that of another. Each run is planned
//! a little before the previous one ends, so that the vehicle does not stop at corners, nor at waypoints if the next
//! route comes in time: a waypoint is reported when its cell is entered. Without a route, the vehicle drives on to the
//! center of that cell and stands.
//!
//! **Safety.** A fault is reported when it begins and when it has been over for the recovery time ([`alarms`]), and
//! until then the vehicle stops or continues as configured ([`crate::settings::OnFault`]). In addition, each invalid
//! pose and frame is counted ([`Action::Refuse`]). In any case it never becomes evidence: a frame counts only if it is
//! valid and the pose at its time is known; after a jump all tracks and all frames since the last observation are
//! dropped.

pub mod alarms;
pub mod diagnostic;
mod drive;
mod event;
mod localization;
mod perception;
mod route;
mod stamp;
mod standing;

use dragnet_search::cell::Cell;
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

use crate::camera::Camera;
use crate::evidence::finds::Find;
use crate::evidence::sight::Sight;
use crate::evidence::{EvidenceError, Seen, standing_cell};
use crate::settings::{Checked, FaultResponse, MeasuredCamera, nanoseconds};
use crate::tracker::settings::SettingsError as TrackerError;
use diagnostic::{Conditions, Fault, NO_POSE, Subject};
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::maneuvers::ManeuversError;
use dragnet_lattice::plan::{PlanError, PlannerError};
use dragnet_lattice::plane::Pose;
use drive::{Corridor, Driver, Goal, Leg};
use localization::{Clock, Judgment, Localization};
use perception::Perception;
use route::Route;
use standing::Standing;

pub use event::{
    Action, Assigned, CameraDetections, CameraFrame, Event, InputSource, Interlock, InterlockFault,
    PoseEstimate, Report,
};

/// Distance to the center of a run's last cell at which the next run begins, cells: corners are cut by no more, so that
/// the vehicle keeps to its route's cells.
const TURNING_SHARE: f64 = 0.25;
/// How long a vehicle that is to drive may stand, nanoseconds, before its run counts as failed.
const STUCK_NS: u64 = 30_000_000_000;
/// Distance from a cell's center at which a vehicle has left it, cells; the border is at one half.
const LEAVING_SHARE: f64 = 0.75;

/// Why a pilot cannot be constructed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PilotError {
    /// The settings of the tracker are invalid.
    #[error(transparent)]
    Tracker(#[from] TrackerError),
    /// Footprint, motion primitives and map do not match.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// No motion primitives can be generated at the map's resolution.
    #[error(transparent)]
    Maneuvers(#[from] ManeuversError),
}

/// A vehicle's pilot.
#[derive(Clone, Debug)]
pub struct Pilot {
    settings: Checked,
    terrain: Terrain,
    sensor: Sensor,
    clock: Clock,
    localization: Localization,
    perception: Perception,
    /// What the agent was told.
    told_line_of_sight: LineOfSight,
    driver: Driver,
    leg: Leg,
    /// When the vehicle set out after it last stood, or was last found not to move, if it is to drive.
    underway_ns: Option<u64>,
    route: Route,
    /// Ends of runs of this route that could not be driven, which the agent does not know yet.
    blocked: Vec<Cell>,
    /// The last reported cell, and when.
    reported: Option<(Cell, u64)>,
    standing: Standing,
    conditions: Conditions,
}

impl Pilot {
    /// A pilot without data. `map` is the initial map of its planner, if it has one.
    ///
    /// # Errors
    /// If footprint, motion primitives and map do not match.
    pub fn new(
        settings: Checked,
        terrain: Terrain,
        sensor: Sensor,
        map: &CostMap,
    ) -> Result<Self, PilotError> {
        Ok(Self {
            clock: Clock::new(settings.recovery_ns),
            localization: Localization::new(&settings),
            perception: Perception::new(&settings, Sight::new(&terrain, sensor.radius()))?,
            told_line_of_sight: LineOfSight::everywhere(),
            driver: Driver::new(&settings.motion, map)?,
            leg: Leg::Idle,
            underway_ns: None,
            route: Route::default(),
            blocked: Vec::new(),
            reported: None,
            standing: Standing::default(),
            conditions: Conditions::new(settings.recovery_ns),
            settings,
            terrain,
            sensor,
        })
    }

    /// Handles an event. It is the only function that changes the state; the caller passes the time, `now_ns`,
    /// nanoseconds of mission time.
    pub fn handle(&mut self, now_ns: u64, event: Event) -> Vec<Action> {
        let mut actions = Vec::new();
        self.perception.forget_assigned();
        let is_now = self.read_clock(now_ns, &mut actions);
        // Routes and maps do not depend on the clock.
        let is_sensed = matches!(event, Event::Pose(_) | Event::Frame(_));
        if is_now || !is_sensed {
            self.take(self.clock.now_ns(), event, &mut actions);
        }
        self.tell_line_of_sight(&mut actions);
        if is_now {
            self.notice_silence(now_ns, &mut actions);
            self.sense(now_ns, &mut actions);
        }
        actions.extend(self.conditions.settle(self.clock.now_ns()).into_iter().map(Action::Tell));
        self.drive(self.clock.now_ns(), &mut actions);
        actions
    }

    /// The camera with this name, if the settings describe it.
    #[must_use]
    pub fn camera(&self, name: &str) -> Option<&Camera> {
        self.settings.cameras.iter().map(|(camera, _)| camera).find(|camera| camera.settings().name == name)
    }

    /// Cameras that the vehicle's network describes, at least in part: their frames bring the camera.
    #[must_use]
    pub fn measured_cameras(&self) -> &[MeasuredCamera] {
        &self.settings.measured_cameras
    }

    /// The cameras' names.
    pub fn cameras(&self) -> impl Iterator<Item = &str> {
        let described = self.settings.cameras.iter().map(|(camera, _)| camera.settings().name.as_str());
        described.chain(self.measured_cameras().iter().map(MeasuredCamera::name))
    }

    /// All tracks.
    #[must_use]
    pub fn tracks(&self) -> &[crate::tracker::track::Track] {
        self.perception.tracks()
    }

    /// The detections of the frames that the last event has processed, as far as they belong to tracks. Frames wait for
    /// the pose at their time, so they are not always those of that event.
    #[must_use]
    pub fn assigned(&self) -> &[Assigned] {
        self.perception.assigned()
    }

    /// Tracks that were reported as objects, each with its position, meters, and covariance.
    pub fn finds(&self) -> impl Iterator<Item = &Find> {
        self.perception.finds().iter()
    }

    /// The find that was reported in a cell.
    #[must_use]
    pub fn find(&self, cell: Cell) -> Option<&Find> {
        self.perception.find(cell)
    }

    /// Whether the clock is trusted.
    fn read_clock(&mut self, now_ns: u64, actions: &mut Vec<Action>) -> bool {
        let (subject, latest_ns) = (Subject::Clock, self.clock.now_ns());
        match self.clock.read(now_ns) {
            Judgment::Good => {
                self.well(&subject);
                true
            }
            Judgment::Restarted => {
                self.localization.forget(now_ns);
                self.perception.restart(now_ns);
                self.standing.forget(now_ns);
                self.reported = self.reported.map(|(cell, _)| (cell, now_ns));
                self.cured(&subject, actions);
                true
            }
            Judgment::Repeated | Judgment::Doubtful => {
                let numbers = [("now_seconds", seconds(now_ns)), ("latest_seconds", seconds(latest_ns))];
                self.ill(subject, Fault::new("backwards", "time runs backwards", &numbers), actions);
                false
            }
        }
    }

    fn take(&mut self, now_ns: u64, event: Event, actions: &mut Vec<Action>) {
        self.perception.begin(now_ns);
        self.localization.begin(now_ns);
        match event {
            Event::Pose(fix) => self.locate(now_ns, &fix, actions),
            Event::Frame(frame) => {
                let name = frame.camera.clone();
                let result = self.perception.receive(now_ns, frame);
                self.judge_camera(name, result, actions);
                self.process_frames(now_ns, actions);
            }
            Event::Map(map) => match self.driver.set_map(&map) {
                Ok(()) => {
                    self.well(&Subject::Map);
                    self.perception.set_walls(&self.terrain, map);
                    self.leg = Leg::Idle;
                }
                Err(error) => {
                    self.ill(Subject::Map, Fault::new("unusable", &error.to_string(), &[]), actions);
                }
            },
            Event::Route(cells) => {
                let is_stay = cells.is_empty();
                self.route = Route::new(cells);
                self.blocked.clear();
                if is_stay {
                    self.well(&Subject::Path);
                    self.hold(Leg::Holding, actions);
                } else if !self.is_arriving() {
                    self.leg = Leg::Idle;
                }
            }
            Event::Closed(cells) => {
                self.driver.close(&self.terrain, &cells);
                if matches!(self.leg, Leg::Driving { .. }) {
                    self.leg = Leg::Idle;
                }
            }
            Event::Declared(cells) => self.perception.set_declared(cells),
            Event::Drive(report) => self.receive(report, actions),
            Event::Interlock(interlock, Some(InterlockFault { kind, message })) => {
                self.ill(Subject::Interlock(interlock), Fault::new(kind, &message, &[]), actions);
            }
            // Whoever lets the vehicle go on expects that it does.
            Event::Interlock(interlock, None) => self.cured(&Subject::Interlock(interlock), actions),
            Event::Tick => self.process_frames(now_ns, actions),
        }
    }

    fn locate(&mut self, now_ns: u64, fix: &PoseEstimate, actions: &mut Vec<Action>) {
        match self.localization.judge(now_ns, fix, &self.terrain) {
            Ok(Judgment::Restarted) => {
                self.perception.restart(now_ns);
                self.leg = Leg::Idle;
                self.cured(&Subject::Pose, actions);
            }
            // A repeated pose says nothing about now.
            Ok(Judgment::Repeated) => {}
            Ok(_) => self.well(&Subject::Pose),
            Err(fault) => {
                actions.push(Action::Refuse(InputSource::Pose, fault.to_string()));
                self.ill(Subject::Pose, fault, actions);
            }
        }
        self.process_frames(now_ns, actions);
    }

    /// Processes the frames whose poses are known by now.
    fn process_frames(&mut self, now_ns: u64, actions: &mut Vec<Action>) {
        let results = self.perception.process_frames(now_ns, &self.localization, &self.terrain, &self.sensor);
        for (subject, fault) in results {
            match (subject, fault) {
                (Subject::Camera(name), Some(fault)) => self.judge_camera(name, Err(fault), actions),
                (subject, Some(fault)) => self.ill(subject, fault, actions),
                (subject, None) => self.well(&subject),
            }
        }
    }

    fn judge_camera(&mut self, name: String, result: Result<(), Fault>, actions: &mut Vec<Action>) {
        match result {
            Ok(()) => {}
            Err(fault) => {
                actions.push(Action::Refuse(InputSource::Camera(name.clone()), fault.to_string()));
                self.ill(Subject::Camera(name), fault, actions);
            }
        }
    }

    fn receive(&mut self, report: Report, actions: &mut Vec<Action>) {
        let Leg::Driving { target } = self.leg else { return };
        if !self.route.contains(target) {
            // The cell was entered: wherever in it the drive ended, the next can begin.
            self.driver.stop();
            return;
        }
        let fault = match report {
            Report::Arrived => {
                Fault::new("short", "the drive ended before the cell was entered", &self.numbers(target))
            }
            Report::Failed(why) => {
                Fault::new("failed", &format!("the drive failed: {why}"), &self.numbers(target))
            }
        };
        self.blocked.push(target);
        self.give_up(fault, actions);
    }

    fn notice_silence(&mut self, now_ns: u64, actions: &mut Vec<Action>) {
        let silence_ns = self.localization.silence_ns(now_ns);
        // Invalid poses are not silence: they are reported as invalid.
        let is_silent = self.localization.unused_for_ns(now_ns) > self.settings.pose_timeout_ns;
        if silence_ns > self.settings.pose_timeout_ns && is_silent {
            let numbers = [("silence_seconds", seconds(silence_ns))];
            self.ill(Subject::Pose, Fault::new("silent", NO_POSE, &numbers), actions);
        }
        for (name, silence_ns) in self.perception.silences(now_ns) {
            let subject = Subject::Silence(name);
            if silence_ns > self.settings.camera_timeout_ns {
                let numbers = [("silence_seconds", seconds(silence_ns))];
                self.ill(subject, Fault::new("silent", "no frame comes that can be used", &numbers), actions);
            } else {
                let Subject::Silence(name) = &subject else { continue };
                if self.perception.is_good(name) {
                    self.well(&Subject::Camera(name.clone()));
                }
                self.well(&subject);
            }
        }
    }

    /// Reports an observation to the agent, if there is one.
    fn sense(&mut self, now_ns: u64, actions: &mut Vec<Action>) {
        if self.conditions.is_bad(&Subject::Pose) {
            return;
        }
        let Some(fix) = self.localization.fix() else { return };
        self.standing.note(now_ns, fix);
        let pose = fix.pose;
        let cell = match standing_cell(&self.terrain, &pose) {
            Ok(cell) => {
                self.well(&Subject::Ground);
                cell
            }
            Err(error) => {
                let numbers = [("x_meters", pose.x_meters), ("y_meters", pose.y_meters)];
                self.ill(Subject::Ground, Fault::new("blocked", &error.to_string(), &numbers), actions);
                return;
            }
        };
        if self.is_worth_reporting(now_ns, cell) {
            if self.asks_for_another_route() {
                actions.push(Action::RouteFailed { blocked: std::mem::take(&mut self.blocked) });
            }
            // The pose was checked above.
            if let Ok((last, seen)) = self.observation(cell, &pose) {
                self.reported = Some((cell, now_ns));
                self.doubt(cell, actions);
                self.tell_line_of_sight(actions);
                self.tell_positions(actions);
                let seen = last.into_iter().chain([seen]);
                actions.extend(seen.map(|seen| Action::Sensed { cell: seen.from, readings: seen.readings }));
            }
        } else if let Some(seen) = self.news(now_ns) {
            self.doubt(cell, actions);
            self.tell_line_of_sight(actions);
            self.tell_positions(actions);
            actions.push(Action::Sensed { cell: seen.from, readings: seen.readings });
        }
        let outside = self.perception.take_outside();
        actions.extend(outside.iter().map(|place| Action::Tell(diagnostic::outside(place.x, place.y))));
    }

    /// Tells the agent what is hidden, if that has changed.
    fn tell_line_of_sight(&mut self, actions: &mut Vec<Action>) {
        if self.told_line_of_sight != *self.perception.line_of_sight() {
            self.told_line_of_sight = self.perception.line_of_sight().clone();
            actions.push(Action::LineOfSight(self.told_line_of_sight.clone()));
        }
    }

    /// Tells the agent of cells to come back to.
    fn doubt(&mut self, from: Cell, actions: &mut Vec<Action>) {
        let cells = self.perception.take_doubted(&self.terrain, &self.sensor, from);
        if !cells.is_empty() {
            actions.push(Action::Doubted { cells });
        }
    }

    /// Tells the agent where objects are that it declares.
    fn tell_positions(&mut self, actions: &mut Vec<Action>) {
        let positions = self.perception.take_positions(&self.terrain);
        if !positions.is_empty() {
            actions.push(Action::Located(positions));
        }
    }

    /// The observation of a cell and, if the vehicle has come from another one, the last one from there. Repeating the request
    /// from the same cell is not an observation from another one.
    fn observation(&mut self, cell: Cell, pose: &Pose) -> Result<(Option<Seen>, Seen), EvidenceError> {
        let reported = self.reported.map(|(reported, _)| reported);
        if self.leg == Leg::GivenUp && reported == Some(cell) {
            return Ok((None, self.perception.observe_again(&self.terrain, &self.sensor, cell).0));
        }
        let left = reported.filter(|&reported| reported != cell);
        self.perception.observation(&self.terrain, &self.sensor, pose, left)
    }

    /// News of objects while the vehicle stands without a route.
    fn news(&mut self, now_ns: u64) -> Option<Seen> {
        let (reported, reported_ns) = self.reported?;
        let cell_ns = nanoseconds(self.cell_seconds());
        let has_nowhere_to_go = self.route.is_empty() || self.leg.is_still();
        if !has_nowhere_to_go || !self.standing.may_observe(now_ns, reported_ns, cell_ns) {
            return None;
        }
        let (seen, is_news) = self.perception.observe_again(&self.terrain, &self.sensor, reported);
        if !is_news {
            return None;
        }
        self.standing.pay(now_ns, cell_ns);
        Some(seen)
    }

    fn is_worth_reporting(&mut self, now_ns: u64, cell: Cell) -> bool {
        let Some((reported, reported_ns)) = self.reported else {
            return self.localization.known_for_ns(now_ns) >= self.settings.initial_scan_ns;
        };
        if self.asks_for_another_route() {
            // It is asked no more often than the vehicle could enter cells.
            return seconds(now_ns.saturating_sub(reported_ns)) >= self.cell_seconds();
        }
        if self.route.enter(cell) {
            return true;
        }
        cell != reported && self.has_left(reported) && self.route.is_left(self.terrain.grid(), cell)
    }

    fn asks_for_another_route(&self) -> bool {
        self.leg == Leg::GivenUp && self.settings.on_fault.path == FaultResponse::Continue
    }

    /// Whether the vehicle is clearly outside a cell, not on its border.
    fn has_left(&self, cell: Cell) -> bool {
        let Some(pose) = self.localization.pose() else { return false };
        let (x_meters, y_meters) = self.terrain.center_meters(cell);
        let beside = (pose.x_meters - x_meters).abs().max((pose.y_meters - y_meters).abs());
        beside > self.terrain.cell_meters() * LEAVING_SHARE
    }

    /// The time to cross a cell at full speed, seconds.
    fn cell_seconds(&self) -> f64 {
        self.terrain.cell_meters() / self.settings.speed_meters_per_second
    }

    /// Starts the next run, if there is one and no fault prevents it.
    fn drive(&mut self, now_ns: u64, actions: &mut Vec<Action>) {
        if self.conditions.forbid(&self.settings.on_fault) {
            // After giving up, the agent must still be asked for another route.
            let leg = if self.leg == Leg::GivenUp { Leg::GivenUp } else { Leg::Holding };
            self.hold(leg, actions);
            return;
        }
        let Some(pose) = self.localization.pose() else { return };
        if self.localization.silence_ns(now_ns) > self.settings.pose_timeout_ns {
            return;
        }
        if self.is_stuck(now_ns) {
            self.underway_ns = Some(now_ns);
            let why = format!("it has not moved for {} s", seconds(STUCK_NS));
            self.receive(Report::Failed(why), actions);
        }
        let is_underway = match self.leg {
            Leg::Driving { target } => {
                let near_meters = self.terrain.cell_meters() * TURNING_SHARE;
                let is_on_the_way =
                    self.route.contains(target) || !self.driver.is_near_end(&pose, near_meters);
                is_on_the_way && !self.driver.is_beside(&pose)
            }
            Leg::GivenUp => true,
            Leg::Idle | Leg::Holding => false,
        };
        while !is_underway && !self.route.is_empty() {
            match self.set_out(&pose) {
                Ok((target, action)) => {
                    self.well(&Subject::Path);
                    self.leg = Leg::Driving { target };
                    self.underway_ns.get_or_insert(now_ns);
                    actions.push(action);
                    return;
                }
                Err(fault) => self.give_up(fault, actions),
            }
            if self.leg == Leg::GivenUp {
                return;
            }
        }
    }

    /// Whether it is to drive and does not, though it could before: something that no map shows is in its way, such as another
    /// robot that waits for it.
    fn is_stuck(&self, now_ns: u64) -> bool {
        let since_ns = self.underway_ns.zip(self.standing.since_ns()).map(|(out, still)| out.max(still));
        matches!(self.leg, Leg::Driving { .. })
            && self.settings.on_fault.path == FaultResponse::Continue
            && since_ns.is_some_and(|since_ns| now_ns.saturating_sub(since_ns) >= STUCK_NS)
    }

    /// Whether it is in the last cell of a run, driving to its center.
    fn is_arriving(&self) -> bool {
        let reported = self.reported.map(|(cell, _)| cell);
        matches!(self.leg, Leg::Driving { target } if Some(target) == reported)
    }

    /// Plans the next straight run of the route.
    fn set_out(&mut self, pose: &Pose) -> Result<(Cell, Action), Fault> {
        let grid = self.terrain.grid();
        let here = self.reported.map(|(cell, _)| cell);
        let Some((run, heading_radians)) = self.route.run(grid, here) else {
            return Err(Fault::new("empty", "the route has no cell", &[]));
        };
        let cell_meters = self.terrain.cell_meters();
        let middles = here.iter().chain(run).map(|&cell| self.terrain.center_meters(cell)).collect();
        let target = run[run.len() - 1];
        let goal = Goal { heading_radians, corridor: Corridor { middles, cell_meters } };
        let action = self.driver.set_out(pose, &goal);
        action.map(|action| (target, action)).map_err(|error| {
            if matches!(error, PlanError::GoalBlocked(..)) {
                // What the map says of this cell, it says of all such cells.
                let narrow = self.driver.too_narrow(&self.terrain);
                self.blocked.retain(|cell| !narrow.contains(cell));
                self.blocked.extend(narrow);
            } else if !drive::is_of_the_start(&error) {
                self.blocked.push(target);
            }
            Fault::new("unreachable", &error.to_string(), &self.numbers(target))
        })
    }

    /// The next run cannot be driven: it is skipped, or the vehicle stands.
    fn give_up(&mut self, fault: Fault, actions: &mut Vec<Action>) {
        self.ill(Subject::Path, fault, actions);
        if self.settings.on_fault.path == FaultResponse::Stop {
            self.hold(Leg::GivenUp, actions);
            return;
        }
        let here = self.reported.map(|(cell, _)| cell);
        self.route.skip_run(self.terrain.grid(), here);
        if self.route.is_empty() {
            self.hold(Leg::GivenUp, actions);
        } else {
            self.leg = Leg::Idle;
        }
    }

    fn hold(&mut self, leg: Leg, actions: &mut Vec<Action>) {
        let is_new = !self.leg.is_still();
        self.leg = leg;
        self.underway_ns = None;
        self.driver.stop();
        if is_new {
            actions.push(Action::Hold);
        }
    }

    fn numbers(&self, target: Cell) -> [(&'static str, f64); 2] {
        let (x, y) = self.terrain.center_meters(target);
        [("goal_x_meters", x), ("goal_y_meters", y)]
    }

    fn ill(&mut self, subject: Subject, fault: Fault, actions: &mut Vec<Action>) {
        actions.extend(self.conditions.ill(self.clock.now_ns(), subject, fault).map(Action::Tell));
    }

    fn well(&mut self, subject: &Subject) {
        self.conditions.well(self.clock.now_ns(), subject);
    }

    fn cured(&mut self, subject: &Subject, actions: &mut Vec<Action>) {
        actions.extend(self.conditions.cured(subject).map(Action::Tell));
    }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}

#[cfg(test)]
mod tests;
