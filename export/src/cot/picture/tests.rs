use std::path::Path;
use std::sync::Arc;

use dragnet_coordinator::mission::{self, CoordinatorConfig};
use dragnet_proto::command::Command;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Intent, Message, MissionStatus};
use dragnet_proto::state_machine;
use dragnet_proto::zones::Zone;
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::mark::{Clue, Mark};
use dragnet_search::observation::{Observation, Origin, Versions};

use super::*;

const PERIOD: Duration = Duration::from_secs(5);
/// Where the mission time is 0: 2026-01-01.
const START_UNIX_NS: u64 = 1_767_225_600_000_000_000;

/// Cells of 20 m whose south-western corner lies at 47.5 N, 9.5 E; robot 2 flies.
const SCENARIO: &str = "name = 'site'\n\
    map = { shape = 'all_traversable', rows = 5, columns = 6, cell_meters = 20.0, origin = { latitude_degrees = 47.5, longitude_degrees = 9.5 } }\n\
    objects.count = 1\nsensor.radius = 4\nclasses.drone.flies = true\n[robots]\ncount = 2\nrobot = [{ number = 2, class = 'drone' }]\n\
    [mission]\nbudget_meters = 2000.0\nspeed_meters_per_second = 100.0\n";

fn scenario(text: &str) -> Scenario {
    Scenario::from_text(Path::new("site.toml"), text.to_owned()).unwrap()
}

/// A coordinator, and the picture of its records.
struct Site {
    scenario: Scenario,
    coordinator: mission::Mission,
    picture: Picture,
    now: MissionTime,
}

impl Site {
    fn new() -> Self {
        Self::of(scenario(SCENARIO))
    }

    fn of(scenario: Scenario) -> Self {
        let mission =
            Mission { name: "valley", scenario: &scenario, source: Source::Field, real_time_factor: 1.0 };
        let picture = Picture::new(&mission).unwrap();
        let coordinator = mission::Mission::new(CoordinatorConfig::of(&scenario));
        let mut site = Self { scenario, coordinator, picture, now: MissionTime::START };
        site.react(state_machine::Event::Start);
        site
    }

    fn unix_ns(&self) -> u64 {
        START_UNIX_NS + self.now.0
    }

    fn react(&mut self, event: state_machine::Event<Message>) {
        let outcome = self.coordinator.react(self.now, event);
        let unix_ns = self.unix_ns();
        for record in &outcome.records {
            self.picture.take(self.now, unix_ns, record);
        }
    }

    /// Second by second, as its driver does.
    fn pass(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.now = self.now + Duration::from_secs(1);
            self.react(state_machine::Event::Woke);
        }
    }

    fn receive(&mut self, robot: u16, message: Message) {
        let from = Participant::Robot(RobotId::new(robot).unwrap());
        self.react(state_machine::Event::Received { from, message });
    }

    fn cell(&self, row: u32, column: u32) -> Cell {
        let grid = self.scenario.terrain().grid();
        grid.cells().nth((row * grid.columns() + column) as usize).unwrap()
    }

    fn heartbeat(&mut self, number: u16, activity: Activity, cell: Cell) {
        let robot = RobotId::new(number).unwrap();
        let intent = Intent {
            robot,
            incarnation: 0,
            decision: 0,
            time_ns: self.now.0,
            path: [].into_iter().collect(),
        };
        let heartbeat = Heartbeat {
            robot,
            time_ns: self.now.0,
            activity,
            cell,
            path_meters: 340.0,
            intent,
            versions: Versions::default(),
            digest: Digest(0),
            directive: Directive::default(),
        };
        self.receive(number, Message::Heartbeat(heartbeat));
    }

    /// Robot 1 sees an object, or that there is none.
    fn observe(&mut self, sequence: u64, from: Cell, seen: Cell, nats: f32) {
        let origin = Origin::first(RobotId::FIRST);
        let readings = vec![Reading { cell: seen, value: 0.5 + nats, variance: 1.0 }];
        let observation =
            Observation { origin, sequence, time_ns: self.now.0, from, readings, positions: Box::default() };
        self.receive(1, Message::Observation(Arc::new(observation)));
        assert!(self.coordinator.replica().rejected().is_empty());
    }

    /// Robot 1 knows where an object is.
    fn locate(&mut self, sequence: u64, from: Cell, position: ObjectPosition) {
        let (origin, time_ns, readings) = (Origin::first(RobotId::FIRST), self.now.0, Vec::new());
        let observation =
            Observation { origin, sequence, time_ns, from, readings, positions: [position].into() };
        self.receive(1, Message::Observation(Arc::new(observation)));
        assert!(self.coordinator.replica().rejected().is_empty());
    }

    fn command(&mut self, command: Command) {
        self.react(state_machine::Event::Commanded(command));
    }

    fn events(&mut self) -> Vec<Event> {
        let unix_ns = self.unix_ns();
        self.picture.events(unix_ns, PERIOD)
    }

    /// The names and types of the events now.
    fn shown(&mut self) -> Vec<(String, &'static str)> {
        let events = self.events().into_iter();
        events.map(|event| (event.uid.replace("dragnet.valley.", ""), event.kind)).collect()
    }
}

fn named<'a>(events: &'a [Event], name: &str) -> &'a Event {
    let uid = format!("dragnet.valley.{name}");
    events.iter().find(|event| event.uid == uid).unwrap_or_else(|| panic!("{name}: {events:?}"))
}

#[test]
fn a_robot_is_a_unit_in_its_cell_that_becomes_stale_when_it_is_lost() {
    let mut site = Site::new();
    assert!(site.events().is_empty(), "no robot has said where it is");
    site.pass(1);
    let [start, next] = [site.cell(1, 1), site.cell(2, 2)];
    site.heartbeat(1, Activity::Searching, start);
    site.heartbeat(2, Activity::Waiting, start);
    site.pass(4);
    site.heartbeat(1, Activity::Returning, next);
    site.heartbeat(2, Activity::Waiting, start);
    let events = site.events();
    let rover = named(&events, "robot-1");
    assert_eq!((rover.kind, rover.how), ("a-f-G-E-V", "m-g"));
    assert_eq!((rover.time_unix_ns, rover.stale), (START_UNIX_NS + 5_000_000_000, 4 * PERIOD));
    let [east, north] = [rover.point.longitude_degrees - 9.5, rover.point.latitude_degrees - 47.5];
    assert!((north * 111_185.0 - 50.0).abs() < 0.1 && (east * 75_349.0 - 50.0).abs() < 0.1, "{rover:?}");
    assert!((rover.error_meters.unwrap() - 14.14).abs() < 0.01);
    let Detail::Unit { callsign, remarks, motion: Some(motion) } = &rover.detail else { panic!("{rover:?}") };
    assert_eq!(callsign, "Robot 1 (valley)");
    assert_eq!(remarks, "it returns to its base; 340 m driven of at most 2000 m");
    assert!((motion.course_degrees - 45.0).abs() < 0.1, "{motion:?}");
    assert!((motion.speed_meters_per_second - 800.0_f64.sqrt() / 4.0).abs() < 0.1, "{motion:?}");
    let drone = named(&events, "robot-2");
    assert_eq!(drone.kind, "a-f-A-M-H-Q");
    let Detail::Unit { remarks, motion: None, .. } = &drone.detail else { panic!("{drone:?}") };
    assert!(remarks.starts_with("drone: its teammates are to observe"), "{remarks}");
    // Robot 2 is not heard any more.
    for _ in 0..60 {
        site.pass(1);
        site.heartbeat(1, Activity::Paused, next);
    }
    assert_eq!(site.shown(), [("robot-1".to_owned(), "a-f-G-E-V")]);
    let events = site.events();
    let Detail::Unit { motion: Some(motion), .. } = &named(&events, "robot-1").detail else { panic!() };
    assert!(motion.speed_meters_per_second.to_bits() == 0, "it stands: {motion:?}");
}

#[test]
fn a_find_is_a_marker_until_it_is_dismissed_and_then_removed() {
    let mut site = Site::new();
    site.pass(2);
    let [from, seen] = [site.cell(2, 3), site.cell(3, 4)];
    site.observe(0, from, seen, 7.0);
    site.pass(8);
    let events = site.events();
    let find = named(&events, &format!("find-{}", seen.number()));
    assert_eq!((find.kind, find.stale), ("b-m-p-s-m", Duration::from_hours(1)));
    let [east, north] = [find.point.longitude_degrees - 9.5, find.point.latitude_degrees - 47.5];
    assert!((north * 111_185.0 - 70.0).abs() < 0.1 && (east * 75_349.0 - 90.0).abs() < 0.1, "{find:?}");
    let Detail::Marker { callsign, remarks, color } = &find.detail else { panic!("{find:?}") };
    assert_eq!((callsign.as_str(), *color), ("Find 1 (valley)", YELLOW));
    assert!(
        remarks.starts_with("object (9") && remarks.contains(" %) at [3, 4], not confirmed"),
        "{remarks}"
    );
    assert!(remarks.contains("Found by robot 1 at 2026-01-01T00:00:0"), "{remarks}");
    // Its time stays, however often it is told.
    let told = remarks.clone();
    site.pass(30);
    let events = site.events();
    let Detail::Marker { remarks, .. } = &named(&events, &format!("find-{}", seen.number())).detail else {
        panic!()
    };
    assert_eq!(*remarks, told);
    site.command(Command::Judge(Decision::Confirmed, seen));
    site.pass(2);
    let events = site.events();
    let Detail::Marker { remarks, color: GREEN, .. } = &events.last().unwrap().detail else { panic!() };
    assert!(remarks.contains("confirmed by the operator"), "{remarks}");
    site.command(Command::Judge(Decision::Dismissed, seen));
    site.pass(2);
    let uid = format!("find-{}", seen.number());
    for _ in 0..REMOVALS {
        let events = site.events();
        let removal = named(&events, &format!("{uid}.removal"));
        assert_eq!(removal.kind, "t-x-d-d");
        assert_eq!(removal.detail, Detail::Removal { uid: format!("dragnet.valley.{uid}") });
        assert!(events.iter().all(|event| event.kind != "b-m-p-s-m"), "{events:?}");
    }
    assert!(site.events().iter().all(|event| event.kind != "t-x-d-d"), "a removal is not sent for ever");
    // It is declared again, and keeps its number; what is shown is not removed.
    site.command(Command::Judge(Decision::Undone, seen));
    site.pass(2);
    let events = site.events();
    let Detail::Marker { callsign, .. } = &named(&events, &uid).detail else { panic!() };
    assert_eq!(callsign, "Find 1 (valley)");
    assert!(events.iter().all(|event| event.kind != "t-x-d-d"), "{events:?}");
}

#[test]
fn a_find_that_a_robot_has_located_is_at_its_position_with_its_error() {
    let mut site = Site::new();
    site.pass(2);
    let [from, seen] = [site.cell(2, 3), site.cell(3, 4)];
    let position = ObjectPosition::new(seen, [97.0, 62.0], [0.25, 0.0, 1.0]).unwrap();
    site.observe(0, from, seen, 7.0);
    site.locate(1, from, position);
    site.pass(8);
    let events = site.events();
    let find = named(&events, &format!("find-{}", seen.number()));
    let [east, north] = [find.point.longitude_degrees - 9.5, find.point.latitude_degrees - 47.5];
    assert!((north * 111_185.0 - 62.0).abs() < 0.1 && (east * 75_349.0 - 97.0).abs() < 0.1, "{find:?}");
    assert!((find.error_meters.unwrap() - 2.448).abs() < 1e-3);
    let Detail::Marker { remarks, .. } = &find.detail else { panic!("{find:?}") };
    assert!(remarks.contains(" at [3, 4] (within 2.5 m with 95 % probability), not confirmed"), "{remarks}");
}

#[test]
fn closed_cells_are_a_shape_until_they_are_opened() {
    let mut site = Site::new();
    site.pass(1);
    let cells = vec![site.cell(0, 0), site.cell(0, 1)];
    site.command(Command::Zone(Zone::NoGo, cells.clone()));
    assert_eq!(site.shown(), [("order-1-1".to_owned(), "u-d-f")]);
    let events = site.events();
    let Detail::Shape { callsign, corners, .. } = &events[0].detail else { panic!("{events:?}") };
    assert_eq!((callsign.as_str(), corners.len()), ("No-go by order", 5));
    site.command(Command::Zone(Zone::Open, cells));
    assert_eq!(site.shown(), [("order-1-1.removal".to_owned(), "t-x-d-d")]);
}

#[test]
fn a_clue_is_a_spot_with_its_radius_until_it_is_withdrawn() {
    let mut site = Site::new();
    site.pass(1);
    let clue = Clue { cell: site.cell(2, 3), ratio_thousandths: 20_000, radius_hundredths: 200 };
    site.command(Command::Mark(Mark::Clue(clue), "a glove & a hat".to_owned()));
    let id = format!("clue-{}", site.now.0);
    assert_eq!(site.shown(), [(id.clone(), "b-m-p-s-m")]);
    let events = site.events();
    let Detail::Marker { callsign, remarks, color } = &events[0].detail else { panic!("{events:?}") };
    assert_eq!((callsign.as_str(), *color), ("Clue 1 (valley)", PURPLE));
    assert!(remarks.contains("20 to 1 for an object within about 40 m: a glove & a hat"), "{remarks}");
    assert_eq!(events[0].error_meters, Some(40.0));
    site.command(Command::Unmark(site.now.0));
    assert_eq!(site.shown(), [(format!("{id}.removal"), "t-x-d-d")]);
}

#[test]
fn cells_that_are_added_to_the_search_are_a_shape() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("site.txt"), "....\n..,,\n").unwrap();
    let text = SCENARIO.replace("shape = 'all_traversable', rows = 5, columns = 6", "file = 'site.txt'");
    let text = text.replace("sensor.radius = 4", "sensor.radius = 2");
    let scenario = Scenario::from_text(&folder.path().join("site.toml"), text).unwrap();
    let mut site = Site::of(scenario);
    site.command(Command::Search(vec![site.cell(0, 2), site.cell(0, 3)]));
    site.pass(2);
    assert_eq!(site.shown(), [("added-1-1".to_owned(), "u-d-f")]);
}

#[test]
fn a_simulation_says_so_and_dates_its_finds_by_the_wall_clock() {
    let scenario = scenario(SCENARIO);
    let facts =
        Mission { name: "valley", scenario: &scenario, source: Source::Simulation, real_time_factor: 10.0 };
    let mut picture = Picture::new(&facts).unwrap();
    let cell = scenario.terrain().grid().cells().last().unwrap();
    let status = MissionStatus {
        time_ns: 100_000_000_000,
        declared: vec![Detection { cell, probability: 0.99, time_ns: 60_000_000_000 }],
        expected_remaining: 0.0,
        alive: Vec::new(),
        observations: 0,
        versions: Versions::default(),
        digest: Digest(0),
        directive: Directive::default(),
        doubled: Vec::new(),
    };
    picture.take(MissionTime(100_000_000_000), START_UNIX_NS, &Record::Status(status));
    let events = picture.events(START_UNIX_NS, PERIOD);
    let [Event { detail: Detail::Marker { callsign, remarks, .. }, .. }] = &events[..] else {
        panic!("{events:?}")
    };
    assert_eq!(callsign, "Find 1 (valley, simulated)");
    assert!(remarks.ends_with("at 2025-12-31T23:59:56.000Z"), "40 s of the mission ago: {remarks}");
}

#[test]
fn a_map_that_is_not_on_the_earth_is_rejected_with_what_is_needed() {
    let scenario = scenario(
        "name = 'a'\nmap = { shape = 'all_traversable', rows = 2, columns = 4 }\nrobots.count = 1\nobjects.count = 1\nsensor.radius = 2\n\
         mission.budget_seconds = 60.0\n",
    );
    let facts = Mission { name: "valley", scenario: &scenario, source: Source::Field, real_time_factor: 1.0 };
    let error = Picture::new(&facts).unwrap_err().to_string();
    assert!(error.contains("map.origin") && error.contains("latitude_degrees"), "{error}");
}
