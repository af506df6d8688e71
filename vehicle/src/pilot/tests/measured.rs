//! Cameras whose lens and mounting come with their frames.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::*;
use crate::camera::{DetectionBox, Lens, MountedCamera};
use crate::settings::Measured;

/// A drive whose front camera is measured: the camera, and its pose.
fn measured() -> (Drive, Arc<MountedCamera>, Isometry3<f64>) {
    let mut settings = settings();
    settings.cameras.truncate(1);
    let table = &mut settings.cameras[0];
    (table.width_pixels, table.height_pixels, table.field_of_view_degrees) = (None, None, None);
    table.yaw_degrees = None;
    let by = BTreeMap::from([("front".to_owned(), Measured::OpticsAndMounting)]);
    let mut drive = Drive::new(&super::settings());
    let checked = settings.check_measured(None, &by).unwrap();
    let optical = nalgebra::Matrix3::from_columns(&[-Vector3::y(), -Vector3::z(), Vector3::x()]);
    let rotation = Rotation3::from_euler_angles(0.1, 0.2, 0.0) * Rotation3::from_matrix_unchecked(optical);
    let mounting = Isometry3::from_parts(
        Translation3::new(0.5, 0.2, 1.0),
        UnitQuaternion::from_rotation_matrix(&rotation),
    );
    let lens = Lens::pinhole(1000, 600, 125.0_f64.to_radians());
    let camera = Arc::new(checked.measured_cameras[0].mounted(lens, &mounting).unwrap());
    let scenario = scenario();
    let map = CostMap::from_terrain(scenario.terrain(), 8).unwrap();
    drive.pilot = Pilot::new(checked, scenario.terrain().clone(), scenario.sensor().clone(), &map).unwrap();
    drive.cameras = vec![camera.camera().clone()];
    (drive, camera, mounting)
}

/// The box of an object on the ground, if it is in the image.
fn seen(drive: &Drive, mounting: &Isometry3<f64>, object: Vector2<f64>) -> Vec<DetectionBox> {
    let place = Pose::new(object.x, object.y, 0.0).seen_from(&drive.pose);
    let point = mounting.inverse() * Point3::new(place.x_meters, place.y_meters, 0.5);
    let focal = 500.0 / (125.0_f64.to_radians() / 2.0).tan();
    let (column, row) = (500.0 + focal * point.x / point.z, 300.0 + focal * point.y / point.z);
    let is_seen = point.z > 0.0 && (5.0..995.0).contains(&column) && (5.0..595.0).contains(&row);
    let found = DetectionBox { left: column - 4.0, top: row - 4.0, right: column + 4.0, bottom: row + 4.0 };
    is_seen.then_some(found).into_iter().collect()
}

#[test]
fn a_measured_camera_finds_what_it_sees() {
    let (mut drive, camera, mounting) = measured();
    let object = Vector2::new(125.0, 45.0);
    let route = [(2, 3), (2, 4), (2, 5)];
    drive.tell(Event::Route(cells(&route)));
    for _ in 0..400 {
        drive.step_with(|drive, described| {
            let boxes = seen(drive, &mounting, object);
            let detections = CameraDetections::Measured { camera: Arc::clone(&camera), boxes };
            Some(CameraFrame { detections, ..drive.frame(described) })
        });
    }
    assert_eq!(reported(&drive.actions), Vec::<String>::new());
    let track = drive.pilot.tracks().iter().max_by_key(|track| track.hits()).unwrap();
    let off = (track.position_meters() - object).norm();
    assert!(track.hits() > 20 && off < 3.0, "{} hits, {off} m away", track.hits());
}

#[test]
fn a_frame_without_its_camera_is_rejected() {
    let (mut drive, camera, _) = measured();
    let boxes = CameraDetections::Boxes(Vec::new());
    let frame = CameraFrame { detections: boxes, ..drive.frame(camera.camera()) };
    let actions = drive.tell(Event::Frame(frame));
    assert!(message(&actions).contains("without its camera"), "{actions:?}");
}
