//! A vehicle behind an autopilot, without its link: messages and routes in, targets and observations out.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "degrees and meters of a small field"
)]

use std::f64::consts::FRAC_PI_4;
use std::path::Path;

use dragnet_mavlink::MavHeader;
use dragnet_mavlink::common::{
    ATTITUDE_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, HOME_POSITION_DATA, MavAutopilot, MavModeFlag,
    MavType,
};
use dragnet_search::cell::Position as CellPosition;

use super::*;
use crate::config::{AgentSettings, OwnVehicle};
use crate::mavlink::detections;
use crate::mentions::assert_mentions;

const CORNER: GeoPoint = GeoPoint { longitude_degrees: 9.5, latitude_degrees: 47.5 };

/// A copter over a field of 4 x 4 cells of 20 m.
fn vehicle() -> (Vehicle, Scenario, Checked) {
    let text = "name = 'field'\n[map]\nshape = 'all_traversable'\nrows = 4\ncolumns = 4\ncell_meters = 20.0\n\
                origin = { latitude_degrees = 47.5, longitude_degrees = 9.5 }\n[objects]\ncount = 1\n[sensor]\nradius = 2\n\
                [mission]\nbudget_seconds = 900.0\nspeed_meters_per_second = 10.0\n";
    let scenario = Scenario::from_text(Path::new("field.toml"), text.to_owned()).unwrap();
    let settings = "robot = 1\ncommon = { mission = 'field', scenario = 'field.toml' }\n[vehicle]\n\
                    speed_meters_per_second = 10.0\nmotion = { kind = 'goal' }\n[mavlink]\n\
                    connection = 'udpin:127.0.0.1:14550'\naltitude_meters = 20.0\n";
    let config: AgentSettings = toml::from_str(settings).unwrap();
    let own = config.vehicle(Path::new("robot.toml"), &scenario).unwrap();
    let Some(OwnVehicle::Mavlink(body)) = own else { panic!("{own:?}") };
    (Vehicle::new(body.pilot, &body.mavlink, &scenario).unwrap(), scenario, body.mavlink)
}

fn now(seconds: f64) -> Now {
    let time_ns = std::time::Duration::from_secs_f64(seconds).as_nanos();
    Now { mission_ns: u64::try_from(time_ns).unwrap(), unix_ns: i64::try_from(time_ns).unwrap() }
}

/// The messages of a copter at meters on the map, that looks north and rolls by this angle; the effects.
fn fly(
    vehicle: &mut Vehicle,
    seconds: f64,
    [x, y]: [f64; 2],
    altitude_meters: f64,
    roll: f32,
) -> Vec<Effect> {
    let MapFrame::Global { earth, .. } = vehicle.frame else { panic!() };
    let degrees = |degrees: f64| (degrees * 1e7).round() as i32;
    let place = earth.point((x, y));
    let boot_ms = (seconds * 1000.0) as u32;
    let messages = [
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: 4,
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
            ..HEARTBEAT_DATA::default()
        }),
        MavMessage::HOME_POSITION(HOME_POSITION_DATA {
            latitude: degrees(CORNER.latitude_degrees),
            longitude: degrees(CORNER.longitude_degrees),
            ..HOME_POSITION_DATA::default()
        }),
        MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: boot_ms, roll, ..ATTITUDE_DATA::default() }),
        MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: boot_ms,
            lat: degrees(place.latitude_degrees),
            lon: degrees(place.longitude_degrees),
            relative_alt: (altitude_meters * 1000.0) as i32,
            hdg: 0,
            ..GLOBAL_POSITION_INT_DATA::default()
        }),
    ];
    let header = MavHeader { system_id: 1, component_id: 1, sequence: 0 };
    let receive = |message| vehicle.receive(now(seconds), Frame::Message(header, Box::new(message)));
    messages.into_iter().flat_map(receive).collect()
}

fn see(vehicle: &mut Vehicle, settings: &Checked, seconds: f64, camera: &str, boxes: &str) -> Vec<Effect> {
    let text = format!(r#"{{"camera": "{camera}", "unix_seconds": {seconds}, "boxes": [{boxes}]}}"#);
    vehicle.see(now(seconds), detections::read(text.as_bytes(), &settings.filter))
}

/// Meters on the map of the targets.
fn targets(vehicle: &Vehicle, effects: &[Effect]) -> Vec<[i64; 2]> {
    let MapFrame::Global { earth, .. } = vehicle.frame else { panic!() };
    let target = |effect: &Effect| {
        let Effect::Send(message) = effect else { return None };
        let MavMessage::SET_POSITION_TARGET_GLOBAL_INT(data) = &**message else { return None };
        let [latitude_degrees, longitude_degrees] =
            [data.lat_int, data.lon_int].map(|it| f64::from(it) / 1e7);
        let (x, y) = earth.meters(GeoPoint { longitude_degrees, latitude_degrees });
        Some([x.round() as i64, y.round() as i64])
    };
    effects.iter().filter_map(target).collect()
}

fn told(effects: &[Effect]) -> String {
    let message = |effect: &Effect| match effect {
        Effect::Tell(Notice { subject, message, .. }) => Some(format!("{subject}: {message}")),
        _ => None,
    };
    effects.iter().filter_map(message).collect::<Vec<_>>().join("; ")
}

#[test]
fn routes_become_targets_and_positions_become_observations() {
    let (mut vehicle, scenario, settings) = vehicle();
    let cell = |row, column| scenario.terrain().grid().cell(CellPosition { row, column }).unwrap();
    let mut effects = Vec::new();
    for step in 0..20 {
        let seconds = 100.0 + 0.1 * f64::from(step);
        effects.extend(fly(&mut vehicle, seconds, [10.0, 10.0], 20.0, 0.0));
        for camera in ["wide", "narrow"] {
            effects.extend(see(&mut vehicle, &settings, seconds, camera, ""));
        }
    }
    let sensed: Vec<Cell> = effects
        .iter()
        .filter_map(|effect| match effect {
            Effect::Sensed { cell, .. } => Some(*cell),
            _ => None,
        })
        .collect();
    assert_eq!(sensed, [cell(0, 0)]);
    assert!(targets(&vehicle, &effects).is_empty(), "nothing is wished yet");
    let effects = vehicle.heed(now(102.0), PilotEvent::Route(vec![cell(1, 0), cell(2, 0), cell(2, 1)]));
    assert_eq!(targets(&vehicle, &effects), [[10, 50]]);
    let effects = fly(&mut vehicle, 104.0, [10.0, 48.0], 20.0, 0.0);
    assert_eq!(targets(&vehicle, &effects).last(), Some(&[30, 50]), "{}", told(&effects));
    let effects = vehicle.halt(now(104.1));
    assert_eq!(targets(&vehicle, &effects), [[10, 48]]);
}

#[test]
fn frames_that_show_something_else_than_the_settings_say_are_not_used() {
    let check = |altitude_meters, roll, camera: &str, boxes: &str, mentioned: &str| {
        let (mut vehicle, _, settings) = vehicle();
        fly(&mut vehicle, 100.0, [10.0, 10.0], altitude_meters, roll);
        let effects = see(&mut vehicle, &settings, 100.0, camera, boxes);
        assert_mentions(&told(&effects), mentioned);
    };
    check(20.0, 0.6, "wide", "", "detections: .. leans by 34 degrees .. 29");
    check(14.0, 0.0, "wide", "", "detections: .. 14.0 m above home .. 20.0 m, 5.0 m");
    check(20.0, 0.0, "rear", "", "camera rear: .. narrow, wide");
    let outside = r#"{"left": 1, "top": 1, "right": 9999, "bottom": 2}"#;
    check(20.0, 0.0, "wide", outside, "camera wide: .. outside of the image");
    let (mut vehicle, _, settings) = vehicle();
    assert_mentions(&told(&see(&mut vehicle, &settings, 1.0, "wide", "")), "before any position");
}

#[test]
fn poses_and_targets_are_the_same_in_every_frame() {
    let turned = Georeference::new(CORNER, 47.5).turned(FRAC_PI_4);
    for frame in [MapFrame::global(turned), MapFrame::Local(Pose::new(5.0, -7.0, 0.3))] {
        let pose = Pose::new(30.0, 50.0, 1.0);
        let Target { place, yaw_radians } = frame.target(&pose);
        let position = Position {
            time_ns: 0,
            place,
            altitude_meters: 0.0,
            yaw_radians,
            roll_radians: 0.0,
            pitch_radians: 0.0,
            std_meters: 1.0,
        };
        let back = frame.pose(&position);
        assert!((back.position_meters() - pose.position_meters()).norm() < 1e-6);
        assert!(wrapped_radians(back.heading_radians - pose.heading_radians).abs() < 1e-6);
    }
    // Along the rows of a map that is turned by 45 degrees the compass shows north-east.
    let along = MapFrame::global(turned).target(&Pose::new(10.0, 0.0, 0.0));
    assert!((along.yaw_radians - FRAC_PI_4).abs() < 1e-6);
    let Place::Global { latitude_degrees, longitude_degrees } = along.place else { panic!() };
    assert!(latitude_degrees > CORNER.latitude_degrees && longitude_degrees > CORNER.longitude_degrees);
    // East and north of a map that is not: local positions are north and east.
    let local = MapFrame::Local(Pose::default()).target(&Pose::new(1.0, 2.0, 0.0));
    assert_eq!(local.place, Place::Local { north_meters: 2.0, east_meters: 1.0 });
    assert!((local.yaw_radians - FRAC_PI_2).abs() < 1e-12);
}
