//! The detector with its network: compared with ultralytics, with networks that fail, and with files that are none.
#![cfg(all(feature = "torch", feature = "onnx"))]
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod example;
#[path = "../../../../tests/python/interpreter.rs"]
mod interpreter;
mod modules;
mod onnx;
mod prepared;
mod ultralytics;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dragnet_detector::network::{Format, Network, NetworkError};
use dragnet_detector::picture::Size;
use dragnet_detector::settings::Processor;
use interpreter::interpreter;
use tempfile::TempDir;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A folder with the output of a script of `tests/python`.
struct Written(TempDir);

impl Written {
    fn by(script: &str) -> Self {
        let workspace = Path::new(WORKSPACE);
        let folder = TempDir::new().unwrap();
        let script = workspace.join("tests/python").join(script);
        let output = Command::new(interpreter(workspace)).arg(script).arg(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Of the file with this name.
    fn network(&self, name: &str) -> Result<Network, NetworkError> {
        load(name, &self.bytes(name), None)
    }
}

/// As from a file with this name.
fn load(name: &str, bytes: &[u8], input: Option<Size>) -> Result<Network, NetworkError> {
    Network::load(Format::of(Path::new(name)), bytes, input, Processor::default())
}

/// One line of bounded length that says all of this.
fn says(error: &NetworkError, said: &[&str]) {
    let text = error.to_string();
    for said in said {
        assert!(text.contains(said), "{text:?} does not say {said:?}");
    }
    assert!(text.lines().count() == 1 && text.len() < 500, "{text}");
}
