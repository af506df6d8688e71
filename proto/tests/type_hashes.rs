//! The type hashes of all messages are those of rosbags, which has ROS 2's definitions and its own way from them to a
//! hash.
#![expect(clippy::unwrap_used, reason = "a test fails by panic")]

#[path = "../../tests/python/interpreter.rs"]
mod interpreter;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use dragnet_proto::ros::MessageType;
use dragnet_proto::ros::input::InputKind;
use dragnet_proto::ros::output::OutputKind;
use dragnet_proto::schema::{NAMES, schema, type_hash};
use interpreter::interpreter;
use serde_json::{Map, Value};

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

fn of_rosbags(schemas: &Map<String, Value>) -> Value {
    let script = Path::new(WORKSPACE).join("tests/python/type_hashes.py");
    let mut python = Command::new(interpreter(Path::new(WORKSPACE)));
    let mut child = python.arg(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(&serde_json::to_vec(schemas).unwrap()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn hashes_are_those_of_rosbags() {
    let schemas = NAMES.iter().map(|name| ((*name).to_owned(), schema(name).into())).collect();
    let theirs = of_rosbags(&schemas);
    for name in NAMES {
        assert_eq!(theirs[name]["hash"], type_hash(name), "{name}");
        let is_ros =
            !["dragnet_msgs/", "foxglove_msgs/", "vision_msgs/"].iter().any(|own| name.starts_with(own));
        assert_eq!(theirs[name]["known"], is_ros, "{name}");
    }
}

/// Nothing is spoken on a robot's network that was not held against rosbags.
#[test]
fn every_message_of_a_robots_network_is_among_them() {
    let inputs = [
        InputKind::Odometry,
        InputKind::Pose,
        InputKind::Fix,
        InputKind::Map,
        InputKind::Detections,
        InputKind::Image,
        InputKind::CompressedImage,
        InputKind::Goals,
    ];
    let outputs = [
        OutputKind::Goal,
        OutputKind::Path,
        OutputKind::Belief,
        OutputKind::Objects,
        OutputKind::Tracks,
        OutputKind::Diagnostics,
    ];
    let spoken = inputs.map(InputKind::message).into_iter().chain(outputs.map(OutputKind::message));
    for MessageType { name, hash } in spoken {
        assert!(NAMES.contains(&name), "{name}");
        assert_eq!(hash, type_hash(name), "{name}");
    }
}
