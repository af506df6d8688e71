//! A robot that drives to goals and searches with cameras.

use std::collections::VecDeque;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plane::{Pose, bearing_radians, turn_radians, wrapped_radians};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::seed::{Purpose, stream};
use dragnet_vehicle::camera::Camera;
use dragnet_vehicle::evidence::finds::Find;
use dragnet_vehicle::pilot::{self, Action, CameraDetections, CameraFrame, Pilot, PoseEstimate, Report};
use dragnet_vehicle::settings::Settings;
use nalgebra::Vector2;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Normal};

const STEP_NS: u64 = 10_000_000;
/// Steps between two frames of a camera, and between two positions.
const PERIOD: u64 = 10;
/// A search ends when the robot has rested for this long, and is given up after the other.
const RESTED_NS: u64 = 30_000_000_000;
pub(crate) const LONGEST_NS: u64 = 1_800_000_000_000;

/// What a robot drives on.
pub(crate) trait Ground {
    /// The map of the robot's navigation, if it has one.
    fn map(&self) -> Option<&CostMap>;
    /// The way to a goal, meters; `None` if there is none.
    fn way(&self, from: Vector2<f64>, goal: Vector2<f64>) -> Option<Vec<Vector2<f64>>>;
    /// Whether a wall is between two positions.
    fn hides(&self, from: Vector2<f64>, to: Vector2<f64>) -> bool;
}

/// Nothing stands in the way.
pub(crate) struct Open;

impl Ground for Open {
    fn map(&self) -> Option<&CostMap> {
        None
    }

    fn way(&self, _: Vector2<f64>, goal: Vector2<f64>) -> Option<Vec<Vector2<f64>>> {
        Some(vec![goal])
    }

    fn hides(&self, _: Vector2<f64>, _: Vector2<f64>) -> bool {
        false
    }
}

/// Full speed, m/s; turns on the spot, radians a second; the share of positions that are lost, the time by which those that
/// arrive are dated too early, their error as it is told, and as it is, meters; the heading's, radians; the share of objects
/// in view that are missed, and the error of their bearings, radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body {
    pub(crate) speed: f64,
    pub(crate) turn: f64,
    pub(crate) lost: f64,
    pub(crate) early_ns: u64,
    pub(crate) position_std_meters: f64,
    pub(crate) position_error_meters: f64,
    pub(crate) heading_error_radians: f64,
    pub(crate) missed: f64,
    pub(crate) bearing_error_radians: f64,
}

/// A robot with its vehicle.
pub(crate) struct Search<'a> {
    body: Body,
    ground: &'a dyn Ground,
    object: Vector2<f64>,
    agent: Agent,
    pilot: Pilot,
    cameras: Vec<Camera>,
    belief: Belief,
    pose: Pose,
    way: VecDeque<Vector2<f64>>,
    has_no_way: bool,
    pub(crate) now_ns: u64,
    wake_at: MissionTime,
    pub(crate) rests_since: Option<u64>,
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        scenario: &Scenario,
        settings: &Settings,
        body: Body,
        ground: &'a dyn Ground,
        object: Vector2<f64>,
        seed: u64,
    ) -> Self {
        let checked = settings.check(None).unwrap();
        let cameras = checked.cameras.iter().map(|(camera, _)| camera.clone()).collect();
        let (terrain, sensor) = (scenario.terrain().clone(), scenario.sensor().clone());
        let map = CostMap::from_terrain(&terrain, 1).unwrap();
        let start = Vector2::new(1.5, 1.5) * terrain.cell_meters();
        Self {
            body,
            ground,
            object,
            agent: AgentConfig::of_team(scenario, seed).into_iter().map(Agent::new).next().unwrap(),
            pilot: Pilot::new(checked, terrain, sensor, &map).unwrap(),
            cameras,
            belief: scenario.prior().clone(),
            pose: Pose::new(start.x, start.y, 0.0),
            way: VecDeque::new(),
            has_no_way: false,
            now_ns: 1_000_000_000,
            wake_at: MissionTime(u64::MAX),
            rests_since: None,
        }
    }

    pub(crate) fn complete(&mut self, seed: u64) {
        let mut random = stream(seed, Purpose::Noise, 0);
        let phase = random.random_range(0..PERIOD);
        self.tell(Event::Start);
        if let Some(map) = self.ground.map() {
            self.steer(pilot::Event::Map(map.clone()));
        }
        let is_over = |now_ns: u64, since: Option<u64>| {
            now_ns > LONGEST_NS || since.is_some_and(|since| now_ns - since > RESTED_NS)
        };
        for step in 0.. {
            if is_over(self.now_ns, self.rests_since) {
                return;
            }
            self.now_ns += STEP_NS;
            self.drive(STEP_NS as f64 / 1e9);
            if self.wake_at.0 <= self.now_ns {
                self.tell(Event::Woke);
            }
            if step % PERIOD == phase && !random.random_bool(self.body.lost) {
                let fix = self.fix(&mut random);
                self.steer(pilot::Event::Pose(fix));
            }
            if step % PERIOD == 0 {
                for camera in self.cameras.clone() {
                    let frame = self.frame(&camera, &mut random);
                    self.steer(pilot::Event::Frame(frame));
                }
                self.steer(pilot::Event::Tick);
            }
        }
    }

    fn drive(&mut self, seconds: f64) {
        if std::mem::take(&mut self.has_no_way) {
            self.steer(pilot::Event::Drive(Report::Failed("no way".to_owned())));
        }
        let Some(&next) = self.way.front() else { return };
        let here = self.pose.position_meters();
        let way = next - here;
        if way.norm() < 0.1 {
            self.way.pop_front();
            if self.way.is_empty() && self.ground.map().is_some() {
                self.steer(pilot::Event::Drive(Report::Arrived));
            }
            return;
        }
        let off = turn_radians(self.pose.heading_radians, bearing_radians(here, next));
        let most = self.body.turn * seconds;
        let heading = wrapped_radians(self.pose.heading_radians + off.clamp(-most, most));
        let share = if off.abs() > 0.2 { 0.0 } else { self.body.speed * seconds / way.norm() };
        let place = here + way * share.min(1.0);
        self.pose = Pose::new(place.x, place.y, heading);
    }

    fn fix(&self, random: &mut impl Rng) -> PoseEstimate {
        let Body { position_error_meters, heading_error_radians, .. } = self.body;
        let pose = Pose::new(
            self.pose.x_meters + normal(position_error_meters, random),
            self.pose.y_meters + normal(position_error_meters, random),
            wrapped_radians(self.pose.heading_radians + normal(heading_error_radians, random)),
        );
        PoseEstimate {
            time_ns: self.now_ns - self.body.early_ns,
            pose,
            deviation_meters: self.body.position_std_meters,
            heading_deviation_radians: 2.0_f64.to_radians(),
        }
    }

    fn frame(&self, camera: &Camera, random: &mut impl Rng) -> CameraFrame {
        let eye = self.pose.of_part(&camera.settings().mounting);
        let here = eye.position_meters();
        let bearing = wrapped_radians(bearing_radians(here, self.object) - self.pose.heading_radians);
        let is_seen = camera.sees(bearing, (self.object - here).norm())
            && !self.ground.hides(here, self.object)
            && !random.random_bool(self.body.missed);
        let bearing = bearing + normal(self.body.bearing_error_radians, random);
        CameraFrame {
            time_ns: self.now_ns,
            camera: camera.settings().name.clone(),
            head_radians: 0.0,
            detections: CameraDetections::Bearings(is_seen.then_some(bearing).into_iter().collect()),
        }
    }

    fn steer(&mut self, event: pilot::Event) {
        for action in self.pilot.handle(self.now_ns, event) {
            match action {
                Action::Sensed { cell, readings } => {
                    for reading in &readings {
                        self.belief.add(reading);
                    }
                    self.tell(Event::Sensed { cell, readings });
                }
                Action::RouteFailed { blocked } => self.tell(Event::RouteFailed { blocked }),
                Action::Doubted { cells } => self.tell(Event::Doubted { cells }),
                Action::LineOfSight(seen) => self.tell(Event::LineOfSight(seen)),
                Action::Located(positions) => self.tell(Event::Located(positions)),
                Action::Go(pose) => {
                    let way = self.ground.way(self.pose.position_meters(), pose.position_meters());
                    self.has_no_way = way.is_none();
                    self.way = way.unwrap_or_default().into();
                }
                Action::Hold => self.way.clear(),
                _ => {}
            }
        }
    }

    fn tell(&mut self, event: Event<Message>) {
        let effects = self.agent.handle(MissionTime(self.now_ns), event).unwrap();
        assert!(effects.rejected.is_empty(), "{:?}", effects.rejected);
        self.wake_at = effects.wake_at;
        if let Some(cells) = effects.route {
            self.rests_since = cells.is_empty().then_some(self.now_ns);
            self.steer(pilot::Event::Route(cells));
        }
    }

    /// Declared cells that are no farther from the object than the reported error, and others.
    pub(crate) fn declared(&self, scenario: &Scenario) -> (usize, usize) {
        let terrain = scenario.terrain();
        let is_right = |cell: Cell| {
            let (x, y) = terrain.center_meters(cell);
            let beyond = |offset: f64| (offset.abs() - terrain.cell_meters() / 2.0).max(0.0);
            let gap_meters = beyond(self.object.x - x).hypot(beyond(self.object.y - y));
            gap_meters <= self.pilot.find(cell).map_or(0.0, error_meters)
        };
        let cells = terrain.searched_cells().filter(|&cell| self.belief.is_found(cell, 0.95));
        let (right, wrong): (Vec<Cell>, Vec<Cell>) = cells.partition(|&cell| is_right(cell));
        (right.len(), wrong.len())
    }
}

fn normal(std: f64, random: &mut impl Rng) -> f64 {
    if std > 0.0 { Normal::new(0.0, std).unwrap().sample(random) } else { 0.0 }
}

/// Two standard deviations of a find's position.
fn error_meters(find: &Find) -> f64 {
    2.0 * find.std_meters()
}

pub(crate) fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}
