//! A vehicle without its network: events in, effects out.

mod network;

use std::path::Path;

use dragnet_lattice::plane::bearing_radians;
use dragnet_ros2::input::{Detections, Odometry, PlanarPose, PoseEstimate, Velocity};
use dragnet_ros2::output::{Level, ObjectEstimate, PlanarEstimate};
use dragnet_search::cell::Position;
use dragnet_search::object_position::{ObjectPosition, ObjectPositions};
use dragnet_search::observation::{Observation, Origin, RobotId};

use super::*;
use crate::config::{AgentSettings, OwnVehicle};
use crate::mentions::assert_mentions;

const PATIENT: &str = "safety = { pose_timeout_seconds = 60.0, camera_timeout_seconds = 60.0 }";

/// Robot 1 of a field of 4 x 4 cells of 20 m, moved by the lattice or by goals, with long timeouts.
fn vehicle(motion: &str) -> (Vehicle, Scenario) {
    vehicle_with(motion, PATIENT, "arrival")
}

/// The same with these safety settings, and this meaning of stamps.
fn vehicle_with(motion: &str, safety: &str, stamps: &str) -> (Vehicle, Scenario) {
    let text = "name = 'field'\nmap = { shape = 'all_traversable', rows = 4, columns = 4, cell_meters = 20.0 }\n\
                objects.count = 1\nsensor.radius = 2\n[mission]\nbudget_seconds = 900.0\nspeed_meters_per_second = 10.0\n";
    let scenario = Scenario::from_text(Path::new("field.toml"), text.to_owned()).unwrap();
    let settings = format!(
        "robot = 1\ncommon = {{ mission = 'field', scenario = 'field.toml' }}\n\
         [vehicle]\nspeed_meters_per_second = 10.0\nfootprint = {{ shape = 'disc', radius_meters = 0.5 }}\n\
         motion = {{ kind = '{motion}' }}\n{safety}\n\
         [ros]\ntransport = 'bridge'\nlocalization = 'odometry'\nodometry_frame = 'map'\nstamps = '{stamps}'\n"
    );
    let config: AgentSettings = toml::from_str(&settings).unwrap();
    let own = config.vehicle(Path::new("vehicle.toml"), &scenario).unwrap();
    let Some(OwnVehicle::Ros(body)) = own else { panic!("{own:?}") };
    (Vehicle::new(body.pilot, &body.ros, &scenario), scenario)
}

fn topic(name: &str) -> TopicName {
    TopicName::resolve(name, &"".parse().unwrap(), &"dragnet".parse().unwrap()).unwrap()
}

fn odometry(stamp_unix_ns: i64, x_meters: f64) -> Incoming {
    let pose = PlanarPose { x_meters, y_meters: 10.0, yaw_radians: 0.0 };
    let covariance = Some([[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]]);
    let place = PoseEstimate { stamp_unix_ns, frame: "map".to_owned(), pose, covariance };
    Incoming::Odometry(Odometry { place, robot_frame: String::new(), velocity: Velocity::default() })
}

/// A pose at this time; returns the effects.
fn stand(vehicle: &mut Vehicle, seconds: u64, x_meters: f64) -> Vec<Effect> {
    let now = Now { mission: MissionTime::START + Duration::from_secs(seconds), unix_ns: 0 };
    let mut effects = vehicle.receive(now, &topic("/odom"), odometry(0, x_meters));
    effects.extend(vehicle.tick(now));
    effects
}

/// Published paths and goals, and diagnostics.
#[derive(Debug, Default, PartialEq)]
struct Reported {
    /// Meters to the east of the begin and the end of each path, for a goal twice the same; rounded.
    paths: Vec<[i64; 2]>,
    levels: Vec<Level>,
}

fn reported(effects: &[Effect]) -> Reported {
    #[expect(clippy::cast_possible_truncation, reason = "meters of a small map")]
    let rounded = |pose: &PlanarPose| pose.x_meters.round() as i64;
    let mut reported = Reported::default();
    for effect in effects {
        match effect {
            Effect::Publish(Output::Path(poses)) => {
                reported
                    .paths
                    .extend(poses.first().zip(poses.last()).map(|(from, to)| [from, to].map(rounded)));
            }
            Effect::Publish(Output::Goal(pose)) => reported.paths.push([rounded(pose); 2]),
            Effect::Tell(news) => reported.levels.push(news.level),
            _ => {}
        }
    }
    reported
}

/// Follows a route of two cells to the east from its position.
fn set_out(vehicle: &mut Vehicle, scenario: &Scenario) -> Reported {
    stand(vehicle, 0, 10.0);
    let grid = scenario.terrain().grid();
    let route = [1, 2].map(|column| grid.cell(Position { row: 0, column }).unwrap()).to_vec();
    reported(&vehicle.heed(Now { mission: MissionTime::START, unix_ns: 0 }, Event::Route(route)))
}

fn way(from: i64, to: i64) -> Reported {
    Reported { paths: vec![[from, to]], levels: Vec::new() }
}

fn again(from: i64, to: i64) -> Reported {
    Reported { levels: vec![Level::Warning], ..way(from, to) }
}

#[test]
fn the_rest_of_a_path_is_published_again_to_a_standing_vehicle() {
    let (mut vehicle, scenario) = vehicle("lattice");
    assert_eq!(set_out(&mut vehicle, &scenario), way(10, 50));
    // The path follower was not there yet.
    for seconds in 1..=5 {
        assert_eq!(reported(&stand(&mut vehicle, seconds, 10.0)), Reported::default());
    }
    assert_eq!(reported(&stand(&mut vehicle, 6, 10.0)), again(10, 50));
    // It drives, and stands again.
    let well = Reported { levels: vec![Level::Ok], ..Reported::default() };
    for (seconds, expected) in
        [(8, Reported::default()), (11, well), (12, Reported::default()), (13, Reported::default())]
    {
        assert_eq!(reported(&stand(&mut vehicle, seconds, 26.0)), expected);
    }
    assert_eq!(reported(&stand(&mut vehicle, 14, 26.0)), again(26, 50));
    // At its end nothing is left to drive.
    stand(&mut vehicle, 16, 50.0);
    for seconds in 17..30 {
        assert!(reported(&stand(&mut vehicle, seconds, 50.0)).paths.is_empty());
    }
}

#[test]
fn a_goal_that_is_not_accepted_is_published_again() {
    let (mut vehicle, scenario) = vehicle("goal");
    assert_eq!(set_out(&mut vehicle, &scenario), way(50, 50));
    for seconds in 1..=5 {
        assert_eq!(reported(&stand(&mut vehicle, seconds, 10.0)), Reported::default());
    }
    assert_eq!(reported(&stand(&mut vehicle, 6, 10.0)), again(50, 50));
}

#[test]
fn a_belief_that_stands_is_shown_again() {
    let (mut vehicle, scenario) = vehicle("lattice");
    let now = Now { mission: MissionTime::START, unix_ns: 0 };
    let changes = [true, false, false, false, false, false, true, true, false];
    let is_shown = |effect: &Effect| matches!(effect, Effect::Publish(Output::Belief(..)));
    let shown = changes.map(|has_changed| {
        vehicle.show(now, scenario.prior(), &ObjectPositions::default(), has_changed).iter().any(is_shown)
    });
    assert_eq!(shown, [true, false, false, false, false, true, true, true, false]);
}

/// A constant stamp, forty times a second for a minute.
#[test]
fn constant_stamps_are_reported_once_and_all_messages_counted() {
    let (mut vehicle, _) = vehicle_with("lattice", "", "clock");
    let mut news: Vec<Diagnostic> = Vec::new();
    for tick in 0..60 * 40 {
        let mission = MissionTime(1_000_000_000 + tick * 25_000_000);
        let now = Now { mission, unix_ns: 1_700_000_000_000_000_000_i64.saturating_add_unsigned(mission.0) };
        let mut effects = vehicle.receive(now, &topic("/odom"), odometry(1_700_000_001_000_000_000, 10.0));
        effects.extend(vehicle.tick(now));
        news.extend(effects.into_iter().filter_map(|effect| match effect {
            Effect::Tell(diagnostic) => Some(diagnostic),
            _ => None,
        }));
    }
    let of_pose: Vec<&str> = news
        .iter()
        .filter(|reported| reported.name == "dragnet: pose")
        .map(|reported| reported.message.as_str())
        .collect();
    let &[cause] = &of_pose[..] else { panic!("{of_pose:?}") };
    assert_mentions(cause, "stamps stand still .. `stamps = \"arrival\"`");
    let refused = &vehicle.refused()[&topic("/odom")];
    assert!(refused.count > 2000 && refused.reason == cause, "{refused:?}");
}

#[test]
fn where_no_pose_comes_the_topic_is_named() {
    let (mut vehicle, _) = vehicle_with("lattice", "", "clock");
    let why = |vehicle: &mut Vehicle, seconds: u64| {
        let now = Now { mission: MissionTime(seconds * 1_000_000_000), unix_ns: 0 };
        let reported = vehicle.tick(now).into_iter().find_map(|effect| match effect {
            Effect::Tell(diagnostic) if diagnostic.name == "dragnet: pose" => Some(diagnostic.message),
            _ => None,
        });
        reported.unwrap_or_default()
    };
    assert_eq!(why(&mut vehicle, 0), "");
    let now = Now { mission: MissionTime(500_000_000), unix_ns: 0 };
    let reason = "frame_id is \"odom\"".to_owned();
    vehicle.receive(now, &topic("/odom"), Incoming::Rejected { topic: topic("/odom"), reason });
    assert_mentions(
        &why(&mut vehicle, 2),
        "no pose .. /odom .. no message .. rejected .. frame_id is \"odom\"",
    );
}

/// The robot drives past an object at (45, 25) and publishes it in meters, with the covariance; of teammates' finds it knows
/// the position or the cell only.
#[test]
fn finds_are_published_with_position_and_covariance() {
    let (mut vehicle, scenario) = vehicle("lattice");
    let (terrain, mut belief) = (scenario.terrain(), scenario.prior().clone());
    let thing = Pose::new(45.0, 25.0, 0.0);
    let camera = Arc::<str>::from(vehicle.pilot.cameras().next().unwrap());
    let lens = vehicle.pilot.camera(&camera).unwrap().clone();
    for tick in 0..90_u64 {
        let here = Pose::new(5.0 + tick as f64 / 2.0, 10.0, 0.0);
        let now = Now { mission: MissionTime(tick * 100_000_000), unix_ns: 0 };
        let mut effects = vehicle.receive(now, &topic("/odom"), odometry(0, here.x_meters));
        let bearing = bearing_radians(here.position_meters(), thing.position_meters());
        let boxes = lens.column_pixels(bearing).map(|x| DetectedBox {
            left: x - 5.0,
            right: x + 5.0,
            top: 500.0,
            bottom: 520.0,
            hypothesis: None,
        });
        let boxes = boxes.into_iter().collect();
        let detections = Detections { stamp_unix_ns: 0, frame: String::new(), boxes };
        effects.extend(vehicle.receive(
            now,
            &topic("/camera"),
            Incoming::Detections { camera: camera.clone(), detections },
        ));
        effects.extend(vehicle.tick(now));
        for effect in effects {
            if let Effect::Sensed { readings, .. } = effect {
                for reading in &readings {
                    belief.add(reading);
                }
            }
        }
    }
    let far = terrain.grid().cell(Position { row: 3, column: 0 }).unwrap();
    belief.add(&Reading { cell: far, value: 1.0, variance: 0.02 });
    let located = terrain.grid().cell(Position { row: 3, column: 1 }).unwrap();
    belief.add(&Reading { cell: located, value: 1.0, variance: 0.02 });
    let position = ObjectPosition::new(located, [32.5, 68.0], [0.25, 0.1, 0.5]).unwrap();
    let mut positions = ObjectPositions::default();
    positions.add(&Observation {
        origin: Origin::first(RobotId::new(2).unwrap()),
        sequence: 0,
        time_ns: 0,
        from: located,
        readings: Vec::new(),
        positions: [position].into(),
    });
    let now = Now { mission: MissionTime(9_000_000_000), unix_ns: 0 };
    let (mut objects, mut tracks) = (Vec::new(), Vec::new());
    for effect in vehicle.show(now, &belief, &positions, true) {
        match effect {
            Effect::Publish(Output::Objects(estimates)) => objects = estimates,
            Effect::Publish(Output::Tracks(estimates)) => tracks = estimates,
            _ => {}
        }
    }
    let [own, other, known] = &objects[..] else { panic!("{objects:?}") };
    let [track] = &tracks[..] else { panic!("{tracks:?}") };
    for estimate in [own, track] {
        let place = estimate.place;
        let off = (place.x_meters - thing.x_meters).hypot(place.y_meters - thing.y_meters);
        assert!(off < 0.5 && place.std_meters()[0] < 1.0 && place.std_meters()[1] > 0.0, "{estimate:?}");
        assert!(estimate.probability > 0.9);
    }
    let middle = |object: &ObjectEstimate| (object.box_center.x_meters, object.box_center.y_meters);
    assert_eq!((middle(own).1, own.box_edges_meters), (30.0, [20.0; 2]));
    assert_eq!((other.place, middle(other)), (PlanarEstimate::in_square(10.0, 70.0, 20.0), (10.0, 70.0)));
    let PlanarEstimate { x_meters, y_meters, covariance_square_meters: [[xx, xy], [_, yy]] } = known.place;
    assert_eq!((x_meters, y_meters, middle(known)), (32.5, 68.0, (30.0, 70.0)));
    assert!((xx - 0.25).abs() + (xy - 0.1).abs() + (yy - 0.5).abs() < 1e-6, "{known:?}");
}
