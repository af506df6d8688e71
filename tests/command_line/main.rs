//! The command line as a user has it: real processes, their output and exit codes.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by a panic; Clippy knows only functions marked as tests"
)]

mod bad_input;
mod benchmark;
mod calibrate;
mod compare;
mod demonstrations;
mod detect;
mod exports;
#[path = "../python/interpreter.rs"]
mod interpreter;
mod output;
mod paper;
mod periods;
mod python;
mod recordings;
#[cfg(feature = "train")]
mod reinforcement;
mod run;
mod scale;
mod scenarios;
mod shards;
mod soak;
#[cfg(feature = "train")]
mod training;
mod weights;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A small search that ends within a second.
const SMALL: &str = "\
name = 'small'
[map]
shape = 'all_traversable'
rows = 12
columns = 12
[objects]
count = 4
[robots]
count = 2
[mission]
budget_meters = 1800.0
";

/// A working directory of one test.
struct Place {
    folder: TempDir,
}

impl Place {
    /// With `small.toml` in it.
    fn new() -> Self {
        let place = Self { folder: TempDir::new().unwrap() };
        place.write("small.toml", SMALL);
        place
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dragnet"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    fn dragnet(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// The output of a successful command.
    fn succeed(&self, arguments: &[&str]) -> String {
        let output = self.dragnet(arguments);
        assert!(output.status.success(), "{arguments:?}\n{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The JSON object that a command prints.
    fn json(&self, arguments: &[&str]) -> Value {
        let text = self.succeed(arguments);
        assert_eq!(text.lines().count(), 1, "{text}");
        serde_json::from_str(&text).unwrap()
    }

    /// A command that is rejected, exit code 2, with all of these in its message.
    fn refuse(&self, arguments: &[&str], expected: &[&str]) {
        let output = self.dragnet(arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        for expected in expected {
            assert!(message.contains(expected), "{arguments:?} does not say {expected:?}\n{message}");
        }
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn keys(object: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = object.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}
