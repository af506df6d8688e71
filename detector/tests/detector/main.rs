//! The detector with its network: against ultralytics, and with modules that fail.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod modules;
mod prepared;
mod ultralytics;

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dragnet_detector::network::{Device, Network, NetworkError};
use tempfile::TempDir;

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// A folder with what a script of `tests/python` writes there.
struct Written(TempDir);

impl Written {
    /// Without the interpreter the test fails: to skip it would look like a detector that another has checked.
    fn by(script: &str) -> Self {
        let given = env::var_os("DRAGNET_PYTHON").map(PathBuf::from);
        let interpreter = given.unwrap_or_else(|| Path::new(WORKSPACE).join(".venv/bin/python"));
        let path = interpreter.display();
        assert!(
            interpreter.exists(),
            "{path} is missing: ./test.sh makes it; or name one with ultralytics in DRAGNET_PYTHON"
        );
        let folder = TempDir::new().unwrap();
        let script = Path::new(WORKSPACE).join("tests/python").join(script);
        let output = Command::new(&interpreter).arg(script).arg(folder.path()).output().unwrap();
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
