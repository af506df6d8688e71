//! Tables as written, and the errors of invalid ones.

use std::collections::BTreeMap;

use super::check::Source;
use super::*;
use crate::mentions::assert_mentions;
use dragnet_lattice::maneuvers::{Headings, Maneuvers};
use dragnet_lattice::mprim;

fn read(text: &str) -> Result<Settings, String> {
    toml::from_str(text).map_err(|error| error.message().to_owned())
}

fn check(text: &str, message: &str) {
    let error = match read(text) {
        Ok(settings) => settings.check(None).unwrap_err().to_string(),
        Err(error) => error,
    };
    assert_mentions(&error, message);
}

#[test]
fn without_a_key_there_are_the_papers_two_cameras() {
    let checked = read("").unwrap().check(None).unwrap();
    let views: Vec<_> = checked
        .cameras
        .iter()
        .map(|(camera, _)| {
            (camera.settings().name.as_str(), camera.settings().field_of_view_radians.to_degrees().round())
        })
        .collect();
    assert_eq!(views, [("wide", 63.0), ("narrow", 16.0)]);
    assert!(matches!(
        checked.motion,
        Motion::Lattice { source: Source::Made { headings: Headings::Sixteen, .. }, .. }
    ));
    let tracker = crate::tracker::settings::Settings::default();
    assert!((checked.tracker.gate_radians - tracker.gate_radians).abs() < 1e-12);
}

#[test]
fn a_written_file_is_read_back() {
    let settings = read("").unwrap();
    assert_eq!(read(&toml::to_string(&settings).unwrap()).unwrap(), settings);
    let text = "motion = { kind = 'goal' }\nfootprint = { shape = 'disc', radius_meters = 0.5 }\n\
                [safety.on_fault]\ncamera = 'continue'\n";
    let settings = read(text).unwrap();
    assert_eq!(settings.check(None).unwrap().motion, Motion::Goal);
    assert_eq!(settings.safety.on_fault.camera, FaultResponse::Continue);
    assert_eq!(settings.safety.on_fault.pose, FaultResponse::Stop);
}

#[test]
fn primitives_come_from_a_file_that_the_caller_reads() {
    let maneuvers = Maneuvers {
        resolution_meters: 0.5,
        headings: Headings::Eight,
        turning_radius_meters: 2.0,
        reverse: None,
        turn_in_place: None,
    };
    let text = mprim::write(&maneuvers.primitives().unwrap());
    let settings = read("motion = { kind = 'lattice', primitives = 'a.mprim' }").unwrap();
    let Motion::Lattice { source: Source::Read(set), .. } = settings.check(Some(&text)).unwrap().motion
    else {
        panic!("no primitives");
    };
    assert_eq!(set.headings_radians().len(), 8);
    let error = settings.check(Some("resolution_m: 0\n")).unwrap_err().to_string();
    assert_mentions(&error, "vehicle.motion.primitives .. line 1 .. 0 m");
    check("motion = { kind = 'lattice', primitives = 'a.mprim' }", "allowed .. a file");
    check("motion = { kind = 'lattice', primitives = 'a.mprim', headings = 8 }", "allowed .. a file");
}

#[test]
fn an_invalid_value_names_its_key_and_the_allowed_values() {
    check("cameras = []", "vehicle.cameras .. 0 .. 1 to 16");
    check("speed_meters_per_second = 0.0", "vehicle.speed_meters_per_second .. 0 .. above 0, at most 1000");
    check("speed_meters_per_second = nan", "vehicle.speed_meters_per_second .. NaN");
    check("initial_scan_seconds = -1.0", "vehicle.initial_scan_seconds .. -1 .. 0 to 3600");
    check("motion = { kind = 'lattice', headings = 12 }", "vehicle.motion.headings .. 12 .. 8, 16 or 32");
    check("motion = { kind = 'lattice', reverse_cost = 0 }", "vehicle.motion.reverse_cost .. 0 .. 1 to 1000");
    check("motion = { kind = 'fly' }", "`fly`");
    check("motion = { kind = 'goal', foo = 1 }", "unknown .. `foo`");
    check("footprint = { shape = 'disc', radius_meters = -1.0 }", "vehicle.footprint.radius_meters .. -1");
    check("tracker = { range_hypotheses = 0 }", "vehicle.tracker .. 0 range hypotheses");
    check("tracker = { gate_degrees = 270.0 }", "vehicle.tracker .. gate_radians");
    check("safety = { pose_timeout_seconds = 0.0 }", "vehicle.safety.pose_timeout_seconds .. 0");
    check("[safety.on_fault]\ncamera = 'panic'", "`panic` .. `stop` or `continue`");
    check("color = 'red'", "`color` .. `cameras`, `tracker`");
    let camera = |changes: &str| {
        format!(
            "[[cameras]]\nname = 'a'\nwidth_pixels = 100\nheight_pixels = 50\nmax_range_meters = 50.0\n{changes}\n"
        )
    };
    check(&camera("field_of_view_degrees = 200.0"), "vehicle.cameras .. camera a .. field of view");
    check(&camera("field_of_view_degrees = 60.0\nmin_range_meters = 60.0"), "from 60 m to 50 m");
    let one = camera("field_of_view_degrees = 60.0");
    check(&format!("{one}{one}"), "vehicle.cameras.name .. \"a\"");
}

#[test]
fn a_camera_needs_what_its_network_does_not_say() {
    let optics = "width_pixels = 100\nheight_pixels = 50\nfield_of_view_degrees = 90.0";
    let measured = |text: &str, by: Measured| {
        let text = format!("[[cameras]]\nname = 'a'\nmax_range_meters = 50.0\n{text}\n");
        let by = BTreeMap::from([("a".to_owned(), by)]);
        read(&text).unwrap().check_measured(None, &by).map_err(|error| error.to_string())
    };
    let both = measured("", Measured::OpticsAndMounting).unwrap();
    assert!(both.cameras.is_empty());
    let [camera] = &both.measured_cameras[..] else { panic!("{both:?}") };
    assert_eq!((camera.name(), camera.lens(), camera.vehicle_from_camera()), ("a", None, None));

    let by_hand = measured("x_meters = 1.0\nyaw_degrees = 90.0\npitch_degrees = 30.0", Measured::Optics);
    let pose = *by_hand.unwrap().measured_cameras[0].vehicle_from_camera().unwrap();
    // The axis looks to the left and 30 degrees down; the right of the image is forward.
    let (axis, right) = (pose.rotation * nalgebra::Vector3::z(), pose.rotation * nalgebra::Vector3::x());
    assert!((axis - nalgebra::Vector3::new(0.0, 0.75_f64.sqrt(), -0.5)).norm() < 1e-12, "{axis}");
    assert!((right - nalgebra::Vector3::x()).norm() < 1e-12, "{right}");
    let lens = measured(optics, Measured::Mounting).unwrap().measured_cameras[0].lens().cloned();
    assert_eq!(lens, Some(crate::camera::Lens::pinhole(100, 50, 90.0_f64.to_radians())));

    let refused = |text: &str, by: Measured, words: &str| {
        assert_mentions(&measured(text, by).unwrap_err(), words);
    };
    refused("", Measured::Mounting, "camera a .. width_pixels is missing");
    refused("width_pixels = 100", Measured::Optics, "vehicle.cameras.width_pixels .. \"a\" .. either");
    refused("yaw_degrees = 0.0", Measured::OpticsAndMounting, "vehicle.cameras.yaw_degrees .. either");
    refused("min_range_meters = 60.0", Measured::OpticsAndMounting, "from 60 m to 50 m");
    check("[[cameras]]\nname = 'a'\nmax_range_meters = 5.0", "camera a .. width_pixels is missing");
}
