use nalgebra::{Point3, Rotation3, Translation3};

use super::super::Distortion;
use super::*;
use crate::mentions::assert_mentions;

fn ranges() -> CameraRanges {
    CameraRanges { name: "front".to_owned(), min_range_meters: 1.0, max_range_meters: 50.0 }
}

/// The optical frame of a camera that looks along the x axis of a frame with z up.
fn optical() -> UnitQuaternion<f64> {
    let axes = nalgebra::Matrix3::from_columns(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}

/// At 0.2 m forward, 0.1 m to the right, 0.5 m up; degrees as in REP 103, pitch downward.
fn mounting(roll: f64, pitch: f64, yaw: f64) -> Isometry3<f64> {
    let turned = UnitQuaternion::from_euler_angles(roll.to_radians(), pitch.to_radians(), yaw.to_radians());
    Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.5), turned * optical())
}

fn pinhole() -> Lens {
    Lens::pinhole(1000, 600, 90.0_f64.to_radians())
}

fn mounted(lens: Lens, mounting: &Isometry3<f64>) -> MountedCamera {
    MountedCamera::new(ranges(), lens, mounting).unwrap()
}

fn around([column, row]: [f64; 2]) -> DetectionBox {
    DetectionBox { left: column - 2.0, top: row - 3.0, right: column + 2.0, bottom: row + 3.0 }
}

/// The bearings of what is at a point of the vehicle's frame, and where the camera should see it.
#[test]
fn bearings_are_those_of_the_points_in_a_box() {
    for [roll, pitch, yaw] in
        [[0.0, 0.0, 0.0], [0.0, 20.0, 0.0], [180.0, 10.0, 0.0], [90.0, 0.0, 0.0], [5.0, 15.0, 120.0]]
    {
        let vehicle_from_camera = mounting(roll, pitch, yaw);
        let camera = mounted(pinhole(), &vehicle_from_camera);
        let mut seen = 0;
        for (forward, left, up) in [(10.0, 2.0, -0.5), (20.0, -5.0, 0.0), (8.0, 0.0, -2.0), (10.0, 4.0, -1.0)]
        {
            let (sine, cosine) = yaw.to_radians().sin_cos();
            let point = Point3::new(cosine * forward - sine * left, sine * forward + cosine * left, up + 0.5);
            let in_camera = vehicle_from_camera.inverse() * point;
            let pixel = [500.0, 300.0]
                .into_iter()
                .zip([in_camera.x, in_camera.y])
                .map(|(middle, along)| middle + 500.0 * along / in_camera.z)
                .collect::<Vec<_>>();
            let detections = camera.detections(&[around([pixel[0], pixel[1]])]).unwrap();
            assert!(detections.refused.is_empty(), "{detections:?}");
            let [bearing] = detections.bearings_radians[..] else { panic!("{roll} {pitch} {yaw} {pixel:?}") };
            let offset = point.coords - vehicle_from_camera.translation.vector;
            assert!(turn_radians(bearing, offset.y.atan2(offset.x)).abs() < 1e-9);
            seen += 1;
        }
        assert_eq!(seen, 4);
    }
}

#[test]
fn a_level_pinhole_sees_as_its_description_by_hand() {
    let by_hand = Camera::new(CameraSettings {
        name: "front".to_owned(),
        width_pixels: 1000,
        height_pixels: 600,
        field_of_view_radians: 90.0_f64.to_radians(),
        mounting: Pose::new(0.2, -0.1, 30.0_f64.to_radians()),
        z_meters: 0.5,
        pitch_radians: 10.0_f64.to_radians(),
        min_range_meters: 1.0,
        max_range_meters: 50.0,
    })
    .unwrap();
    let measured = mounted(pinhole(), &mounting(0.0, 10.0, 30.0));
    let (found, expected) = (measured.camera().settings(), by_hand.settings());
    assert_eq!((found.width_pixels, found.height_pixels), (expected.width_pixels, expected.height_pixels));
    for (found, expected) in [
        (found.field_of_view_radians, expected.field_of_view_radians),
        (found.mounting.x_meters, expected.mounting.x_meters),
        (found.mounting.y_meters, expected.mounting.y_meters),
        (found.mounting.heading_radians, expected.mounting.heading_radians),
        (found.z_meters, expected.z_meters),
        (found.pitch_radians, expected.pitch_radians),
        (measured.camera().ground_meters(), by_hand.ground_meters()),
    ] {
        assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
    }
}

/// On its side a camera's view is as wide as its image is high; upside down its sides change places.
#[test]
fn the_view_is_between_the_sides_of_the_image() {
    let aside = Lens { center_pixels: [249.5, 299.5], ..pinhole() };
    let degrees = |radians: f64| format!("{:.1}", radians.to_degrees());
    let view = |lens: Lens, roll: f64| {
        let camera = mounted(lens, &mounting(roll, 0.0, 0.0));
        let settings = camera.camera().settings();
        let middle = settings.mounting.heading_radians;
        [-0.5, 0.5].map(|side| degrees(middle + side * settings.field_of_view_radians))
    };
    // The axis is in the left half of the image: to the right the camera sees farther.
    let (near, far) = ((250.0_f64 / 500.0).atan(), (750.0_f64 / 500.0).atan());
    assert_eq!(view(aside.clone(), 0.0), [degrees(-far), degrees(near)]);
    assert_eq!(view(aside.clone(), 180.0), [degrees(-near), degrees(far)]);
    let high = (300.0_f64 / 500.0).atan();
    assert_eq!(view(aside.clone(), 90.0), [degrees(-high), degrees(high)]);
    assert_eq!(view(aside, -90.0), [degrees(-high), degrees(high)]);
}

#[test]
fn of_a_fisheye_the_view_that_a_pinhole_can_have_is_used() {
    let lens = Lens {
        width_pixels: 1000,
        height_pixels: 1000,
        // 200 degrees from edge to edge.
        focal_pixels: [1000.0 / 200.0_f64.to_radians(); 2],
        center_pixels: [499.5; 2],
        distortion: Distortion::Equidistant([0.0; 4]),
    };
    let camera = mounted(lens, &mounting(0.0, 0.0, 0.0));
    assert!((camera.camera().settings().field_of_view_radians - MAX_VIEW_RADIANS).abs() < 1e-12);
    let bearings = |column| camera.detections(&[around([column, 500.0])]).unwrap().bearings_radians;
    // 40 degrees to the left.
    assert!((bearings(300.0)[0] - 40.0_f64.to_radians()).abs() < 1e-9);
    assert!(bearings(10.0).is_empty());
}

#[test]
fn a_camera_that_cannot_be_is_refused() {
    let refused = |lens: Lens, mounting: &Isometry3<f64>, words: &str| {
        let error = MountedCamera::new(ranges(), lens, mounting).unwrap_err();
        assert_mentions(&error.to_string(), words);
    };
    // A frame that is not optical: x forward, z up.
    refused(pinhole(), &Isometry3::translation(0.2, 0.0, 0.5), "straight up .. optical");
    refused(pinhole(), &mounting(0.0, 90.0, 0.0), "straight down");
    let folded = Distortion::Radial { radial: [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0], tangential: [0.0; 2] };
    refused(Lens { distortion: folded, ..pinhole() }, &mounting(0.0, 0.0, 0.0), "distortion .. within");
    let far = Isometry3 { translation: Translation3::new(0.0, 0.0, 5000.0), ..mounting(0.0, 0.0, 0.0) };
    refused(pinhole(), &far, "z_meters = 5000");
}

#[test]
fn invalid_boxes_are_counted() {
    let camera = mounted(pinhole(), &mounting(0.0, 0.0, 0.0));
    let good = around([400.0, 300.0]);
    let boxes = [
        good,
        good,
        DetectionBox { right: 1001.0, ..good },
        DetectionBox { bottom: good.top, ..good },
        DetectionBox { left: f64::NAN, ..good },
    ];
    let detections = camera.detections(&boxes).unwrap();
    assert_eq!(detections.bearings_radians.len(), 1);
    let expected = [
        (1, BoxRefusal::SameColumn),
        (2, BoxRefusal::OutsideImage),
        (3, BoxRefusal::Empty),
        (4, BoxRefusal::NotANumber),
    ];
    assert_eq!(detections.refused, expected);
    assert!(camera.detections(&vec![good; 257]).is_err());
}
