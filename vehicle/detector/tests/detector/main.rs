//! The detector with its network: compared with ultralytics, and with modules that fail.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

#[path = "../../../../tests/python/interpreter.rs"]
mod interpreter;
mod modules;
mod prepared;
mod ultralytics;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dragnet_detector::network::{Device, Network, NetworkError};
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

    fn network(&self, name: &str) -> Result<Network, NetworkError> {
        Network::load(&self.bytes(&format!("{name}.torchscript")), None, Device::Cpu)
    }
}
