//! One drive: a vehicle on a straight line, its noisy localization, its cameras and their detector.

use std::f64::consts::PI;
use std::fmt::Write as _;

use dragnet_lattice::costmap::CostMap;
use dragnet_lattice::plane::{Pose, bearing_radians, wrapped_radians};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::Reading;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::{Ground, Terrain};
use dragnet_vehicle::camera::{Camera, DetectionBox};
use dragnet_vehicle::evidence::finds::Find;
use dragnet_vehicle::pilot::{Action, CameraDetections, CameraFrame, Event, Pilot, PoseEstimate};
use dragnet_vehicle::settings::{CameraTable, MotionTable, Settings};
use nalgebra::Vector2;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

const CELLS: u32 = 12;
const SPEED_METERS_PER_SECOND: f64 = 2.0;
const PLACE_STD_METERS: f64 = 0.05;
const HEADING_STD_RADIANS: f64 = 0.6 * PI / 180.0;
const POSES_PER_SECOND: f64 = 2.0;
const MISSED: f64 = 0.2;
const FALSE_ALARM: f64 = 0.05;
const TAU: f64 = 0.95;
const RATES: [f64; 5] = [2.5, 5.0, 10.0, 15.0, 30.0];

/// Position of the object relative to the vehicle's line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Through the object's cell.
    Through,
    /// 10 m beside the object.
    Abeam,
    /// The object on the border of two cells.
    Border,
    /// The object at the corner of four.
    Corner,
}

/// The cameras of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Eyes {
    /// Two cameras of 90 degrees, to the left and to the right of ahead.
    TwoWide,
    /// The default cameras.
    Default,
    /// One camera of 90 degrees that faces ahead.
    OneWide,
}

/// The result of a drive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outcome {
    /// At the end the object is declared: in its cell, or in one no farther away than the reported error.
    pub(crate) is_right: bool,
    /// At any time something else was declared.
    pub(crate) is_wrong: bool,
    /// A log of the drive.
    pub(crate) log: String,
}

pub(crate) fn settings(eyes: Eyes) -> Settings {
    let wide = |name: &str, yaw_degrees| CameraTable {
        name: name.to_owned(),
        field_of_view_degrees: Some(90.0),
        yaw_degrees: Some(yaw_degrees),
        ..CameraTable::wide()
    };
    let settings = Settings { motion: MotionTable::Goal {}, ..Settings::default() };
    match eyes {
        Eyes::TwoWide => Settings { cameras: vec![wide("left", 45.0), wide("right", -45.0)], ..settings },
        Eyes::OneWide => Settings { cameras: vec![wide("front", 0.0)], ..settings },
        Eyes::Default => settings,
    }
}

fn normal(random: &mut Stream) -> f64 {
    StandardNormal.sample(random)
}

struct Course {
    from: Vector2<f64>,
    direction_radians: f64,
    seconds: f64,
    object: Vector2<f64>,
}

impl Course {
    fn new(kind: Kind, cell_meters: f64, random: &mut Stream) -> Self {
        let length = f64::from(CELLS) * cell_meters;
        let middle = |random: &mut Stream| {
            let cell: u32 = random.random_range(4..8);
            f64::from(cell) * cell_meters
        };
        let inside = |random: &mut Stream| middle(random) + random.random_range(0.0..cell_meters);
        let near = |random: &mut Stream| middle(random) + random.random_range(-0.1..0.1);
        // Along the drive, beside it.
        let (along, across) = match kind {
            Kind::Through | Kind::Abeam => (inside(random), inside(random)),
            Kind::Border if random.random_bool(0.5) => (near(random), inside(random)),
            Kind::Border => (inside(random), near(random)),
            Kind::Corner => (near(random), near(random)),
        };
        let side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
        let lane = match kind {
            Kind::Through => {
                (across / cell_meters).floor() * cell_meters + random.random_range(0.0..cell_meters)
            }
            Kind::Abeam => across + side * 10.0,
            Kind::Border | Kind::Corner => across + random.random_range(-15.0..15.0),
        };
        let turned = random.random_range(0..4_u32);
        let place = |along: f64, across: f64| match turned {
            0 => Vector2::new(along, across),
            1 => Vector2::new(across, length - along),
            2 => Vector2::new(length - along, length - across),
            _ => Vector2::new(length - across, along),
        };
        let from = place(2.0, lane);
        let direction_radians = bearing_radians(from, place(length - 2.0, lane));
        let seconds = (length - 4.0) / SPEED_METERS_PER_SECOND;
        Self { from, direction_radians, seconds, object: place(along, across) }
    }

    /// From the end to the beginning, beside the same object.
    fn back(&self) -> Self {
        let end = self.pose(self.seconds).position_meters();
        let direction_radians = wrapped_radians(self.direction_radians + PI);
        Self { from: end, direction_radians, ..*self }
    }

    fn pose(&self, seconds: f64) -> Pose {
        let (sin, cos) = self.direction_radians.sin_cos();
        let at = self.from + Vector2::new(cos, sin) * SPEED_METERS_PER_SECOND * seconds;
        Pose::new(at.x, at.y, self.direction_radians)
    }
}

fn fix(pose: &Pose, time_ns: u64, random: &mut Stream) -> PoseEstimate {
    let mut off = |deviation: f64| deviation * normal(random);
    let pose = Pose::new(
        pose.x_meters + off(PLACE_STD_METERS),
        pose.y_meters + off(PLACE_STD_METERS),
        wrapped_radians(pose.heading_radians + off(HEADING_STD_RADIANS)),
    );
    PoseEstimate {
        time_ns,
        pose,
        deviation_meters: PLACE_STD_METERS,
        heading_deviation_radians: HEADING_STD_RADIANS,
    }
}

fn boxed(camera: &Camera, column: f64) -> DetectionBox {
    let width = f64::from(camera.settings().width_pixels);
    let half = 10.0_f64.min(column).min(width - column).max(0.01);
    DetectionBox { left: column - half, top: 500.0, right: column + half, bottom: 560.0 }
}

fn image(camera: &Camera, vehicle: &Pose, object: Vector2<f64>, random: &mut Stream) -> Vec<DetectionBox> {
    let eye = vehicle.of_part(&camera.settings().mounting);
    let bearing = wrapped_radians(bearing_radians(eye.position_meters(), object) - vehicle.heading_radians);
    let range = (object - eye.position_meters()).norm();
    let width = f64::from(camera.settings().width_pixels);
    let (luck, error, imagined, place) =
        (random.random::<f64>(), 4.0 * normal(random), random.random::<f64>(), random.random::<f64>());
    let mut boxes = Vec::new();
    if camera.sees(bearing, range) && luck >= MISSED {
        let column = (camera.column_pixels(bearing).unwrap() + error).clamp(0.1, width - 0.1);
        boxes.push(boxed(camera, column));
    }
    if imagined < FALSE_ALARM {
        boxes.push(boxed(camera, (place * width).clamp(0.1, width - 0.1)));
    }
    boxes
}

#[derive(Clone, Copy, Debug)]
enum Due {
    Pose,
    Frame(usize),
    Tick,
}

/// When a pose, a tick or a frame is due, and the period of cameras.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "minutes in nanoseconds")]
fn schedule(seconds: f64, cameras: usize, random: &mut Stream) -> (f64, Vec<(u64, Due)>) {
    let rate = RATES[random.random_range(0..RATES.len())];
    let mut due = Vec::new();
    let mut every = |hertz: f64, phase: f64, what: Due| {
        let times = (0..).map(|index: u32| (f64::from(index) + phase) / hertz).take_while(|&at| at < seconds);
        due.extend(times.map(|at| ((1e9 * (1.0 + at)).round() as u64, what)));
    };
    every(POSES_PER_SECOND, 0.0, Due::Pose);
    every(10.0, 0.0, Due::Tick);
    for camera in 0..cameras {
        every(rate, random.random::<f64>(), Due::Frame(camera));
    }
    due.sort_by_key(|&(time_ns, _)| time_ns);
    (rate, due)
}

/// A drive in progress.
struct Drive {
    course: Course,
    cameras: Vec<Camera>,
    terrain: Terrain,
    pilot: Pilot,
    belief: Belief,
    /// Cells that were declared at any time.
    ever: Vec<Cell>,
    log: String,
}

pub(crate) fn run(kind: Kind, eyes: Eyes, cell_meters: f64, seed: u64) -> Outcome {
    let mut random = stream(seed, Purpose::Truth, 0);
    let mut drive = Drive::new(Course::new(kind, cell_meters, &mut random), eyes, cell_meters);
    drive.complete(&mut random);
    drive.end()
}

/// Two robots pass one object, one after the other: how many cells they have declared by then.
pub(crate) fn run_two(kind: Kind, eyes: Eyes, cell_meters: f64, seed: u64) -> usize {
    let mut random = stream(seed, Purpose::Truth, 0);
    let course = Course::new(kind, cell_meters, &mut random);
    let back = course.back();
    let mut first = Drive::new(course, eyes, cell_meters);
    first.complete(&mut random);
    let mut second = Drive::new(back, eyes, cell_meters);
    second.belief = first.belief;
    second.pilot.handle(0, Event::Declared(second.declared().into_iter().collect()));
    second.complete(&mut random);
    second.declared().len()
}

impl Drive {
    fn new(course: Course, eyes: Eyes, cell_meters: f64) -> Self {
        let grid = Grid::new(CELLS, CELLS).unwrap();
        let terrain = Terrain::new(grid, cell_meters, vec![Ground::OPEN; grid.cell_count()]).unwrap();
        let map = CostMap::from_terrain(&terrain, 1).unwrap();
        let checked = settings(eyes).check(None).unwrap();
        Self {
            course,
            cameras: checked.cameras.iter().map(|(camera, _)| camera.clone()).collect(),
            pilot: Pilot::new(checked, terrain.clone(), Sensor::default(), &map).unwrap(),
            belief: Belief::uniform(&terrain, 1.0 / f64::from(CELLS * CELLS)).unwrap(),
            terrain,
            ever: Vec::new(),
            log: String::new(),
        }
    }

    fn complete(&mut self, random: &mut Stream) {
        let (rate, due) = schedule(self.course.seconds, self.cameras.len(), random);
        let Course { from, object, direction_radians, .. } = &self.course;
        let degrees = direction_radians.to_degrees();
        self.log = format!("{rate} Hz, object at {object:.2?}, from {from:.2?} to {degrees:.0} degrees\n");
        for (time_ns, what) in due {
            self.step(time_ns, what, random);
        }
    }

    fn step(&mut self, time_ns: u64, what: Due, random: &mut Stream) {
        let pose = self.course.pose(seconds(time_ns));
        let event = match what {
            Due::Pose => Event::Pose(fix(&pose, time_ns, random)),
            Due::Tick => Event::Tick,
            Due::Frame(index) => {
                let camera = &self.cameras[index];
                let detections = CameraDetections::Boxes(image(camera, &pose, self.course.object, random));
                let camera = camera.settings().name.clone();
                Event::Frame(CameraFrame { time_ns, camera, head_radians: 0.0, detections })
            }
        };
        for action in self.pilot.handle(time_ns, event) {
            match action {
                Action::Sensed { cell, readings } => self.observation(time_ns, cell, &readings),
                Action::Tell(diagnostic) => writeln!(self.log, "  {diagnostic}").unwrap(),
                _ => {}
            }
        }
    }

    fn observation(&mut self, time_ns: u64, cell: Cell, readings: &[Reading]) {
        for reading in readings {
            self.belief.add(reading);
        }
        let found = self.declared();
        self.describe(time_ns, cell, readings, &found);
        self.ever.extend(found);
    }

    fn declared(&self) -> Vec<Cell> {
        self.terrain.searched_cells().filter(|&cell| self.belief.is_found(cell, TAU)).collect()
    }

    fn end(self) -> Outcome {
        let is_good = |&cell: &Cell| {
            let gap_meters = gap_meters(&self.terrain, cell, self.course.object);
            self.pilot.find(cell).is_some_and(|find| gap_meters <= error_meters(find))
        };
        let is_right = self.declared().iter().any(is_good);
        let is_wrong = !self.ever.iter().all(is_good);
        Outcome { is_right, is_wrong, log: self.log }
    }

    fn describe(&mut self, time_ns: u64, from: Cell, readings: &[Reading], found: &[Cell]) {
        let (grid, edge) = (self.terrain.grid(), self.terrain.cell_meters());
        let object = self.course.object;
        let home = grid.cell_at(object.x / edge, object.y / edge);
        let own: Vec<_> = readings
            .iter()
            .filter(|reading| Some(reading.cell) == home || reading.value > 0.5)
            .map(|reading| (grid.position(reading.cell), reading.value, reading.variance))
            .collect();
        let found: Vec<_> = found.iter().map(|&cell| grid.position(cell)).collect();
        let (at, from) = (seconds(time_ns), grid.position(from));
        writeln!(self.log, "  {at:.1} s in {from:?}: {own:?}, found {found:?}").unwrap();
        for track in self.pilot.tracks() {
            let place = track.position_covariance();
            let std = place.symmetric_eigenvalues().map(f64::sqrt);
            let off = (track.position_meters() - object).norm();
            let ago = seconds(time_ns) - seconds(track.seen_ns());
            let (id, standing, hits, score) =
                (track.id(), track.standing(), track.hits(), track.score_nats());
            writeln!(
                self.log,
                "      {id:?} {standing:?}, {off:.2} m off, std {:.2} {:.2} m, {hits} hits, score {score:.0}, \
                 seen {ago:.1} s ago",
                std.max(),
                std.min(),
            )
            .unwrap();
        }
    }
}

/// Since the drive began.
fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9 - 1.0
}

/// Two standard deviations of a find's position.
fn error_meters(find: &Find) -> f64 {
    2.0 * find.std_meters()
}

/// Distance of a point from a cell.
fn gap_meters(terrain: &Terrain, cell: Cell, point: Vector2<f64>) -> f64 {
    let (x, y) = terrain.center_meters(cell);
    let half = terrain.cell_meters() / 2.0;
    let beyond = |offset: f64| (offset.abs() - half).max(0.0);
    beyond(point.x - x).hypot(beyond(point.y - y))
}
