//! A vehicle's pose, from sequences of poses and odometry.

use std::f64::consts::FRAC_PI_2;
use std::time::Duration;

use dragnet_ros2::input::Velocity;
use dragnet_scenario::map_file::GeoPoint;

use super::*;
use crate::mentions::assert_mentions;

/// The search's map has its origin at (100, 50) in the network's frame and is rotated to the left.
const MAP: MapOrigin = MapOrigin { x_meters: 100.0, y_meters: 50.0, yaw_radians: FRAC_PI_2 };

fn estimate(x_meters: f64, y_meters: f64, yaw_radians: f64) -> PoseEstimate {
    PoseEstimate {
        stamp_unix_ns: 7,
        frame: "map".to_owned(),
        pose: PlanarPose { x_meters, y_meters, yaw_radians },
        covariance: Some([[0.25, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.01]]),
    }
}

fn odometry(x_meters: f64, y_meters: f64, yaw_radians: f64) -> Odometry {
    let place = PoseEstimate { stamp_unix_ns: 8, ..estimate(x_meters, y_meters, yaw_radians) };
    Odometry { place, robot_frame: "base_link".to_owned(), velocity: Velocity::default() }
}

/// Stamped on arrival, at this time.
fn at(seconds: f64) -> Moment {
    stamped(seconds, seconds)
}

/// Arrival and stamp at these times.
fn stamped(received_seconds: f64, stamp_seconds: f64) -> Moment {
    let nanoseconds = |seconds| u64::try_from(Duration::from_secs_f64(seconds).as_nanos()).unwrap();
    let (received_ns, time_ns) = (nanoseconds(received_seconds), nanoseconds(stamp_seconds));
    Moment { received_ns, time_ns, age: Duration::from_nanos(received_ns.saturating_sub(time_ns)) }
}

fn places(source: Localization) -> Places {
    places_on(source, MapOrigin::default(), None)
}

fn places_on(source: Localization, map: MapOrigin, earth: Option<Georeference>) -> Places {
    let limits = Uncorrected { timeout_ns: 5_000_000_000, meters: 1.0, radians: std::f64::consts::FRAC_PI_4 };
    Places::new(source, limits, PoseStd { meters: 0.1, radians: 0.02 }, map, earth)
}

fn check(found: Option<Located>, seconds: f64, expected: [f64; 3]) {
    let Located { time_ns, pose, .. } = found.unwrap();
    let difference = [
        pose.x_meters - expected[0],
        pose.y_meters - expected[1],
        dragnet_lattice::plane::turn_radians(pose.heading_radians, expected[2]),
    ];
    assert!(difference.iter().all(|part| part.abs() < 1e-9), "{pose:?}, not {expected:?}");
    assert_eq!(time_ns, at(seconds).time_ns);
}

#[test]
fn a_pose_on_the_networks_map_is_one_on_the_searchs() {
    let mut places = places_on(Localization::Pose, MAP, None);
    let found = places.pose(at(7.0), &estimate(90.0, 53.0, FRAC_PI_2)).unwrap();
    check(found, 7.0, [3.0, 10.0, 0.0]);
    let Located { pose, deviation_meters, heading_deviation_radians, .. } = found.unwrap();
    assert!((deviation_meters - 0.5).abs() < 1e-9 && (heading_deviation_radians - 0.1).abs() < 1e-9);
    let back = places.in_frame(&pose);
    assert!((back.x_meters - 90.0).abs() < 1e-9 && (back.y_meters - 53.0).abs() < 1e-9);
}

#[test]
fn a_pose_without_a_covariance_is_not_exact() {
    let is_unstated = |found: Located| {
        assert_eq!((found.deviation_meters, found.heading_deviation_radians), (0.1, 0.02));
    };
    is_unstated(places(Localization::Tf).transformed(at(7.0), &Pose::default()));
    let unstated = PoseEstimate { covariance: None, ..estimate(1.0, 2.0, 0.0) };
    is_unstated(places(Localization::Pose).pose(at(7.0), &unstated).unwrap().unwrap());
    let by_odometry = Odometry { place: unstated, ..odometry(1.0, 2.0, 0.0) };
    is_unstated(places(Localization::Odometry).odometry(at(7.0), &by_odometry).unwrap());
    let without_heading =
        PoseEstimate { covariance: Some([[0.0; 3], [0.0, 0.04, 0.0], [0.0; 3]]), ..estimate(1.0, 2.0, 0.0) };
    let found = places(Localization::Pose).pose(at(7.0), &without_heading).unwrap().unwrap();
    assert_eq!((found.deviation_meters, found.heading_deviation_radians), (0.2, 0.02));
}

#[test]
fn between_poses_odometry_goes_on_from_the_last() {
    let mut places = places(Localization::Pose);
    assert_eq!(places.odometry(at(1.0), &odometry(5.0, 5.0, 0.0)), None, "nobody knows where that is");
    let pose = places.pose(at(1.0), &estimate(20.0, 30.0, FRAC_PI_2));
    assert_eq!(pose, Ok(None), "odometry tells it next");
    check(places.odometry(at(1.1), &odometry(5.0, 5.0, 0.0)), 1.1, [20.0, 30.0, FRAC_PI_2]);
    // Two meters ahead, a meter to the left, turned back.
    check(places.odometry(at(1.2), &odometry(7.0, 6.0, -FRAC_PI_2)), 1.2, [19.0, 32.0, 0.0]);
}

#[test]
fn a_standing_vehicle_is_localized_by_an_older_latched_pose() {
    let mut places = places(Localization::Pose);
    // Twenty minutes old, and the only one.
    let pose = places.pose(stamped(1200.0, 0.0), &estimate(20.0, 30.0, FRAC_PI_2));
    assert_eq!(pose, Ok(None), "odometry says whether it still stands there");
    for step in 0..100 {
        let seconds = 1201.0 + f64::from(step);
        check(places.odometry(at(seconds), &odometry(5.0, 5.0, 0.0)), seconds, [20.0, 30.0, FRAC_PI_2]);
    }
    check(places.odometry(at(1301.0), &odometry(5.5, 5.0, 0.0)), 1301.0, [20.0, 30.5, FRAC_PI_2]);
}

#[test]
fn a_pose_counts_as_of_its_own_time() {
    let mut places = places(Localization::Pose);
    // 2 m/s to the east.
    for step in 0..=10 {
        places.odometry(at(1.0 + f64::from(step) / 10.0), &odometry(f64::from(step) / 5.0, 0.0, 0.0));
    }
    // The pose of 0.45 s became known after 0.55 s.
    places.pose(stamped(2.0, 1.45), &estimate(50.9, 10.0, 0.0)).unwrap();
    check(places.odometry(at(2.1), &odometry(2.2, 0.0, 0.0)), 2.1, [52.2, 10.0, 0.0]);
    // And one that is ahead of odometry waits for it.
    places.pose(stamped(2.15, 2.15), &estimate(62.3, 10.0, 0.0)).unwrap();
    check(places.odometry(at(2.2), &odometry(2.4, 0.0, 0.0)), 2.2, [62.4, 10.0, 0.0]);
}

/// Drives at this speed for a minute with poses for the first second and odometry ten times a second; returns for how
/// many seconds the pose was known, and what is missing then.
fn corrected_for_a_second(meters_per_second: f64, radians_per_second: f64) -> (f64, Option<String>) {
    let mut places = places(Localization::Pose);
    let mut known = 0;
    for step in 0..600 {
        let seconds = f64::from(step) / 10.0;
        let (x, heading) = (meters_per_second * seconds, radians_per_second * seconds);
        if seconds < 1.0 {
            places.pose(at(seconds), &estimate(x, 0.0, heading)).unwrap();
        }
        known += i32::from(places.odometry(at(seconds), &odometry(x, 0.0, heading)).is_some());
    }
    (f64::from(known) / 10.0, places.missing().map(str::to_owned))
}

#[test]
fn a_source_that_dies_is_missed_once_the_vehicle_has_gone_far_without_it() {
    let (known, missing) = corrected_for_a_second(2.0, 0.0);
    assert!((5.0..6.5).contains(&known), "{known} s");
    let missing = missing.unwrap();
    assert_mentions(&missing, "no valid message .. for 5. .. 10.2 m .. 0 degrees");
    let (known, missing) = corrected_for_a_second(0.0, 0.1);
    assert!((8.0..10.0).contains(&known) && missing.is_some(), "turning: {known} s");
    let (known, missing) = corrected_for_a_second(0.1, 0.0);
    assert!((10.0..12.0).contains(&known) && missing.is_some(), "creeping: {known} s");
    // A standing vehicle with noisy odometry needs no corrections.
    assert_eq!(corrected_for_a_second(0.01, 0.005), (60.0, None));
}

#[test]
fn a_returning_source_gives_the_vehicles_pose() {
    let mut places = places(Localization::Pose);
    places.pose(at(0.0), &estimate(0.0, 0.0, 0.0)).unwrap();
    assert!(places.odometry(at(0.1), &odometry(0.0, 0.0, 0.0)).is_some());
    assert_eq!(places.odometry(at(6.0), &odometry(9.0, 0.0, 0.0)), None);
    assert_eq!(places.odometry(at(6.1), &odometry(0.0, 0.0, 0.0)), None, "it is lost even where it began");
    places.pose(at(6.1), &estimate(3.0, 0.0, 0.0)).unwrap();
    check(places.odometry(at(6.2), &odometry(0.0, 0.0, 0.0)), 6.2, [3.0, 0.0, 0.0]);
}

#[test]
fn poses_of_long_ago_are_silence_if_the_vehicle_has_moved_since() {
    let mut places = places(Localization::Pose);
    let mut refused = 0;
    let mut known = 0;
    for step in 0..600 {
        let seconds = 100.0 + f64::from(step) / 10.0;
        let place = |seconds: f64| estimate(2.0 * (seconds - 100.0).max(0.0), 0.0, 0.0);
        let pose = places.pose(stamped(seconds, seconds - 20.0), &place(seconds - 20.0));
        if let Err(reason) = pose {
            refused += 1;
            assert_mentions(&reason, "stamped 20.0 s before");
        }
        let x_meters = place(seconds).pose.x_meters;
        known += i32::from(places.odometry(at(seconds), &odometry(x_meters, 0.0, 0.0)).is_some());
    }
    assert!(refused > 580 && known < 60, "{refused} refused, known {known} times");
    assert!(places.missing().is_some());
}

#[test]
fn poses_of_long_ago_are_as_good_as_new_ones_to_a_vehicle_that_stands() {
    let mut places = places(Localization::Pose);
    for step in 0..600 {
        let seconds = 100.0 + f64::from(step) / 10.0;
        let pose = places.pose(stamped(seconds, seconds - 20.0), &estimate(3.0, 0.0, 0.0));
        assert!(pose.is_ok() || step < 200, "it is known where it stood then");
        check(places.odometry(at(seconds), &odometry(7.0, 0.0, 0.0)), seconds, [3.0, 0.0, 0.0]);
    }
}

#[test]
fn odometry_alone_will_do_where_it_is_corrected_already() {
    let mut places = places(Localization::Odometry);
    assert_eq!(places.pose(at(1.0), &estimate(1.0, 1.0, 0.0)), Ok(None));
    check(places.odometry(at(1.0), &odometry(4.0, 3.0, 1.0)), 1.0, [4.0, 3.0, 1.0]);
    assert_eq!(places.missing(), None);
}

#[test]
fn a_fix_gives_the_place_and_odometry_the_heading() {
    let corner = GeoPoint { longitude_degrees: -79.95, latitude_degrees: 40.44 };
    let earth = Georeference::new(corner, 40.44);
    let mut places = places_on(Localization::Fix, MapOrigin::default(), Some(earth));
    let fix = Fix {
        stamp_unix_ns: 7,
        frame: "gps".to_owned(),
        point: GeoPoint { latitude_degrees: 40.441, ..corner },
        altitude_meters: None,
        covariance_square_meters: Some([[4.0, 0.0], [0.0, 9.0]]),
    };
    let north = earth.meters(fix.point).1;
    assert!((north - 111.0).abs() < 1.0);
    assert_eq!(places.fix(at(1.0), &fix), Ok(None), "no heading is known");
    check(places.odometry(at(1.1), &odometry(0.0, 0.0, 0.5)), 1.1, [0.0, north, 0.5]);
    assert_eq!(places.fix(at(1.1), &fix), Ok(None));
    let found = places.odometry(at(1.2), &odometry(1.0, 0.0, 0.5));
    check(found, 1.2, [1.0, north, 0.5]);
    assert!((found.unwrap().deviation_meters - 3.0).abs() < 1e-9);
}
