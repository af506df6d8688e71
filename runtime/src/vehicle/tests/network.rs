//! A vehicle whose network says where it is, how its cameras are mounted, and when it must stand.

use dragnet_ros2::input::{Battery, CameraInfo, Distortion, Transform, Transforms};

use super::*;

/// Unix time of the mission's start, nanoseconds.
const START_NS: i64 = 1_700_000_000_000_000_000;
const MILLISECOND: i64 = 1_000_000;

/// A robot with one camera that its network describes, and these further settings of `[ros]`.
fn measured(ros: &str) -> Vehicle {
    let text = "name = 'field'\nmap = { shape = 'all_traversable', rows = 4, columns = 4, cell_meters = 20.0 }\n\
                objects.count = 1\nsensor.radius = 2\n[mission]\nbudget_seconds = 900.0\nspeed_meters_per_second = 10.0\n";
    let scenario = Scenario::from_text(Path::new("field.toml"), text.to_owned()).unwrap();
    let settings = format!(
        "robot = 1\ncommon = {{ mission = 'field', scenario = 'field.toml' }}\n\
         [vehicle]\nspeed_meters_per_second = 10.0\nmotion = {{ kind = 'goal' }}\n\
         cameras = [{{ name = 'front', max_range_meters = 30.0 }}]\n\
         [ros]\ntransport = 'rmw_zenoh'\nlocalization = 'tf'\n\
         cameras = [{{ name = 'front', detections = 'seen', camera_info = 'info' }}]\n{ros}\n"
    );
    let config: AgentSettings = toml::from_str(&settings).unwrap();
    let own = config.vehicle(Path::new("vehicle.toml"), &scenario).unwrap();
    let Some(OwnVehicle::Ros(body)) = own else { panic!("{own:?}") };
    Vehicle::new(body.pilot, &body.ros, &scenario)
}

/// So many milliseconds after the start.
fn at(milliseconds: i64) -> Now {
    Now {
        mission: MissionTime((milliseconds * MILLISECOND).unsigned_abs()),
        unix_ns: START_NS + milliseconds * MILLISECOND,
    }
}

fn transform(edge: &str, now: Now, translation_meters: [f64; 3], rotation: [f64; 4]) -> Transform {
    let (parent, child) = edge.split_once(" -> ").unwrap();
    let (parent, child) = (parent.to_owned(), child.to_owned());
    Transform { stamp_unix_ns: now.unix_ns, parent, child, translation_meters, rotation }
}

fn said(valid: Vec<Transform>) -> Transforms {
    Transforms { valid, rejected: Vec::new() }
}

const LEVEL: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// x to the right, y down, z forward.
const OPTICAL: [f64; 4] = [-0.5, 0.5, -0.5, 0.5];

/// The vehicle at this place; localization dates its transform ahead.
fn stand_at(vehicle: &mut Vehicle, now: Now, x_meters: f64) -> Vec<Effect> {
    let ahead = Now { unix_ns: now.unix_ns + 500 * MILLISECOND, ..now };
    let odometry = transform("odom -> base_link", now, [x_meters, 0.0, 0.0], LEVEL);
    let map = transform("map -> odom", ahead, [0.0, 10.0, 0.0], LEVEL);
    vehicle.receive(now, &topic("/tf"), Incoming::Transforms(said(vec![map, odometry])))
}

fn mount(vehicle: &mut Vehicle, now: Now) -> Vec<Effect> {
    let mounting = transform("base_link -> front_optical", now, [0.5, 0.0, 1.0], OPTICAL);
    vehicle.receive(now, &topic("/tf_static"), Incoming::StaticTransforms(said(vec![mounting])))
}

fn calibrate(vehicle: &mut Vehicle, now: Now, focal: f64) -> Vec<Effect> {
    let info = CameraInfo {
        stamp_unix_ns: now.unix_ns,
        frame: "front_optical".to_owned(),
        width_pixels: 640,
        height_pixels: 480,
        focal_pixels: [focal; 2],
        center_pixels: [319.5, 239.5],
        distortion: Distortion::None,
    };
    vehicle.receive(now, &topic("/info"), Incoming::CameraInfo { camera: "front".into(), info })
}

/// A frame without objects.
fn look(vehicle: &mut Vehicle, now: Now, frame: &str) -> Vec<Effect> {
    let detections = Detections { stamp_unix_ns: now.unix_ns, frame: frame.to_owned(), boxes: Vec::new() };
    vehicle.receive(now, &topic("/seen"), Incoming::Detections { camera: "front".into(), detections })
}

fn count(vehicle: &Vehicle, name: &str) -> u64 {
    vehicle.refused().get(&topic(name)).map_or(0, |refused| refused.count)
}

/// Diagnostics that begin with this, from those that go to the log and those that are published first.
fn told(effects: &[Effect], subject: &str) -> Vec<String> {
    let name = format!("dragnet: {subject}");
    let told = effects.iter().filter_map(|effect| match effect {
        Effect::Tell(diagnostic) if diagnostic.name == name => Some(diagnostic.message.clone()),
        _ => None,
    });
    told.collect()
}

#[test]
fn the_pose_is_that_of_the_newest_transforms() {
    let mut vehicle = measured("");
    // The first transform of localization is of a time that odometry has not reached.
    stand_at(&mut vehicle, at(500), 20.0);
    assert_eq!(vehicle.located, None);
    stand_at(&mut vehicle, at(1000), 20.0);
    assert_eq!(vehicle.located, Some(Pose::new(20.0, 10.0, 0.0)));
    // Only odometry says where the vehicle is now; the other transform is dated ahead.
    let map = transform("map -> odom", at(2000), [10.0, 10.0, 0.0], LEVEL);
    vehicle.receive(at(1500), &topic("/tf"), Incoming::Transforms(said(vec![map])));
    assert_eq!(vehicle.located, Some(Pose::new(20.0, 10.0, 0.0)));
    let odometry = transform("odom -> base_link", at(1750), [20.0, 0.0, 0.0], LEVEL);
    vehicle.receive(at(1750), &topic("/tf"), Incoming::Transforms(said(vec![odometry])));
    // The other one is in the middle between two of its own.
    assert_eq!(vehicle.located, Some(Pose::new(25.0, 10.0, 0.0)));
    let mut effects = Vec::new();
    for step in 0..30 {
        effects.extend(vehicle.tick(at(1750 + 100 * step)));
    }
    let [why] = &told(&effects, "pose")[..] else { panic!("{effects:?}") };
    assert_mentions(why, "/tf: the newest transform from \"odom\" to \"base_link\" is 1.1 s old");
}

#[test]
fn frames_wait_for_their_camera_and_then_count() {
    let mut vehicle = measured("");
    stand_at(&mut vehicle, at(500), 20.0);
    stand_at(&mut vehicle, at(1000), 20.0);
    look(&mut vehicle, at(1000), "front_optical");
    calibrate(&mut vehicle, at(1200), 300.0);
    stand_at(&mut vehicle, at(1500), 20.0);
    mount(&mut vehicle, at(1900));
    for step in 19..40 {
        stand_at(&mut vehicle, at(100 * step), 20.0);
        look(&mut vehicle, at(100 * step), "/front_optical");
        vehicle.tick(at(100 * step));
    }
    assert_eq!(count(&vehicle, "/seen"), 0);
    // It is known to the pilot: no silence is reported.
    assert!(told(&vehicle.tick(at(4000)), "silence of front").is_empty());
}

#[test]
fn what_a_camera_lacks_is_said_once_and_counted() {
    let mut vehicle = measured("");
    let mut effects = Vec::new();
    let until = |vehicle: &mut Vehicle, effects: &mut Vec<Effect>, from: i64, to: i64| {
        for step in from..to {
            effects.extend(stand_at(vehicle, at(100 * step), 20.0));
            effects.extend(look(vehicle, at(100 * step), "front_optical"));
            effects.extend(vehicle.tick(at(100 * step)));
        }
    };
    until(&mut vehicle, &mut effects, 10, 200);
    assert_eq!(told(&effects, "mounting of front"), ["no valid camera_info has arrived"]);
    assert!((170..190).contains(&count(&vehicle, "/seen")), "{}", count(&vehicle, "/seen"));
    effects.extend(calibrate(&mut vehicle, at(20_000), 300.0));
    until(&mut vehicle, &mut effects, 200, 400);
    let missing = "no transform names the frame \"front_optical\"";
    assert_eq!(told(&effects, "mounting of front")[1..], [missing]);
    effects.clear();
    effects.extend(mount(&mut vehicle, at(40_000)));
    until(&mut vehicle, &mut effects, 400, 450);
    assert_eq!(told(&effects, "mounting of front"), ["well again"]);
    // Two cameras that were taken for each other.
    let before = count(&vehicle, "/seen");
    let effects = look(&mut vehicle, at(45_000), "rear_optical");
    let told = told(&effects, "mounting of front");
    assert_mentions(&told[0], "\"rear_optical\" .. \"front_optical\" .. of two cameras");
    assert_eq!(count(&vehicle, "/seen"), before + 1);
}

#[test]
fn a_calibration_that_changes_is_told() {
    let mut vehicle = measured("");
    let mut effects = calibrate(&mut vehicle, at(1000), 300.0);
    effects.extend(calibrate(&mut vehicle, at(1100), 300.0));
    assert!(told(&effects, "calibration of front").is_empty());
    // Two publishers that take turns are one fault.
    for step in 0..1000 {
        let focal = if step % 2 == 0 { 310.0 } else { 300.0 };
        effects.extend(calibrate(&mut vehicle, at(1200 + 10 * step), focal));
        effects.extend(vehicle.tick(at(1200 + 10 * step)));
    }
    let [changed] = &told(&effects, "calibration of front")[..] else { panic!("{effects:?}") };
    assert_mentions(changed, "has changed .. 640 x 480 .. 310.0 pixels .. \"front_optical\"");
    let mut effects = calibrate(&mut vehicle, at(12_000), 300.0);
    effects.extend(vehicle.tick(at(16_000)));
    assert_eq!(told(&effects, "calibration of front"), ["well again"]);
}

#[test]
fn transforms_that_cannot_be_are_counted_and_change_nothing() {
    let mut vehicle = measured("");
    stand_at(&mut vehicle, at(500), 20.0);
    stand_at(&mut vehicle, at(1000), 20.0);
    let mut effects = Vec::new();
    for step in 0..1000 {
        let now = at(1000 + 10 * step);
        let looped = transform("base_link -> map", now, [0.0; 3], LEVEL);
        let mut transforms = said(vec![looped]);
        transforms.rejected.push("rotation is NaN".to_owned());
        effects.extend(vehicle.receive(now, &topic("/tf"), Incoming::Transforms(transforms)));
        effects.extend(vehicle.tick(now));
    }
    assert_eq!(told(&effects, "/tf"), ["rotation is NaN"]);
    assert_eq!(count(&vehicle, "/tf"), 2000);
    let [why] = &told(&effects, "pose")[..] else { panic!("{effects:?}") };
    assert_mentions(why, "rejected .. a loop of frames: map -> base_link -> odom -> map");
}

/// Whether the vehicle must stand, by the fault of an interlock.
fn stands(effects: &[Effect], subject: &str) -> Option<String> {
    told(effects, subject).pop()
}

#[test]
fn an_emergency_stop_stops_until_it_is_released() {
    let stop = |vehicle: &mut Vehicle, milliseconds: i64, is_stopped: bool| {
        vehicle.receive(at(milliseconds), &topic("/e_stop"), Incoming::Stop(is_stopped))
    };
    let mut vehicle = measured("emergency_stop = { topic = 'e_stop', timeout_seconds = 1.0 }");
    let silent = stands(&vehicle.tick(at(0)), "emergency stop").unwrap();
    assert_mentions(&silent, "nothing has arrived on e_stop yet");
    assert_eq!(stands(&stop(&mut vehicle, 100, false), "emergency stop").unwrap(), "well again");
    let pressed = stands(&stop(&mut vehicle, 200, true), "emergency stop").unwrap();
    assert_mentions(&pressed, "e_stop is true");
    // It holds as long as nothing else arrives.
    assert_eq!(stands(&vehicle.tick(at(9000)), "emergency stop"), None);
    assert_eq!(stands(&stop(&mut vehicle, 9100, false), "emergency stop").unwrap(), "well again");
    assert_eq!(stands(&vehicle.tick(at(10_000)), "emergency stop"), None);
    let silent = stands(&vehicle.tick(at(10_200)), "emergency stop").unwrap();
    assert_mentions(&silent, "nothing has arrived on e_stop for 1.1 s");

    let mut vehicle =
        measured("emergency_stop = { topic = 'e_stop', timeout_seconds = 1.0, on_timeout = 'continue' }");
    let effects = vehicle.tick(at(0));
    assert_eq!(stands(&effects, "emergency stop"), None);
    assert_mentions(&told(&effects, "silence of the emergency stop")[0], "yet");
    assert!(stands(&stop(&mut vehicle, 100, true), "emergency stop").is_some());
}

#[test]
fn a_low_battery_stops_the_vehicle_or_is_told() {
    let read = |vehicle: &mut Vehicle, seconds: i64, percent: f64| {
        let now = at(1000 * seconds);
        let battery = Battery { stamp_unix_ns: now.unix_ns, percent: Some(percent) };
        vehicle.receive(now, &topic("/battery"), Incoming::Battery(battery))
    };
    let mut vehicle = measured("battery = { topic = 'battery', min_percent = 30.0 }");
    assert_eq!(stands(&read(&mut vehicle, 1, 40.0), "battery"), None);
    let low = stands(&read(&mut vehicle, 2, 29.0), "battery").unwrap();
    assert_eq!(low, "the battery is at 29 %; needed are 30 %");
    assert_eq!(stands(&read(&mut vehicle, 3, 31.0), "battery"), None);
    assert_eq!(stands(&read(&mut vehicle, 4, 32.0), "battery").unwrap(), "well again");
    // A battery that jumps is not believed.
    assert_eq!(stands(&read(&mut vehicle, 5, 2.0), "battery"), None);
    assert_eq!(count(&vehicle, "/battery"), 1);

    let mut vehicle = measured("battery = { topic = 'battery', on_low = 'home', resume_percent = 50.0 }");
    let must_return = |effects: Vec<Effect>| {
        let orders = effects.iter().filter_map(|it| {
            if let Effect::Report(AgentEvent::MustReturn(must)) = it { Some(*must) } else { None }
        });
        orders.collect::<Vec<_>>()
    };
    let said: Vec<_> = (1..).zip([25.0, 19.0, 30.0, 45.0, 50.0, 40.0]).collect();
    let orders: Vec<_> =
        said.iter().map(|&(second, percent)| must_return(read(&mut vehicle, second, percent))).collect();
    assert_eq!(orders, [vec![], vec![true], vec![], vec![], vec![false], vec![]], "until it is charged");

    let mut vehicle = measured("battery = { topic = 'battery', on_low = 'continue' }");
    let effects = read(&mut vehicle, 1, 10.0);
    assert_eq!(told(&effects, "battery"), ["the battery is at 10 %; needed are 20 %"]);
    assert!(!effects.iter().any(|effect| matches!(effect, Effect::Publish(_))), "{effects:?}");
}
