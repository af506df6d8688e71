//! A pilot on a small field: its reports, its paths, and its responses to faults.

mod faults;
mod measured;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use dragnet_proto::validation::Limits;
use dragnet_scenario::Scenario;
use dragnet_search::cell::Position;
use dragnet_search::evidence::Reading;
use dragnet_search::observation::{Observation, ObservationLog, Origin, RobotId};
use nalgebra::Vector2;
use proptest::prelude::*;

use super::diagnostic::{Diagnostic, Level};
use super::*;
use crate::camera::{Camera, DetectionBox};
use crate::settings::{CameraTable, MotionTable, Settings};
use dragnet_lattice::plane::{bearing_radians, wrapped_radians};

/// 5 Hz.
const STEP_NS: u64 = 200_000_000;
const SECOND: u64 = 1_000_000_000;
const SPEED: f64 = 2.0;

/// Open ground of 12 x 12 cells of 10 m.
fn scenario() -> Scenario {
    let text = "name = 'field'\nmap = { shape = 'all_traversable', rows = 12, columns = 12, cell_meters = 10.0 }\n\
                sensor.radius = 4\nobjects.count = 1\n[mission]\nbudget_seconds = 900.0\n\
                speed_meters_per_second = 2.0\n";
    Scenario::from_text(Path::new("field.toml"), text.to_owned()).unwrap()
}

/// Three wide cameras that see in all directions.
fn settings() -> Settings {
    let camera = |name: &str, yaw_degrees| CameraTable {
        name: name.to_owned(),
        field_of_view_degrees: Some(125.0),
        yaw_degrees: Some(yaw_degrees),
        ..CameraTable::wide()
    };
    let mut settings = Settings {
        cameras: vec![camera("front", 0.0), camera("left", 120.0), camera("right", -120.0)],
        ..Settings::default()
    };
    settings.tracker.velocity_std_meters_per_second = 0.01;
    settings.tracker.acceleration_std_meters_per_second = 1e-4;
    settings.tracker.gate_degrees = 8.0;
    settings
}

/// A pilot, its vehicle, which follows each path exactly, and all its actions.
struct Drive {
    pilot: Pilot,
    cameras: Vec<Camera>,
    objects: Vec<Vector2<f64>>,
    now_ns: u64,
    pose: Pose,
    path: Vec<Pose>,
    actions: Vec<Action>,
}

impl Drive {
    fn new(settings: &Settings) -> Self {
        Self::on(settings, scenario().terrain(), 8)
    }

    fn on(settings: &Settings, terrain: &Terrain, parts: u32) -> Self {
        let checked = settings.check(None).unwrap();
        let cameras = checked.cameras.iter().map(|(camera, _)| camera.clone()).collect();
        let map = CostMap::from_terrain(terrain, parts).unwrap();
        let sensor = scenario().sensor().clone();
        Self {
            pilot: Pilot::new(checked, terrain.clone(), sensor, &map).unwrap(),
            cameras,
            objects: Vec::new(),
            now_ns: SECOND,
            pose: Pose::new(25.0, 25.0, 0.0),
            path: Vec::new(),
            actions: Vec::new(),
        }
    }

    /// Passes an event to the pilot; returns its actions.
    fn tell(&mut self, event: Event) -> Vec<Action> {
        let actions = self.pilot.handle(self.now_ns, event);
        for action in &actions {
            match action {
                Action::Drive(plan) => self.path = plan.poses.iter().rev().copied().collect(),
                Action::Hold => self.path.clear(),
                _ => {}
            }
        }
        self.actions.extend(actions.clone());
        actions
    }

    fn fix(&self) -> PoseEstimate {
        PoseEstimate {
            time_ns: self.now_ns,
            pose: self.pose,
            deviation_meters: 0.1,
            heading_deviation_radians: 0.005,
        }
    }

    /// A camera's perfect detections of the objects.
    fn frame(&self, camera: &Camera) -> CameraFrame {
        let eye = self.pose.of_part(&camera.settings().mounting);
        let bearing = |object: &Vector2<f64>| {
            let bearing = bearing_radians(eye.position_meters(), *object) - self.pose.heading_radians;
            let range = (object - eye.position_meters()).norm();
            camera.sees(wrapped_radians(bearing), range).then(|| wrapped_radians(bearing))
        };
        CameraFrame {
            time_ns: self.now_ns,
            camera: camera.settings().name.clone(),
            head_radians: 0.0,
            detections: CameraDetections::Bearings(self.objects.iter().filter_map(bearing).collect()),
        }
    }

    /// A step in which the vehicle moves along its path without faults.
    fn step(&mut self) -> Vec<Action> {
        self.step_with(|drive, camera| Some(drive.frame(camera)))
    }

    /// The same with given frames.
    fn step_with(&mut self, frame: impl Fn(&Self, &Camera) -> Option<CameraFrame>) -> Vec<Action> {
        let before = self.actions.len();
        self.move_on();
        let fix = self.fix();
        self.tell(Event::Pose(fix));
        for camera in self.cameras.clone() {
            match frame(self, &camera) {
                Some(frame) => drop(self.tell(Event::Frame(frame))),
                None => drop(self.tell(Event::Tick)),
            }
        }
        self.actions[before..].to_vec()
    }

    fn move_on(&mut self) {
        self.now_ns += STEP_NS;
        let mut way = SPEED * STEP_NS as f64 / SECOND as f64;
        while let Some(&next) = self.path.last() {
            let left = (next.position_meters() - self.pose.position_meters()).norm();
            if left > way {
                let share = way / left;
                let to = self.pose.position_meters().lerp(&next.position_meters(), share);
                self.pose = Pose::new(to.x, to.y, next.heading_radians);
                return;
            }
            way -= left;
            self.pose = next;
            self.path.pop();
        }
    }

    fn steps(&mut self, seconds: u64) -> Vec<Action> {
        (0..seconds * SECOND / STEP_NS).flat_map(|_| self.step()).collect()
    }

    fn go(&mut self, places: &[(u32, u32)]) -> Vec<Action> {
        let route = cells(places);
        self.tell(Event::Route(route))
    }
}

fn cells(places: &[(u32, u32)]) -> Vec<Cell> {
    let grid = scenario().terrain().grid();
    places.iter().map(|&(row, column)| grid.cell(Position { row, column }).unwrap()).collect()
}

fn sensed(actions: &[Action]) -> Vec<Cell> {
    let cell = |action: &Action| if let Action::Sensed { cell, .. } = action { Some(*cell) } else { None };
    actions.iter().filter_map(cell).collect()
}

fn readings(actions: &[Action]) -> Vec<Reading> {
    let readings = |action: &Action| match action {
        Action::Sensed { readings, .. } => readings.clone(),
        _ => Vec::new(),
    };
    actions.iter().flat_map(readings).collect()
}

fn is_hold(actions: &[Action]) -> bool {
    actions.contains(&Action::Hold)
}

fn is_drive(actions: &[Action]) -> bool {
    actions.iter().any(|action| matches!(action, Action::Drive(_)))
}

/// `name level` of each diagnostic.
fn reported(actions: &[Action]) -> Vec<String> {
    let reported = |action: &Action| match action {
        Action::Tell(Diagnostic { level, name, .. }) => Some(format!("{name} {level:?}")),
        _ => None,
    };
    actions.iter().filter_map(reported).collect()
}

fn message(actions: &[Action]) -> String {
    let message = |action: &Action| match action {
        Action::Tell(diagnostic) if diagnostic.level > Level::Ok => Some(diagnostic.message.clone()),
        _ => None,
    };
    actions.iter().find_map(message).unwrap_or_default()
}

#[test]
fn every_cell_of_a_route_is_reported_with_valid_readings() {
    let scenario = scenario();
    // Fine enough for turns at the vehicle's turning radius.
    let mut drive = Drive::on(&settings(), scenario.terrain(), 20);
    drive.objects = vec![Vector2::new(66.0, 47.0)];
    assert_eq!(sensed(&drive.step()), cells(&[(2, 2)]), "the cell that it starts in");
    let route = [(2, 3), (2, 4), (3, 5), (4, 6), (5, 6), (6, 6), (6, 5), (6, 4)];
    assert!(is_drive(&drive.go(&route)));
    let actions = drive.steps(60);
    let mut entered = sensed(&actions);
    // The object goes out of sight before its track is assigned to a cell.
    assert_eq!(entered.remove(0), cells(&[(2, 2)])[0], "a last observation from the cell that it leaves");
    assert_eq!(entered, cells(&route));
    assert_eq!(reported(&drive.actions), Vec::<String>::new());
    let ends: Vec<_> = drive.actions.iter().filter(|action| matches!(action, Action::Drive(_))).collect();
    assert_eq!(ends.len(), 4, "one plan for each straight run");

    let limits = Limits::of(&scenario);
    let mut log = ObservationLog::default();
    let (mut positions, mut told) = (Vec::new(), Vec::new());
    for action in &drive.actions {
        if let Action::Located(located) = action {
            assert!(positions.is_empty(), "an observation follows");
            positions.clone_from(located);
            told.extend(located.iter().copied());
        }
        let Action::Sensed { cell, readings } = action else { continue };
        let origin = Origin::first(RobotId::FIRST);
        let (sequence, time_ns) = (log.len(), log.len() * 5 * SECOND);
        let observation = Arc::new(Observation {
            origin,
            sequence,
            time_ns,
            from: *cell,
            readings: readings.clone(),
            positions: std::mem::take(&mut positions).into(),
        });
        assert_eq!(limits.check(&observation, log.ends(origin)), Ok(()));
        log.insert(observation);
    }
    let mut ones: BTreeMap<Cell, u32> = BTreeMap::new();
    let all = readings(&drive.actions);
    for reading in all.iter().filter(|reading| reading.value > 0.5) {
        *ones.entry(reading.cell).or_default() += 1;
    }
    assert_eq!(ones.keys().copied().collect::<Vec<_>>(), cells(&[(4, 6)]));
    assert!(all.len() > 60, "{}", all.len());
    assert!(all.iter().all(|reading| reading.cell != cells(&[(4, 6)])[0] || reading.value >= 0.5));
    let find = drive.pilot.find(cells(&[(4, 6)])[0]).unwrap();
    let off = find.position_meters - Vector2::new(66.0, 47.0);
    let std_meters = find.position_covariance.symmetric_eigenvalues().max().sqrt();
    assert!(off.norm() < 1.0 && std_meters < 1.0 && off.norm() < 4.0 * std_meters, "{off} {std_meters}");
    // Its position is told with observations that are made anyway, and again when it is better known.
    assert!(positions.is_empty() && !told.is_empty(), "{told:?}");
    assert!(told.iter().all(|position| position.cell() == cells(&[(4, 6)])[0]));
    for pair in told.windows(2) {
        assert!(pair[1].accuracy_meters() < 0.67 * pair[0].accuracy_meters(), "{told:?}");
    }
    let last = told.last().unwrap();
    assert!(last.accuracy_meters() < 1.5 * 2.45 * std_meters, "{last:?} {std_meters}");
    let (east, north) = last.meters();
    assert!((east - 66.0).hypot(north - 47.0) < last.accuracy_meters(), "{last:?}");
}

#[test]
fn the_initial_scan_lasts_a_turn_of_the_head() {
    let settings = Settings { initial_scan_seconds: 3.0, ..settings() };
    let mut drive = Drive::new(&settings);
    let first = (0..30).position(|_| !sensed(&drive.step()).is_empty());
    assert_eq!(first, Some(15));
}

#[test]
fn a_head_turns_the_view_of_its_cameras() {
    let settings = Settings { cameras: vec![settings().cameras.remove(0)], ..settings() };
    let mut drive = Drive::new(&settings);
    let turned = |drive: &Drive, camera: &Camera| {
        Some(CameraFrame { head_radians: std::f64::consts::PI, ..drive.frame(camera) })
    };
    drive.step_with(turned);
    drive.go(&[(2, 3)]);
    let actions: Vec<Action> = (0..30).flat_map(|_| drive.step_with(turned)).collect();
    let columns: Vec<u32> =
        readings(&actions).iter().map(|it| scenario().terrain().grid().position(it.cell).column).collect();
    assert!(columns.len() > 3 && columns.iter().all(|&column| column <= 3), "all behind: {columns:?}");
}

#[test]
fn a_vehicle_stands_without_a_route_and_with_an_empty_one() {
    let mut drive = Drive::new(&settings());
    assert!(!is_drive(&drive.steps(5)));
    drive.go(&[(2, 3), (2, 4)]);
    drive.steps(3);
    assert!(is_hold(&drive.go(&[])));
    let before = drive.pose;
    assert!(drive.steps(5).is_empty() && drive.pose == before);
}

#[test]
fn the_next_route_comes_in_time_and_the_vehicle_does_not_stop() {
    let mut drive = Drive::new(&settings());
    drive.step();
    drive.go(&[(2, 3), (2, 4)]);
    while sensed(&drive.step()) != cells(&[(2, 4)]) {}
    assert!(!is_drive(&drive.go(&[(3, 4), (4, 4)])), "first to the middle of the cell");
    let mut slowest = f64::INFINITY;
    for _ in 0..40 {
        let before = drive.pose;
        drive.step();
        slowest = slowest.min((drive.pose.position_meters() - before.position_meters()).norm());
    }
    assert!(slowest > 0.1, "{slowest}");
}

#[test]
fn a_vehicle_off_its_route_reports_its_cell() {
    let mut drive = Drive::new(&settings());
    drive.step();
    drive.go(&[(2, 3), (2, 4)]);
    drive.path.clear();
    drive.step();
    // The object is moved away, no faster than the vehicle drives.
    let mut found = Vec::new();
    for _ in 0..120 {
        drive.pose.y_meters += 0.4;
        drive.path.clear();
        found.extend(sensed(&drive.step()));
    }
    assert_eq!(found.first(), cells(&[(5, 2)]).first(), "far from all that is left of its route");
}

#[test]
fn an_object_outside_of_the_search_area_is_told_once_and_is_no_find() {
    let mut drive = Drive::new(&settings());
    drive.objects = vec![Vector2::new(126.0, 60.0)];
    drive.step();
    let east = (3..=10).map(|column| (2, column));
    let route: Vec<(u32, u32)> = east.chain((3..=9).map(|row| (row, 10))).collect();
    drive.go(&route);
    let actions = drive.steps(120);
    let is_outside = |diagnostic: &&Diagnostic| diagnostic.name == "objects";
    let told: Vec<&Diagnostic> = actions
        .iter()
        .filter_map(|action| if let Action::Tell(diagnostic) = action { Some(diagnostic) } else { None })
        .filter(is_outside)
        .collect();
    let [told] = told[..] else { panic!("{told:?}") };
    let [(_, x_meters), (_, y_meters)] = told.numbers[..] else { panic!("{told:?}") };
    assert!((x_meters - 126.0).hypot(y_meters - 60.0) < 3.0, "{told}");
    assert!(told.message.contains("outside of the search area"));
    assert_eq!(drive.pilot.finds().count(), 0);
}

#[test]
fn a_navigation_stack_is_sent_to_the_ends_of_runs() {
    let mut drive = Drive::new(&Settings { motion: MotionTable::Goal {}, ..settings() });
    drive.step();
    let actions = drive.go(&[(2, 3), (2, 4), (3, 4)]);
    assert_eq!(actions, [Action::Go(Pose::new(45.0, 25.0, 0.0))]);
    let failed = drive.tell(Event::Drive(Report::Failed("a wall".to_owned())));
    assert_eq!(message(&failed), "the drive failed: a wall");
    let next = Pose::new(45.0, 35.0, 1_f64.atan2(2.0));
    assert_eq!(failed.last(), Some(&Action::Go(next)), "on to the cells after those");
    drive.steps(4);
    let arrived = drive.tell(Event::Drive(Report::Arrived));
    assert!(message(&arrived).contains("ended before the cell was entered") && is_hold(&arrived));
    drive.go(&[(3, 4), (4, 4)]);
    let way = (1..=50).map(|step| f64::from(step) / 50.0);
    let entered: Vec<Action> = way
        .flat_map(|share| {
            drive.pose = Pose::new(25.0 + 15.5 * share, 25.0 + 9.0 * share, 0.0);
            drive.step()
        })
        .collect();
    assert_eq!(sensed(&entered), cells(&[(3, 4)]), "its border");
    let arrived = drive.tell(Event::Drive(Report::Arrived));
    assert!(matches!(arrived[..], [Action::Go(Pose { y_meters: 45.0, .. })]), "{arrived:?}");
}

fn any_event() -> impl Strategy<Value = Event> {
    let number = || prop_oneof![any::<f64>(), -20.0..140.0_f64];
    let pose = (number(), number(), number()).prop_map(|(x, y, heading)| Pose::new(x, y, heading));
    let time = prop_oneof![any::<u64>(), 0..20 * SECOND];
    let fix = (time.clone(), pose, number(), number()).prop_map(|(time_ns, pose, deviation, heading)| {
        let (deviation_meters, heading_deviation_radians) = (deviation, heading);
        Event::Pose(PoseEstimate { time_ns, pose, deviation_meters, heading_deviation_radians })
    });
    let edges = proptest::collection::vec((number(), number(), number(), number()), 0..6);
    let boxes = edges.prop_map(|edges| {
        let boxed = |(left, top, right, bottom)| DetectionBox { left, top, right, bottom };
        CameraDetections::Boxes(edges.into_iter().map(boxed).collect())
    });
    let bearings = proptest::collection::vec(number(), 0..6).prop_map(CameraDetections::Bearings);
    let detections = prop_oneof![boxes, bearings];
    let camera = prop_oneof![Just("front".to_owned()), Just("left".to_owned()), Just("none".to_owned())];
    let frame =
        (time, camera, number(), detections).prop_map(|(time_ns, camera, head_radians, detections)| {
            Event::Frame(CameraFrame { time_ns, camera, head_radians, detections })
        });
    let route =
        proptest::collection::vec((0..12_u32, 0..12_u32), 0..5).prop_map(|it| Event::Route(cells(&it)));
    let declared = proptest::collection::vec((0..12_u32, 0..12_u32), 0..5)
        .prop_map(|it| Event::Declared(cells(&it).into_iter().collect()));
    let report =
        prop_oneof![Just(Report::Arrived), Just(Report::Failed(String::new()))].prop_map(Event::Drive);
    prop_oneof![3 => fix, 3 => frame, 1 => route, 1 => declared, 1 => report, 1 => Just(Event::Tick)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// No input causes a panic, or a reading that the team would reject.
    #[test]
    fn nothing_that_comes_is_a_panic_or_bad_evidence(
        events in proptest::collection::vec((any_event(), prop_oneof![4 => 0..SECOND, 1 => any::<u64>()]), 1..60)
    ) {
        let scenario = scenario();
        let limits = Limits::of(&scenario);
        let mut drive = Drive::new(&settings());
        for (event, elapsed) in events {
            drive.now_ns = if elapsed > SECOND { elapsed } else { drive.now_ns.saturating_add(elapsed) };
            let mut positions = Vec::new();
            for action in drive.tell(event) {
                if let Action::Located(located) = &action {
                    positions.clone_from(located);
                }
                if let Action::Sensed { cell, readings } = action {
                    let origin = Origin::first(RobotId::FIRST);
                    let observation = Observation { origin, sequence: 0, time_ns: 0, from: cell, readings, positions: std::mem::take(&mut positions).into() };
                    prop_assert_eq!(limits.check(&Arc::new(observation), None), Ok(()));
                }
            }
        }
    }
}

/// Two cameras, of which one has half a second more latency; stamps that are equal, and stamps that differ by a
/// nanosecond.
#[test]
fn cameras_of_unlike_latency_are_put_into_the_order_of_their_stamps() {
    let mut drive = Drive::new(&settings());
    drive.objects = vec![Vector2::new(66.0, 25.0)];
    drive.step();
    drive.go(&[(2, 3), (2, 4)]);
    let mut late: std::collections::VecDeque<(u64, CameraFrame)> = std::collections::VecDeque::new();
    for number in 0..60 {
        drive.move_on();
        let fix = drive.fix();
        drive.tell(Event::Pose(fix));
        for camera in drive.cameras.clone() {
            let mut frame = drive.frame(&camera);
            frame.time_ns -= number % 2;
            if frame.camera == "front" {
                late.push_back((drive.now_ns + SECOND / 2, frame));
            } else {
                drive.tell(Event::Frame(frame.clone()));
                drive.tell(Event::Frame(frame));
            }
        }
        while late.front().is_some_and(|&(due_ns, _)| due_ns <= drive.now_ns) {
            let (_, frame) = late.pop_front().unwrap();
            drive.tell(Event::Frame(frame));
        }
    }
    assert_eq!(reported(&drive.actions), Vec::<String>::new());
    assert!(!drive.actions.iter().any(|action| matches!(action, Action::Refuse(..))));
    let most = drive.pilot.tracks().iter().map(crate::tracker::track::Track::hits).max();
    assert!(most > Some(50), "what only the slow camera sees: {most:?}");
}

#[test]
fn frames_from_before_the_first_pose_are_no_fault() {
    let mut drive = Drive::new(&settings());
    for _ in 0..3 {
        drive.move_on();
        for camera in drive.cameras.clone() {
            let frame = drive.frame(&camera);
            drive.tell(Event::Frame(frame));
        }
    }
    drive.steps(3);
    assert_eq!(reported(&drive.actions), Vec::<String>::new());
}

#[test]
fn a_frame_that_comes_later_than_the_window_is_rejected_and_counted() {
    let mut drive = Drive::new(&settings());
    drive.steps(3);
    let mut frame = drive.frame(&drive.cameras[0].clone());
    frame.time_ns -= 2 * SECOND;
    let actions = drive.tell(Event::Frame(frame));
    assert_eq!(reported(&actions), ["camera front Warning"]);
    assert!(message(&actions).contains("fusion_window_seconds"), "{actions:?}");
    assert!(actions.iter().any(|action| matches!(action, Action::Refuse(..))));
}

/// Two cameras that face ahead, four meters apart: they measure range without moving.
fn eyes_apart() -> Settings {
    let camera = |name: &str, y_meters| CameraTable {
        name: name.to_owned(),
        y_meters: Some(y_meters),
        column_std_pixels: 1.0,
        ..CameraTable::wide()
    };
    Settings { cameras: vec![camera("left", 2.0), camera("right", -2.0)], ..settings() }
}

/// The evidence of all readings of each cell, nats.
fn evidence(actions: &[Action]) -> BTreeMap<Cell, f64> {
    let mut nats = BTreeMap::new();
    for reading in readings(actions) {
        *nats.entry(reading.cell).or_insert(0.0) += reading.evidence().log_likelihood_ratio_nats();
    }
    nats
}

/// More than a second in which the vehicle's position is known exactly: then two cameras measure the range.
fn stand(drive: &mut Drive, seconds: u64) -> Vec<Action> {
    let before = drive.actions.len();
    for _ in 0..seconds * SECOND / STEP_NS {
        drive.now_ns += STEP_NS;
        let fix = PoseEstimate { deviation_meters: 0.0, heading_deviation_radians: 0.0, ..drive.fix() };
        drive.tell(Event::Pose(fix));
        for camera in drive.cameras.clone() {
            let frame = drive.frame(&camera);
            drive.tell(Event::Frame(frame));
        }
    }
    drive.actions[before..].to_vec()
}

#[test]
fn finds_of_a_standing_vehicle_are_reported() {
    let mut drive = Drive::new(&eyes_apart());
    assert_eq!(sensed(&stand(&mut drive, 1)), cells(&[(2, 2)]));
    drive.objects = vec![Vector2::new(44.0, 26.0)];
    let (own, home) = (cells(&[(2, 2)])[0], cells(&[(2, 4)])[0]);
    let actions = stand(&mut drive, 60);
    let reported = evidence(&drive.actions);
    assert!(reported.get(&home).is_some_and(|nats| (nats - 20.0).abs() < 0.1), "{reported:?}");
    assert!(sensed(&actions).iter().all(|&cell| cell == own));
    assert!((1..=12).contains(&sensed(&actions).len()), "{}", sensed(&actions).len());
    assert!(reported.iter().all(|(&cell, &nats)| cell == home || nats < 0.1), "{reported:?}");
    assert!(stand(&mut drive, 60).is_empty(), "there is no more news");
}

#[test]
fn a_standing_vehicle_reports_an_object_and_its_departure() {
    let mut drive = Drive::new(&settings());
    drive.steps(4);
    // Bearings from one position alone do not give the range.
    drive.objects = vec![Vector2::new(66.0, 25.0)];
    let open = drive.steps(6);
    assert_eq!(sensed(&open).len(), 1, "once");
    assert!(readings(&open).iter().any(Reading::is_undecided));
    assert!(evidence(&open).values().all(|nats| nats.abs() < 1e-3), "nothing was told before");
    drive.objects.clear();
    let gone = drive.steps(60);
    assert_eq!(sensed(&gone).len(), 1, "{gone:?}");
    assert!(!readings(&gone).iter().any(Reading::is_undecided));
}
