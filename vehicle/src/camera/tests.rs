//! The paper's two cameras, and invalid ones.

use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::mentions::assert_mentions;

fn settings(name: &str, degrees: f64) -> CameraSettings {
    CameraSettings {
        name: name.to_owned(),
        width_pixels: 2660,
        height_pixels: 1516,
        field_of_view_radians: degrees.to_radians(),
        mounting: Pose::new(0.4, 0.0, 0.0),
        z_meters: 0.0,
        pitch_radians: 0.0,
        min_range_meters: 2.0,
        max_range_meters: 100.0,
    }
}

fn wide() -> Camera {
    Camera::new(settings("wide", 63.0)).unwrap()
}

fn narrow() -> Camera {
    Camera::new(settings("narrow", 16.0)).unwrap()
}

fn upright(middle: f64) -> DetectionBox {
    DetectionBox { left: middle - 10.0, top: 500.0, right: middle + 10.0, bottom: 560.0 }
}

#[test]
fn the_edges_of_the_image_are_the_edges_of_the_view() {
    for (camera, degrees) in [(wide(), 63.0_f64), (narrow(), 16.0)] {
        let half = degrees.to_radians() / 2.0;
        assert!((camera.bearing_radians(0.0) - half).abs() < 1e-12, "left is counter-clockwise");
        assert!((camera.bearing_radians(2660.0) + half).abs() < 1e-12);
        assert!(camera.bearing_radians(1330.0).abs() < 1e-12);
    }
}

#[test]
fn a_quarter_of_the_image_is_more_than_a_quarter_of_the_angle() {
    let bearing = wide().bearing_radians(665.0).to_degrees();
    // atan(tan(31.5 degrees) / 2); an image that is linear in angle would have 15.75.
    assert!((bearing - 17.035).abs() < 1e-3, "{bearing}");
}

#[test]
fn four_times_the_zoom_is_about_four_times_the_focal_length() {
    assert!((wide().focal_length_pixels() - 2170.4).abs() < 0.1, "{}", wide().focal_length_pixels());
    let ratio = narrow().focal_length_pixels() / wide().focal_length_pixels();
    assert!((ratio - 4.36).abs() < 0.01, "{ratio}");
    let pixel = wide().bearing_deviation_radians(1.0) / narrow().bearing_deviation_radians(1.0);
    assert!((pixel - ratio).abs() < 1e-4, "{pixel}");
}

#[test]
fn a_column_leads_to_its_bearing_and_back() {
    for yaw in [0.0, 0.3, -3.1, 3.1] {
        let mounting = Pose::new(0.4, -0.2, yaw);
        let camera = Camera::new(CameraSettings { mounting, ..settings("turned", 63.0) }).unwrap();
        for column in [0.1, 17.0, 1330.0, 2000.5, 2659.9] {
            let back = camera.column_pixels(camera.bearing_radians(column)).unwrap();
            assert!((back - column).abs() < 1e-8, "{yaw} {column} {back}");
        }
        assert_eq!(camera.column_pixels(yaw + 0.6), None);
        assert_eq!(camera.column_pixels(yaw + std::f64::consts::PI), None, "behind");
    }
}

#[test]
fn in_view_is_between_the_edges_and_the_ranges() {
    let camera = wide();
    for (degrees, range, seen) in [
        (0.0_f64, 10.0, true),
        (31.4, 10.0, true),
        (31.6, 10.0, false),
        (0.0, 1.9, false),
        (0.0, 101.0, false),
    ] {
        assert_eq!(camera.sees(degrees.to_radians(), range), seen, "{degrees} {range}");
    }
    assert!(!camera.sees(f64::NAN, 10.0) && !camera.sees(0.0, f64::NAN));
}

#[test]
fn the_view_stands_where_the_vehicle_does() {
    let view = wide().view(&Pose::new(50.0, 50.0, FRAC_PI_2)).unwrap();
    for (east, north, seen) in
        [(50.0, 60.0, true), (60.0, 50.0, false), (50.0, 52.3, false), (50.0, 150.3, true)]
    {
        assert_eq!(view.contains([east, north].into()), seen, "{east} {north}");
    }
    assert!(wide().view(&Pose::new(f64::NAN, 0.0, 0.0)).is_err());
}

#[test]
fn boxes_that_cannot_be_are_left_out_and_counted() {
    let nan = DetectionBox { left: f64::NAN, ..upright(100.0) };
    let endless = DetectionBox { bottom: f64::INFINITY, ..upright(100.0) };
    let empty = DetectionBox { right: 90.0, ..upright(100.0) };
    let tall = DetectionBox { top: 400.0, ..upright(700.0) };
    let boxes = [upright(700.0), nan, endless, empty, upright(2655.0), upright(3.0), tall, upright(1330.0)];
    let detections = wide().detections(&boxes).unwrap();
    let reasons = [
        (1, BoxRefusal::NotANumber),
        (2, BoxRefusal::NotANumber),
        (3, BoxRefusal::Empty),
        (4, BoxRefusal::OutsideImage),
        (5, BoxRefusal::OutsideImage),
        (6, BoxRefusal::SameColumn),
    ];
    assert_eq!(detections.refused, reasons);
    assert_eq!(detections.bearings_radians, [700.0, 1330.0].map(|column| wide().bearing_radians(column)));
}

#[test]
fn ten_thousand_boxes_are_rejected_as_one() {
    let error = wide().detections(&vec![upright(700.0); 10_000]).unwrap_err();
    assert_mentions(&error.to_string(), "10000 boxes .. 256");
}

#[test]
fn invalid_cameras_give_the_reason() {
    let check = |change: fn(&mut CameraSettings), message: &str| {
        let mut settings = settings("wide", 63.0);
        change(&mut settings);
        let error = Camera::new(settings).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    };
    check(|camera| camera.name.clear(), "no name");
    check(|camera| camera.width_pixels = 0, "camera wide: an image of 0 x 1516");
    check(|camera| camera.field_of_view_radians = f64::NAN, "NaN radians");
    check(|camera| camera.field_of_view_radians = 63.0, "63 radians");
    check(|camera| camera.field_of_view_radians = 1e-320, "radians");
    check(|camera| camera.mounting.heading_radians = f64::INFINITY, "mounting");
    check(|camera| camera.min_range_meters = 0.0, "from 0 m to 100 m");
    check(|camera| camera.max_range_meters = f64::NAN, "to NaN m");
}
