use std::f64::consts::PI;

use dragnet_scenario::map_file::{GeoPoint, Georeference};
use proptest::prelude::*;

use super::*;
use crate::mentions::assert_mentions;
use crate::wire::robot::{GoalInfo, PoseWithCovariance};
use crate::wire::standard::{
    Header, MapMetaData, OccupancyGrid, Point, Pose, Quaternion, TFMessage, Time, TransformStamped,
};
use crate::wire::vision::{Detection2D, Detection2DArray, ObjectHypothesisWithPose};

fn header() -> Header {
    Header { stamp: Time { sec: 3, nanosec: 4 }, frame_id: "map".into() }
}

fn understand<T: serde::Serialize>(kind: InputKind, message: &T) -> Result<Input, String> {
    kind.understand(&cdr::encode(message)).map_err(|error| error.to_string())
}

/// A change that makes a message invalid, and its error.
type Spoiled<T> = (fn(&mut T), &'static str);

/// Each change of a valid message is rejected, for this reason.
fn check<T: serde::Serialize + Clone>(kind: InputKind, good: &T, changes: &[Spoiled<T>]) {
    understand(kind, good).unwrap();
    for (change, reason) in changes {
        let mut bad = good.clone();
        change(&mut bad);
        let error = understand(kind, &bad).unwrap_err();
        assert_mentions(&error, reason);
        assert!(error.contains("allowed"), "{error}");
    }
}

fn odometry() -> robot::Odometry {
    let mut odometry =
        robot::Odometry { header: header(), child_frame_id: "base".into(), ..robot::Odometry::default() };
    let position = Point { x: 1.0, y: 2.0, z: 3.0 };
    let (sine, cosine) = (PI / 8.0).sin_cos();
    odometry.pose.pose = Pose { position, orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine } };
    for (index, row) in odometry.pose.covariance.iter_mut().enumerate() {
        row[index] = 1.0 + index as f64;
    }
    odometry.pose.covariance[0][5] = 0.5;
    odometry.pose.covariance[5][0] = 0.5;
    odometry.twist.twist.linear.x = 0.7;
    odometry.twist.twist.linear.y = -0.1;
    odometry.twist.twist.angular.z = 0.2;
    odometry
}

#[test]
fn odometry_is_read_in_meters_and_radians() {
    let Input::Odometry(read) = understand(InputKind::Odometry, &odometry()).unwrap() else { panic!() };
    assert_eq!((read.place.stamp_unix_ns, read.place.frame.as_str()), (3_000_000_004, "map"));
    assert_eq!((read.place.pose.x_meters, read.place.pose.y_meters), (1.0, 2.0));
    assert!((read.place.pose.yaw_radians - PI / 4.0).abs() < 1e-12);
    assert_eq!(read.place.covariance, Some([[1.0, 0.0, 0.5], [0.0, 2.0, 0.0], [0.5, 0.0, 6.0]]));
    let velocity = Velocity {
        forward_meters_per_second: 0.7,
        left_meters_per_second: -0.1,
        yaw_radians_per_second: 0.2,
    };
    assert_eq!((read.velocity, read.robot_frame.as_str()), (velocity, "base"));
}

#[test]
fn invalid_odometry_is_rejected_with_its_field() {
    check(
        InputKind::Odometry,
        &odometry(),
        &[
            (
                |odometry| odometry.pose.pose.position.y = f64::NAN,
                "nav_msgs/msg/Odometry: pose.pose.position.y is NaN",
            ),
            (
                |odometry| odometry.pose.pose.orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 },
                "orientation is (0, 0, 0, 0)",
            ),
            (|odometry| odometry.pose.pose.orientation.w = f64::NAN, "a quaternion of length 1"),
            (|odometry| odometry.pose.covariance[1][1] = -2.0, "pose.covariance is"),
            (|odometry| odometry.pose.covariance[5][5] = f64::INFINITY, "pose.covariance is"),
            (|odometry| odometry.pose.covariance[0][5] = 0.4, "symmetric"),
            (
                |odometry| (odometry.pose.covariance[0][1], odometry.pose.covariance[1][0]) = (9.0, 9.0),
                "above its variances",
            ),
            (|odometry| odometry.twist.twist.linear.x = f64::NEG_INFINITY, "twist.twist.linear.x is -inf"),
            (|odometry| odometry.header.stamp.nanosec = 1_000_000_000, "header.stamp.nanosec is 1000000000"),
            (|odometry| odometry.header.frame_id = "x".repeat(257), "header.frame_id is 257 long"),
        ],
    );
}

#[test]
fn an_unknown_covariance_is_none() {
    for first in [0.0, -1.0] {
        let mut pose = PoseWithCovariance::default();
        pose.covariance[0][0] = first;
        let pose = robot::PoseWithCovarianceStamped { header: header(), pose };
        let Input::Pose(read) = understand(InputKind::Pose, &pose).unwrap() else { panic!() };
        assert_eq!((read.covariance, read.pose), (None, PlanarPose::default()));
    }
}

/// A turned robot on a slope: yaw is that of its heading on the plane.
#[test]
fn yaw_is_the_rotation_without_pitch_and_roll() {
    for (yaw, pitch, roll) in [(2.5_f64, 0.3_f64, 0.0_f64), (-2.9, -0.4, 0.2), (0.1, 0.0, -0.5)] {
        let ((sy, cy), (sp, cp), (sr, cr)) =
            ((yaw / 2.0).sin_cos(), (pitch / 2.0).sin_cos(), (roll / 2.0).sin_cos());
        let orientation = Quaternion {
            x: sr * cp * cy - cr * sp * sy,
            y: cr * sp * cy + sr * cp * sy,
            z: cr * cp * sy - sr * sp * cy,
            w: cr * cp * cy + sr * sp * sy,
        };
        let mut pose = robot::PoseWithCovarianceStamped { header: header(), ..Default::default() };
        pose.pose.pose.orientation = orientation;
        let Input::Pose(read) = understand(InputKind::Pose, &pose).unwrap() else { panic!() };
        assert!((read.pose.yaw_radians - yaw).abs() < 1e-12, "{yaw} {}", read.pose.yaw_radians);
    }
}

#[test]
fn a_fix_is_a_place_on_the_map() {
    let mut fix =
        robot::NavSatFix { header: header(), latitude: 45.001, longitude: 10.002, ..Default::default() };
    fix.altitude = f64::NAN;
    fix.position_covariance = [[4.0, 1.0, 9.0], [1.0, 5.0, 9.0], [7.0, 7.0, 6.0]];
    fix.position_covariance_type = 2;
    let Input::Fix(read) = understand(InputKind::Fix, &fix).unwrap() else { panic!() };
    let origin = GeoPoint { longitude_degrees: 10.0, latitude_degrees: 45.0 };
    let (east, north) = read.meters(&Georeference::new(origin, 45.0));
    assert!((east - 157.69).abs() < 0.1 && (north - 111.13).abs() < 0.1, "{east} {north}");
    assert_eq!((read.altitude_meters, read.covariance_square_meters), (None, Some([[4.0, 1.0], [1.0, 5.0]])));
    check(
        InputKind::Fix,
        &fix,
        &[
            (|fix| fix.status.status = -1, "status.status .. -1 .. 0 or more, a fix"),
            (|fix| fix.latitude = 90.5, "latitude .. 90.5 .. -90 to 90"),
            (|fix| fix.longitude = f64::NAN, "longitude is NaN"),
            (|fix| fix.altitude = f64::INFINITY, "altitude is inf"),
            (|fix| fix.position_covariance[1][1] = -1.0, "position_covariance is"),
        ],
    );
}

#[test]
fn a_map_has_the_declared_number_of_cells() {
    let origin = Pose { position: Point { x: -1.0, y: -2.0, z: 0.0 }, ..Pose::default() };
    let info = MapMetaData { resolution: 0.5, width: 3, height: 2, origin, ..MapMetaData::default() };
    let map = OccupancyGrid { header: header(), info, data: vec![0, 100, -1, 0, 0, 7] };
    let Input::Map(read) = understand(InputKind::Map, &map).unwrap() else { panic!() };
    assert_eq!((read.grid.rows(), read.grid.columns(), read.cells), (2, 3, map.data.clone()));
    assert_eq!((read.cell_meters, read.origin.x_meters, read.origin.y_meters), (0.5, -1.0, -2.0));
    check(
        InputKind::Map,
        &map,
        &[
            (|map| map.info.width = 4, "data .. 6 long .. 8"),
            (|map| map.info.height = 0, "info is 3 x 0 cells"),
            (
                |map| (map.info.width, map.info.height) = (u32::MAX, u32::MAX),
                "allowed is 1 to 16777216 cells",
            ),
            (|map| map.data[3] = -2, "data[3] is -2"),
            (|map| map.info.resolution = 0.0, "info.resolution is 0"),
            (|map| map.info.origin.position.x = f64::NAN, "info.origin.position.x is NaN"),
        ],
    );
}

fn detections() -> Detection2DArray {
    let mut seen = Detection2D::default();
    (seen.bbox.center.position.x, seen.bbox.center.position.y) = (100.0, 50.0);
    (seen.bbox.size_x, seen.bbox.size_y) = (20.0, 40.0);
    for (class, score) in [("dog", 0.2), ("person", 0.8), ("post", 0.1)] {
        let mut result = ObjectHypothesisWithPose::default();
        (result.hypothesis.class_id, result.hypothesis.score) = (class.into(), score);
        seen.results.push(result);
    }
    let mut turned = Detection2D { results: Vec::new(), ..seen.clone() };
    turned.bbox.center.theta = PI / 2.0;
    Detection2DArray { header: header(), detections: vec![seen, turned] }
}

#[test]
fn boxes_are_read_by_their_edges_and_most_likely_class() {
    let Input::Detections(read) = understand(InputKind::Detections, &detections()).unwrap() else { panic!() };
    let has_edges = |seen: &DetectedBox, expected: [f64; 4]| {
        let edges = [seen.left, seen.top, seen.right, seen.bottom];
        edges.iter().zip(expected).all(|(edge, expected)| (edge - expected).abs() < 1e-9)
    };
    assert!(has_edges(&read.boxes[0], [90.0, 30.0, 110.0, 70.0]), "{:?}", read.boxes[0]);
    assert!(has_edges(&read.boxes[1], [80.0, 40.0, 120.0, 60.0]), "{:?}", read.boxes[1]);
    assert_eq!(read.boxes[0].hypothesis, Some(Hypothesis { class: "person".into(), score: 0.8 }));
    assert_eq!((read.boxes[1].hypothesis.as_ref(), read.stamp_unix_ns), (None, 3_000_000_004));
    check(
        InputKind::Detections,
        &detections(),
        &[
            (
                |array| array.detections[1].bbox.center.position.x = f64::NAN,
                "detections[1].bbox.center.position.x is NaN",
            ),
            (
                |array| array.detections[0].bbox.size_y = 0.0,
                "detections[0].bbox.size_y .. 0 .. above 0 pixels",
            ),
            (|array| array.detections[0].results[1].hypothesis.score = 80.0, "score .. 80 .. 0 to 1"),
            (
                |array| array.detections = vec![Detection2D::default(); 257],
                "detections .. 257 long .. at most 256",
            ),
            (
                |array| array.detections[0].results = vec![ObjectHypothesisWithPose::default(); 129],
                "results is 129 long",
            ),
        ],
    );
}

fn image(encoding: &str, pixel: &[u8]) -> robot::Image {
    let step = u32::try_from(2 * pixel.len() + 3).unwrap();
    let row = [pixel, pixel, &[99; 3]].concat();
    let data = [row.clone(), row].concat();
    robot::Image {
        header: header(),
        height: 2,
        width: 2,
        encoding: encoding.into(),
        is_bigendian: 0,
        step,
        data,
    }
}

#[test]
fn an_image_of_any_encoding_is_converted_to_rgb() {
    for (encoding, pixel) in [
        ("rgb8", &[10_u8, 20, 30][..]),
        ("bgr8", &[30, 20, 10]),
        ("rgba8", &[10, 20, 30, 0]),
        ("bgra8", &[30, 20, 10, 0]),
    ] {
        let Input::Image(read) = understand(InputKind::Image, &image(encoding, pixel)).unwrap() else {
            panic!()
        };
        assert_eq!(
            (read.width_pixels, read.height_pixels, read.rgb),
            (2, 2, [10, 20, 30].repeat(4)),
            "{encoding}"
        );
    }
    let Input::Image(read) = understand(InputKind::Image, &image("mono8", &[9])).unwrap() else { panic!() };
    assert_eq!(read.rgb, [9; 12]);
    check(
        InputKind::Image,
        &image("rgb8", &[1, 2, 3]),
        &[
            (|image| image.encoding = "bayer_rggb8".into(), "encoding .. \"bayer_rggb8\" .. rgb8"),
            (|image| image.step = 5, "step .. 5 .. at least 6"),
            (|image| image.height = 3, "data .. 18 long .. 27"),
            (|image| image.width = 0, "size is 0 x 2"),
            (|image| (image.width, image.height) = (1 << 20, 1 << 20), "allowed is 1 to 16777216 pixels"),
        ],
    );
}

#[test]
fn a_compressed_image_is_the_picture_that_was_compressed() {
    let picture = image::RgbImage::from_pixel(16, 8, image::Rgb([200, 60, 20]));
    for format in [image::ImageFormat::Jpeg, image::ImageFormat::Png] {
        let mut data = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut data, format).unwrap();
        let message =
            robot::CompressedImage { header: header(), format: "whatever".into(), data: data.into_inner() };
        let Input::Image(read) = understand(InputKind::CompressedImage, &message).unwrap() else { panic!() };
        assert_eq!((read.width_pixels, read.height_pixels, read.rgb.len()), (16, 8, 16 * 8 * 3));
        let expected = [200_u8, 60, 20].into_iter().cycle();
        assert!(read.rgb.iter().zip(expected).all(|(&read, expected)| read.abs_diff(expected) < 6));
        check(
            InputKind::CompressedImage,
            &message,
            &[
                (|image| image.data.truncate(20), "data is "),
                (|image| image.data = b"GIF89a".to_vec(), "6 bytes .. JPEG or PNG"),
                (|image| image.data.clear(), "0 bytes of neither"),
            ],
        );
    }
}

#[test]
fn goals_are_read_with_their_state() {
    let mut goals = robot::GoalStatusArray::default();
    let goal_info = GoalInfo { goal_id: robot::Uuid { uuid: [7; 16] }, stamp: Time { sec: 1, nanosec: 0 } };
    goals.status_list.push(robot::GoalStatus { goal_info, status: 4 });
    let Input::Goals(read) = understand(InputKind::Goals, &goals).unwrap() else { panic!() };
    let expected =
        GoalStatus { goal: GoalId([7; 16]), accepted_unix_ns: 1_000_000_000, state: GoalState::Succeeded };
    assert_eq!(read, [expected]);
    check(
        InputKind::Goals,
        &goals,
        &[
            (|goals| goals.status_list[0].status = 7, "status_list[0].status .. 7 .. 0 to 6"),
            (|goals| goals.status_list[0].status = -1, "status_list[0].status is -1"),
            (|goals| goals.status_list = vec![goals.status_list[0]; 1025], "status_list is 1025 long"),
        ],
    );
}

#[test]
fn a_message_of_another_type_is_rejected() {
    let messages = [
        cdr::encode(&odometry()),
        cdr::encode(&robot::PoseWithCovarianceStamped { header: header(), ..Default::default() }),
        cdr::encode(&robot::NavSatFix { header: header(), ..Default::default() }),
        cdr::encode(&detections()),
        cdr::encode(&image("rgb8", &[1, 2, 3])),
    ];
    for (index, kind) in
        [InputKind::Odometry, InputKind::Pose, InputKind::Fix, InputKind::Detections, InputKind::Image]
            .into_iter()
            .enumerate()
    {
        for (other, bytes) in messages.iter().enumerate() {
            assert_eq!(kind.understand(bytes).is_ok(), index == other, "{kind:?} {other}");
        }
    }
}

#[test]
fn too_long_messages_are_not_even_decoded() {
    for kind in InputKind::ALL {
        let error = kind.understand(&vec![0; kind.max_bytes() + 1]).unwrap_err().to_string();
        assert!(error.contains(&format!("allowed are at most {}", kind.max_bytes())), "{error}");
    }
}

fn transform(parent: &str, child: &str) -> TransformStamped {
    let header = Header { frame_id: parent.into(), ..header() };
    TransformStamped { header, child_frame_id: child.into(), ..TransformStamped::default() }
}

#[test]
fn of_the_transforms_of_a_message_each_is_checked() {
    let mut spoiled = [(); 6].map(|()| transform("map", "odom"));
    spoiled[0].transform.rotation.w = f64::NAN;
    spoiled[1].transform.rotation.x = 1.0;
    spoiled[2].transform.translation.z = f64::INFINITY;
    spoiled[3].child_frame_id = "/".into();
    spoiled[4].header.frame_id = "long".repeat(65);
    spoiled[5].header.stamp.nanosec = 1_000_000_000;
    let good = transform("/odom", "base_link");
    let transforms = spoiled.into_iter().chain([good]).collect();
    for kind in [InputKind::Transforms, InputKind::StaticTransforms] {
        let read = understand(kind, &TFMessage { transforms: Vec::clone(&transforms) }).unwrap();
        let (Input::Transforms(read) | Input::StaticTransforms(read)) = read else { panic!() };
        let expected = Transform {
            stamp_unix_ns: 3_000_000_004,
            parent: "/odom".to_owned(),
            child: "base_link".to_owned(),
            translation_meters: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
        };
        assert_eq!(read.valid, [expected]);
        let reasons = [
            "\"map\" to \"odom\": rotation .. NaN .. length 1",
            "rotation .. (1, 0, 0, 1) .. length 1",
            "translation.z .. inf",
            "child_frame_id .. \"/\" .. name of a frame",
            "header.frame_id .. 260 long",
            "nanosec",
        ];
        assert_eq!(read.rejected.len(), reasons.len());
        for (found, reason) in read.rejected.iter().zip(reasons) {
            assert_mentions(found, reason);
        }
    }
    let many = TFMessage { transforms: vec![transform("a", "b"); 1025] };
    assert!(understand(InputKind::Transforms, &many).unwrap_err().contains("1025 long"));
}

fn camera_info() -> robot::CameraInfo {
    robot::CameraInfo {
        header: header(),
        height: 480,
        width: 640,
        distortion_model: "plumb_bob".into(),
        d: vec![0.1, -0.2, 0.001, 0.002, 0.03],
        k: [[500.0, 0.0, 320.0], [0.0, 510.0, 240.0], [0.0, 0.0, 1.0]],
        ..robot::CameraInfo::default()
    }
}

fn calibration(info: &robot::CameraInfo) -> CameraInfo {
    match understand(InputKind::CameraInfo, info).unwrap() {
        Input::CameraInfo(read) => read,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_calibration_is_that_of_the_published_image() {
    let whole = calibration(&camera_info());
    assert_eq!((whole.width_pixels, whole.height_pixels, whole.frame.as_str()), (640, 480, "map"));
    assert_eq!((whole.focal_pixels, whole.center_pixels), ([500.0, 510.0], [320.0, 240.0]));
    assert_eq!(whole.distortion, Distortion::PlumbBob([0.1, -0.2, 0.001, 0.002, 0.03]));
    let mut part = camera_info();
    (part.binning_x, part.binning_y) = (2, 2);
    part.roi =
        robot::RegionOfInterest { x_offset: 20, y_offset: 40, height: 400, width: 600, do_rectify: false };
    let part = calibration(&part);
    assert_eq!((part.width_pixels, part.height_pixels), (300, 200));
    assert_eq!((part.focal_pixels, part.center_pixels), ([250.0, 255.0], [150.0, 100.0]));
}

#[test]
fn distortion_is_that_of_its_model() {
    let distortion = |model: &str, d: &[f64]| {
        let info = robot::CameraInfo { distortion_model: model.into(), d: d.to_vec(), ..camera_info() };
        calibration(&info).distortion
    };
    assert_eq!(distortion("plumb_bob", &[0.0; 5]), Distortion::None);
    assert_eq!(distortion("", &[]), Distortion::None);
    assert_eq!(
        distortion("plumb_bob", &[1.0, 2.0, 3.0, 4.0]),
        Distortion::PlumbBob([1.0, 2.0, 3.0, 4.0, 0.0])
    );
    let eight = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    assert_eq!(distortion("rational_polynomial", &eight), Distortion::RationalPolynomial(eight));
    let more = [&eight[..], &[0.0; 4]].concat();
    assert_eq!(distortion("rational_polynomial", &more), Distortion::RationalPolynomial(eight));
    // A fisheye lens without coefficients is no pinhole.
    assert_eq!(distortion("equidistant", &[0.0; 4]), Distortion::Equidistant([0.0; 4]));
}

#[test]
fn an_invalid_calibration_is_rejected_with_its_field() {
    check(
        InputKind::CameraInfo,
        &camera_info(),
        &[
            (|info| info.k = [[0.0; 3]; 3], "k is all 0 .. not calibrated"),
            (|info| info.k[0][0] = -1.0, "k[0] is -1"),
            (|info| info.k[1][1] = f64::NAN, "k[4] is NaN"),
            (|info| info.k[0][2] = f64::NAN, "k[2] is NaN"),
            (|info| info.k[0][1] = 0.5, "k[1] is 0.5"),
            (|info| info.width = 0, "width is 0"),
            (|info| info.height = u32::MAX, "height is 4294967295"),
            (|info| info.binning_x = 1000, "width is 640"),
            (|info| info.distortion_model = "mei".into(), "distortion_model is \"mei\" .. equidistant"),
            (|info| info.distortion_model = String::new(), "distortion_model is \"\""),
            (|info| info.d = vec![0.1], "d is [0.1] .. the 5 coefficients of plumb_bob"),
            (|info| info.d.push(0.1), "the 5 coefficients"),
            (|info| info.d[2] = f64::NAN, "d[2] is NaN"),
        ],
    );
}

#[test]
fn a_charge_is_a_share_that_may_be_unknown() {
    let percent = |percentage: f32| {
        let battery = robot::BatteryState { percentage, ..robot::BatteryState::default() };
        match understand(InputKind::Battery, &battery) {
            Ok(Input::Battery(read)) => Ok(read.percent),
            Ok(other) => panic!("{other:?}"),
            Err(error) => Err(error),
        }
    };
    assert_eq!(percent(0.25), Ok(Some(25.0)));
    assert_eq!(percent(f32::NAN), Ok(None));
    for wrong in [87.0, -0.5, f32::INFINITY] {
        assert_mentions(&percent(wrong).unwrap_err(), "percentage .. 0 to 1");
    }
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_rejected(
        body in proptest::collection::vec(prop_oneof![Just(0_u8), any::<u8>()], 0..600),
    ) {
        let bytes = [&[0, 1, 0, 0], body.as_slice()].concat();
        for kind in InputKind::ALL {
            let _ = kind.understand(&bytes);
        }
    }
}
