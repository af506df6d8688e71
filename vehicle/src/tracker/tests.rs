//! The life of tracks, and invalid frames.

use std::f64::consts::PI;

use nalgebra::Vector2;

use super::frame::{Frame, FrameError};
use super::pose_error::PoseError;
use super::settings::Settings;
use super::track::{Standing, TrackId};
use super::{Outcome, Surroundings, Tracker};
use crate::camera::{Camera, CameraSettings, DetectionBox, View};
use dragnet_lattice::plane::{Pose, bearing_radians};

const SECOND: u64 = 1_000_000_000;

fn tracker() -> Tracker {
    Tracker::new(Settings::default()).unwrap()
}

/// From a camera that sees in all directions, 2 to 200 m.
fn frame(seconds: u64, bearings: &[f64]) -> Frame {
    seen_from(Pose::new(0.0, 0.0, 0.0), PI, seconds, bearings)
}

fn seen_from(camera: Pose, half_radians: f64, seconds: u64, bearings: &[f64]) -> Frame {
    Frame {
        time_ns: seconds * SECOND,
        camera: 0,
        view: View::new(camera, half_radians, 2.0, 200.0).unwrap(),
        bearings_radians: bearings.to_vec(),
        bearing_deviation_radians: 0.005,
        pose_error: PoseError::default(),
    }
}

fn outcomes(tracker: &mut Tracker, frames: &[&[f64]]) -> Vec<Outcome> {
    (0..).zip(frames).map(|(second, bearings)| tracker.handle(&frame(second, bearings)).unwrap()).collect()
}

#[test]
fn three_detections_of_five_confirm() {
    let mut tracker = tracker();
    let outcomes = outcomes(&mut tracker, &[&[1.0], &[], &[1.0], &[], &[1.0]]);
    assert_eq!(outcomes[0].born, [(TrackId(0), 0)]);
    assert_eq!(outcomes[2].seen, [(TrackId(0), 0)]);
    assert_eq!(outcomes[4].confirmed, [TrackId(0)]);
    assert!(outcomes.iter().all(|outcome| outcome.lost.is_empty()));
    assert_eq!(tracker.tracks()[0].standing(), Standing::Confirmed);
}

#[test]
fn a_track_that_cannot_be_confirmed_is_dropped() {
    let outcomes = outcomes(&mut tracker(), &[&[1.0], &[], &[], &[]]);
    assert_eq!(outcomes[3].lost, [TrackId(0)]);
}

#[test]
fn a_confirmed_track_outlives_misses_but_not_ten_in_a_row() {
    let mut tracker = tracker();
    let mut frames: Vec<&[f64]> = vec![&[1.0], &[1.0], &[1.0]];
    frames.extend([&[] as &[f64]; 9]);
    frames.push(&[1.0]);
    frames.extend([&[] as &[f64]; 10]);
    let outcomes = outcomes(&mut tracker, &frames);
    let lost: Vec<usize> = (0..frames.len()).filter(|&index| !outcomes[index].lost.is_empty()).collect();
    assert_eq!(lost, [22]);
    assert!(tracker.tracks().is_empty());
}

#[test]
fn out_of_view_is_not_missed() {
    let mut tracker = tracker();
    outcomes(&mut tracker, &[&[1.0], &[1.0], &[1.0]]);
    let away = |second| seen_from(Pose::new(0.0, 0.0, -2.0), 0.5, second, &[]);
    for second in 3..=62 {
        assert_eq!(tracker.handle(&away(second)).unwrap().lost, [], "{second}");
    }
    assert_eq!(tracker.handle(&away(63)).unwrap().lost, [TrackId(0)], "forgotten after 60 s");
}

#[test]
fn two_cameras_may_see_at_the_same_time() {
    let mut tracker = tracker();
    tracker.handle(&frame(1, &[1.0])).unwrap();
    let other = Frame { camera: 1, ..frame(1, &[1.01]) };
    assert_eq!(tracker.handle(&other).unwrap().seen, [(TrackId(0), 0)]);
    let error = tracker.handle(&other).unwrap_err();
    assert_eq!(error, FrameError::Repeated { time_ns: SECOND, camera: 1 });
}

#[test]
fn a_box_of_a_turned_camera_points_at_its_object() {
    let camera = Camera::new(CameraSettings {
        name: "left".to_owned(),
        width_pixels: 2660,
        height_pixels: 1516,
        field_of_view_radians: 63_f64.to_radians(),
        mounting: Pose::new(0.5, 0.3, 1.2),
        z_meters: 0.0,
        pitch_radians: 0.0,
        min_range_meters: 2.0,
        max_range_meters: 100.0,
    });
    let (camera, vehicle) = (camera.unwrap(), Pose::new(20.0, 30.0, 2.5));
    let eye = vehicle.of_part(&camera.settings().mounting);
    let object = eye.position_meters()
        + Vector2::new((eye.heading_radians + 0.3).cos(), (eye.heading_radians + 0.3).sin()) * 40.0;
    let column = camera.column_pixels(1.2 + 0.3).unwrap();
    let detection_box = DetectionBox { left: column - 9.0, top: 100.0, right: column + 9.0, bottom: 150.0 };
    let detections = camera.detections(&[detection_box]).unwrap();
    let error = PoseError::default();
    let frame = Frame::of_camera(&camera, 0, &vehicle, &detections, SECOND, 0.005, error).unwrap();
    assert!(frame.view.contains(object));
    let expected = bearing_radians(eye.position_meters(), object);
    assert!((frame.bearings_radians[0] - expected).abs() < 1e-12, "{frame:?} {expected}");
    assert_eq!(tracker().handle(&frame).unwrap().born, [(TrackId(0), 0)]);
    let lost = Pose::new(20.0, 30.0, f64::NAN);
    assert!(Frame::of_camera(&camera, 0, &lost, &detections, SECOND, 0.005, error).is_err());
}

#[test]
fn crossing_objects_keep_their_tracks_as_the_camera_moves() {
    let objects = [Vector2::new(20.0, 30.0), Vector2::new(24.0, 60.0), Vector2::new(-30.0, 20.0)];
    let still = Settings { velocity_std: 0.05, acceleration_density: 1e-6, ..Settings::default() };
    let mut tracker = Tracker::new(still).unwrap();
    for step in 0..300_u64 {
        let seconds = step as f64 / 5.0;
        let camera = Pose::new(seconds, 3.0 * (seconds / 6.0).sin(), 0.0);
        let bearings = objects.map(|object| bearing_radians(camera.position_meters(), object));
        let frame = Frame { time_ns: step * SECOND / 5, ..seen_from(camera, PI, 0, &bearings) };
        let outcome = tracker.handle(&frame).unwrap();
        assert!(step == 0 || (outcome.born.is_empty() && outcome.seen.len() == 3), "{step} {outcome:?}");
    }
    for (track, object) in tracker.tracks().iter().zip(objects) {
        let estimate = track.estimate();
        let off = estimate.position_meters() - object;
        let sigma = (estimate.covariance[(0, 0)] + estimate.covariance[(1, 1)]).sqrt();
        assert!(off.norm() < 3.0 * sigma && off.norm() < 3.0, "{off} {sigma}");
    }
}

#[test]
fn an_invalid_frame_changes_nothing() {
    let mut tracker = tracker();
    outcomes(&mut tracker, &[&[1.0, -1.0], &[1.0]]);
    let before = format!("{tracker:?}");
    let view = View::new(Pose::new(0.0, 0.0, 0.0), 0.5, 2.0, 200.0).unwrap();
    let many: Vec<f64> = (0..10_000).map(|index| f64::from(index) * 1e-4).collect();
    let refused = [
        (frame(0, &[1.0]), "backwards"),
        (frame(1, &[1.0]), "second frame"),
        (frame(2, &[0.0, f64::NAN]), "bearing 1 is NaN"),
        (frame(2, &[f64::INFINITY]), "bearing 0 is inf"),
        (frame(2, &[1.0, 2.0, 1.0]), "bearing 2, 1 radians, is in the frame twice"),
        (frame(2, &many), "10000 bearings"),
        (Frame { view, ..frame(2, &[0.6]) }, "outside of the camera's view"),
        (Frame { bearing_deviation_radians: f64::NAN, ..frame(2, &[1.0]) }, "NaN radians"),
        (Frame { bearing_deviation_radians: 0.0, ..frame(2, &[1.0]) }, "0 radians"),
        (
            Frame {
                pose_error: PoseError { heading_std_radians: -1.0, ..PoseError::default() },
                ..frame(2, &[1.0])
            },
            "the error of a pose",
        ),
    ];
    for (frame, message) in refused {
        let error = tracker.handle(&frame).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
        assert_eq!(format!("{tracker:?}"), before);
    }
}

#[test]
fn beyond_the_most_tracks_none_is_born_and_that_is_counted() {
    let mut tracker = tracker();
    let frame =
        |second: u64, bearings: &[f64]| Frame { bearing_deviation_radians: 1e-4, ..frame(second, bearings) };
    let bearings: Vec<f64> = (0..250).map(|index| f64::from(index) * 0.025 - 3.1).collect();
    tracker.handle(&frame(0, &bearings)).unwrap();
    let between: Vec<f64> = bearings.iter().map(|bearing| bearing + 0.0125).take(200).collect();
    let settings = Settings { gate_radians: 0.001, ..Settings::default() };
    tracker.settings = settings;
    let outcome = tracker.handle(&frame(1, &between)).unwrap();
    assert_eq!((outcome.born.len(), outcome.refused_births), (6, 194));
}

#[test]
fn a_gap_of_centuries_is_no_panic() {
    let mut tracker = tracker();
    outcomes(&mut tracker, &[&[1.0], &[1.0]]);
    let late = Frame { time_ns: u64::MAX, ..frame(0, &[1.0]) };
    tracker.handle(&late).unwrap();
    assert!(tracker.tracks().iter().all(|track| track.estimate().mean.iter().all(|value| value.is_finite())));
}

#[test]
fn invalid_settings_give_the_reason() {
    let check = |change: fn(&mut Settings), message: &str| {
        let mut settings = Settings::default();
        change(&mut settings);
        let error = Tracker::new(settings).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    check(|settings| settings.range_hypotheses = 0, "0 range hypotheses");
    check(|settings| settings.range_hypotheses = 1000, "1000 range hypotheses");
    check(|settings| settings.velocity_std = f64::NAN, "velocity_std = NaN");
    check(|settings| settings.acceleration_density = -1.0, "acceleration_density = -1");
    check(|settings| settings.gate_radians = 4.0, "gate_radians = 4");
    check(|settings| settings.track_timeout_seconds = 0.0, "track_timeout_seconds = 0");
    check(|settings| settings.miss_probability = 1.0, "miss_probability = 1");
    check(|settings| settings.false_alarms_per_frame = 0.0, "false_alarms_per_frame = 0");
    check(|settings| settings.pose_correlation_seconds = f64::NAN, "pose_correlation_seconds = NaN");
    check(|settings| settings.confirm_hits = 6, "6 of 5 frames");
    check(|settings| settings.max_misses = 0, "0 misses lose: needed is");
}

/// Bearings of one pose share its error: a hundred of them give no better heading than the pose does.
#[test]
fn bearings_of_one_pose_do_not_average_its_error_away() {
    let pose_error =
        PoseError { heading_std_radians: 0.01, position_std_meters: 0.0, correlation_seconds: 1.0 };
    for frames_a_second in [2, 10, 50] {
        let mut tracker = tracker();
        for number in 0..10 * frames_a_second {
            let time_ns = number * SECOND / frames_a_second;
            tracker.handle(&Frame { time_ns, pose_error, ..frame(0, &[1.0]) }).unwrap();
        }
        let track = &tracker.tracks()[0];
        for member in track.mixture().members() {
            let off = member.state.position_meters();
            let across = Vector2::new(-off.y, off.x) / off.norm_squared();
            let std_radians = across.dot(&(member.state.place_covariance() * across)).sqrt();
            let expected = 0.01 / 10.0_f64.sqrt();
            let is_so = (std_radians / expected - 1.0).abs() < 0.3;
            assert!(is_so, "{frames_a_second} Hz: {std_radians} {expected}");
        }
        assert!(track.lasting_std_meters() > 0.0);
    }
}

/// A false alarm beside a track does not pull it away.
#[test]
fn a_false_alarm_does_not_end_a_track() {
    let object = Vector2::new(40.0, 30.0);
    let mut tracker = tracker();
    let at = |step: u64| Pose::new(step as f64 * 0.4, 0.0, 0.0);
    for step in 0..120_u64 {
        let camera = at(step);
        let bearing = bearing_radians(camera.position_meters(), object);
        // Every 20th frame misses it and has a false alarm two degrees beside it.
        let seen = if step % 20 == 19 { bearing + 0.035 } else { bearing };
        let frame = Frame { time_ns: step * SECOND / 5, ..seen_from(camera, PI, 0, &[seen]) };
        tracker.handle(&frame).unwrap();
    }
    let best = tracker.tracks().iter().max_by_key(|track| track.hits()).unwrap();
    assert!((best.position_meters() - object).norm() < 1.0, "{}", best.position_meters());
}

/// Of a drive past an object at (11.9, 7.0): each tenth of a second the camera's pose, and a bearing. The first one is a
/// false alarm, which crosses the next one before the object.
const DRIVE: [([f64; 3], Option<f64>); 19] = [
    ([8.237, 1.186, -0.019], Some(0.8558)),
    ([8.382, 1.192, -0.024], None),
    ([8.523, 1.208, -0.025], None),
    ([8.643, 1.196, -0.024], None),
    ([8.758, 1.174, -0.020], None),
    ([8.875, 1.173, -0.020], None),
    ([9.021, 1.161, 0.071], None),
    ([9.140, 1.203, 0.226], None),
    ([9.272, 1.285, 0.376], Some(1.1294)),
    ([9.426, 1.351, 0.527], None),
    ([9.570, 1.479, 0.662], Some(1.1521)),
    ([9.705, 1.628, 0.751], Some(1.1490)),
    ([9.836, 1.777, 0.800], Some(1.1655)),
    ([9.982, 1.938, 0.811], Some(1.1853)),
    ([10.128, 2.084, 0.801], None),
    ([10.258, 2.214, 0.792], Some(1.2273)),
    ([10.375, 2.319, 0.784], Some(1.2394)),
    ([10.455, 2.420, 0.783], Some(1.2516)),
    ([10.538, 2.530, 0.779], Some(1.2687)),
];

#[test]
fn a_track_that_begins_with_a_false_alarm_ends_at_its_object() {
    let pose_error =
        PoseError { heading_std_radians: 0.008, position_std_meters: 0.03, correlation_seconds: 1.0 };
    let settings = Settings { velocity_std: 1e-3, acceleration_density: 1e-8, ..Settings::default() };
    let mut tracker = Tracker::new(settings).unwrap();
    for (tenth, ([east, north, heading], bearing)) in (0..).zip(DRIVE) {
        let bearings: Vec<f64> = bearing.into_iter().collect();
        let frame = Frame {
            time_ns: tenth * SECOND / 10,
            view: View::new(Pose::new(east, north, heading), 0.888, 0.3, 8.0).unwrap(),
            bearing_deviation_radians: 0.0154,
            pose_error,
            ..frame(0, &bearings)
        };
        tracker.handle(&frame).unwrap();
    }
    let [track] = tracker.tracks() else { panic!("{:?}", tracker.tracks()) };
    let off_meters = (track.position_meters() - Vector2::new(11.9, 7.0)).norm();
    assert!(off_meters < 3.0 * track.std_meters(), "{off_meters} m off, {} m", track.std_meters());
}

/// A camera with a shorter range has missed it all the time: a single detection there may be a false alarm, and
/// repeated ones mean that the object is near.
#[test]
fn one_detection_by_a_camera_that_always_missed_it_does_not_rule_out_that_it_is_far() {
    let mut tracker = tracker();
    let mut far = Vec::new();
    for number in 0..80_u64 {
        let frame = |camera: u16, half_radians: f64, max_range_meters: f64, is_seen: bool| Frame {
            time_ns: number * SECOND / 20 + u64::from(camera),
            camera,
            view: View::new(Pose::new(0.0, 0.0, 0.0), half_radians, 2.0, max_range_meters).unwrap(),
            ..seen_from(Pose::new(0.0, 0.0, 0.0), PI, 0, if is_seen { &[0.0] } else { &[] })
        };
        tracker.handle(&frame(0, 0.14, 200.0, true)).unwrap();
        tracker.handle(&frame(1, 0.55, 80.0, number == 60 || number > 70)).unwrap();
        let members = tracker.tracks()[0].mixture().members().iter();
        let beyond = members.filter(|member| member.state.position_meters().norm() > 120.0);
        far.push(beyond.map(|member| member.weight).sum::<f64>());
    }
    // Less than a thousandth would be dropped.
    assert!(far[59] > 0.15 && far[60] > 0.02 * far[59] && far[70] > 0.02 * far[59], "{far:?}");
    assert!(far[79] < 1e-3, "{far:?}");
}

/// No track begins where everything was in view before.
#[test]
fn a_track_begins_where_it_was_not_seen_before() {
    let mut tracker = tracker();
    let unseen = |place: Vector2<f64>| if place.norm() < 120.0 { 1e-6 } else { 1.0 };
    let surroundings = Surroundings { unseen: &unseen, is_hidden: &|_| false };
    tracker.handle_among(&frame(0, &[1.0]), &surroundings).unwrap();
    let range = tracker.tracks()[0].position_meters().norm();
    assert!(range > 120.0, "{range}");
}

/// A map may be wrong: behind a wall a track is unlikely, and not impossible.
#[test]
fn a_track_begins_before_a_wall() {
    let range = |is_hidden: &dyn Fn(Vector2<f64>) -> bool| {
        let mut tracker = tracker();
        for second in 0..3 {
            let surroundings = Surroundings { unseen: &|_| 1.0, is_hidden };
            tracker.handle_among(&frame(second, &[1.0]), &surroundings).unwrap();
        }
        let track = &tracker.tracks()[0];
        (track.position_meters().norm(), track.std_meters())
    };
    let (before_a_wall, std_meters) = range(&|place| place.norm() > 20.0);
    assert!(before_a_wall < 20.0 && before_a_wall + 2.0 * std_meters > 20.0, "{before_a_wall} {std_meters}");
    let (open, _) = range(&|_| false);
    assert!(open > 40.0, "{open}");
}

#[test]
fn a_track_behind_a_wall_is_not_missed() {
    let lost = |is_hidden: &dyn Fn(Vector2<f64>) -> bool| {
        let mut tracker = tracker();
        outcomes(&mut tracker, &[&[1.0], &[1.0], &[1.0]]);
        let surroundings = Surroundings { unseen: &|_| 1.0, is_hidden };
        (3..40).find(|&second| {
            !tracker.handle_among(&frame(second, &[]), &surroundings).unwrap().lost.is_empty()
        })
    };
    assert_eq!(lost(&|_| false), Some(12));
    assert_eq!(lost(&|_| true), None);
    // Half of what is possible is in view, and is not true: the rest is behind the wall.
    assert_eq!(lost(&|place| place.norm() > 20.0), None);
}

/// Straight toward an object, which is first detected at the camera's maximum range, at 2 m/s with 5 frames per second,
/// and beyond.
#[test]
fn an_object_that_was_driven_over_lies_behind_its_last_detection() {
    let mut tracker = tracker();
    for tick in 0..130_u32 {
        let east = 0.4 * f64::from(tick);
        let bearings: &[f64] = if east < 38.0 { &[0.0] } else { &[] };
        let camera = Pose::new(east, 0.0, 0.0);
        let view = View::new(camera, 0.5, 2.0, 40.0).unwrap();
        let time_ns = u64::from(tick) * SECOND / 5;
        tracker.handle(&Frame { time_ns, view, ..seen_from(camera, 0.5, 0, bearings) }).unwrap();
    }
    let [track] = tracker.tracks() else { panic!("{:?}", tracker.tracks()) };
    let place = track.position_meters();
    let std_meters = track.position_covariance().symmetric_eigenvalues().max().sqrt();
    assert!((place.x - 40.0).abs() < 3.0 && place.y.abs() < 0.5, "{place}");
    assert!(std_meters < 3.0, "{std_meters}");
}
