//! The bytes of messages equal those that rosbags writes.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use dragnet_ros2::cdr;
use dragnet_ros2::input::{Input, InputKind};
use dragnet_ros2::schema::RosMessage;
use dragnet_ros2::wire::robot::{BatteryState, Bool, CameraInfo, RegionOfInterest};
use dragnet_ros2::wire::standard::{
    Header, Quaternion, TFMessage, Time, Transform, TransformStamped, Vector3,
};
use interpreter::interpreter;
use serde_json::Value;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The messages of `tests/python/ros_messages.py`, by their names.
fn of_rosbags() -> Value {
    let script = Path::new(WORKSPACE).join("tests/python/ros_messages.py");
    let output = Command::new(interpreter(Path::new(WORKSPACE))).arg(script).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn header(frame: &str) -> Header {
    Header { stamp: Time { sec: 7, nanosec: 8 }, frame_id: frame.to_owned() }
}

fn transform(parent: &str, child: &str, x: f64) -> TransformStamped {
    TransformStamped {
        header: header(parent),
        child_frame_id: child.to_owned(),
        transform: Transform {
            translation: Vector3 { x, y: -2.0, z: 0.5 },
            rotation: Quaternion { x: 0.0, y: 0.0, z: 0.6, w: 0.8 },
        },
    }
}

fn check<T: RosMessage>(theirs: &Value, message: &T) -> Vec<u8> {
    let bytes = cdr::encode(message);
    let mut hexadecimal = String::new();
    for byte in &bytes {
        write!(hexadecimal, "{byte:02x}").unwrap();
    }
    assert_eq!(theirs[T::NAME].as_str().unwrap(), hexadecimal, "{}", T::NAME);
    bytes
}

#[test]
fn messages_have_the_bytes_of_rosbags() {
    let theirs = of_rosbags();
    let transforms = vec![transform("map", "odom", 1.5), transform("odom", "base_link", 3.0)];
    let bytes = check(&theirs, &TFMessage { transforms });
    let Input::Transforms(read) = InputKind::Transforms.understand(&bytes).unwrap() else { panic!() };
    assert_eq!((read.valid.len(), read.valid[1].translation_meters), (2, [3.0, -2.0, 0.5]));

    let info = CameraInfo {
        header: header("front_optical"),
        height: 480,
        width: 640,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![0.1, -0.2, 0.001, 0.002, 0.03],
        k: [[500.0, 0.0, 320.0], [0.0, 510.0, 240.0], [0.0, 0.0, 1.0]],
        r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        p: [[490.0, 0.0, 321.0, 0.0], [0.0, 491.0, 241.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        binning_x: 0,
        binning_y: 2,
        roi: RegionOfInterest { x_offset: 1, y_offset: 2, height: 3, width: 4, do_rectify: true },
    };
    let bytes = check(&theirs, &info);
    assert!(matches!(InputKind::CameraInfo.understand(&bytes).unwrap(), Input::CameraInfo(_)));

    let bytes = check(&theirs, &Bool { data: true });
    assert_eq!(InputKind::Stop.understand(&bytes).unwrap(), Input::Stop(true));

    // The NaN of Python.
    let battery = BatteryState {
        header: header(""),
        voltage: 12.5,
        temperature: f32::NAN,
        current: -1.5,
        charge: f32::NAN,
        capacity: f32::NAN,
        design_capacity: f32::NAN,
        percentage: 0.75,
        power_supply_status: 2,
        power_supply_health: 1,
        power_supply_technology: 3,
        present: true,
        cell_voltage: vec![4.1, 4.2, 4.2],
        cell_temperature: Vec::new(),
        location: "left".to_owned(),
        serial_number: "7".to_owned(),
    };
    let bytes = check(&theirs, &battery);
    let Input::Battery(read) = InputKind::Battery.understand(&bytes).unwrap() else { panic!() };
    assert_eq!(read.percent, Some(75.0));
}
