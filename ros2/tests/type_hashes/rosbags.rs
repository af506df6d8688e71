//! Type hashes as computed by rosbags.

#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use dragnet_ros2::schema::{Definitions, schema};
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

/// The result of rosbags for a message.
pub(crate) struct Theirs {
    pub(crate) hash: String,
    /// Whether it is part of ROS 2.
    pub(crate) is_known: bool,
}

/// The results for messages, by name.
pub(crate) fn hashes(names: &[&str], known: Definitions) -> Vec<(String, Theirs)> {
    let schemas = names.iter().map(|name| ((*name).to_owned(), schema(name, known).into())).collect();
    let theirs = of_rosbags(&schemas);
    let of = |name: &str| Theirs {
        hash: theirs[name]["hash"].as_str().unwrap().to_owned(),
        is_known: theirs[name]["known"].as_bool().unwrap(),
    };
    names.iter().map(|name| ((*name).to_owned(), of(name))).collect()
}
