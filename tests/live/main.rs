//! The live page: the real program, in a real browser.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by a panic; Clippy knows only functions marked as tests"
)]

mod browser;
mod foxglove;
mod http;
#[path = "../python/interpreter.rs"]
mod interpreter;
mod pictured;
mod plan;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};

use tempfile::TempDir;

/// A hall with a pillar; its eastern strip is traversable and not searched.
const MAP: &str = "\
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
........####.........,,,,,
........####.........,,,,,
........####.........,,,,,
........####.........,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
.....................,,,,,
";

/// A search that lasts longer than any test.
const LONG: &str = "\
name = 'hall'
map.file = 'hall.txt'
sensor.radius = 3
objects.count = 5
robots.count = 3
[mission]
budget_seconds = 36000.0
stop_when_expected_remaining = 0.0
heartbeat_seconds = 2.0
liveness_timeout_seconds = 60.0
";

/// A search on a map of the earth, with areas; the file of the map follows.
const EARTH: &str = "\
name = 'earth'
map.cell_meters = 30.0
objects.count = 1
robots.count = 2
mission.budget_seconds = 36000.0
mission.stop_when_expected_remaining = 0.0
";

/// Many robots that start in one place of a large map.
const CROWD: &str = "\
name = 'crowd'
map = { shape = 'all_traversable', rows = 300, columns = 300 }
objects.count = 20
robots = { count = 50, policy = 'greedy', start = 'random' }
mission.budget_seconds = 36000.0
";

/// The program, serving a page or Foxglove from its own folder. Both are removed when this is dropped.
struct Served {
    folder: TempDir,
    program: Child,
    /// Kept open, so that the program can write to it.
    said: BufReader<ChildStderr>,
    address: String,
}

impl Served {
    /// A search that runs.
    fn run() -> Self {
        Self::start(&["run", "hall.toml", "--live", "--record", "hall.mcap"])
    }

    fn start(arguments: &[&str]) -> Self {
        let folder = folder();
        Self::start_in(folder, arguments)
    }

    fn start_in(folder: TempDir, arguments: &[&str]) -> Self {
        Self::start_until(folder, arguments, " page: ")
    }

    /// Waits for the line with the address, which follows a mark.
    fn start_until(folder: TempDir, arguments: &[&str], mark: &str) -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_dragnet"))
            .args(arguments)
            .current_dir(folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(program.stderr.take().unwrap());
        let mut lines = String::new();
        while !lines.contains(mark) {
            assert!(said.read_line(&mut lines).unwrap() > 0, "{lines}");
        }
        let address = lines.rsplit(mark).next().unwrap().trim().to_owned();
        Self { folder, program, said, address }
    }

    /// `127.0.0.1:12345`
    fn host(&self) -> &str {
        self.address.trim_start_matches("http://").split('/').next().unwrap()
    }

    fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn token(&self) -> &str {
        self.address.split_once("#token=").unwrap().1
    }

    /// Its output on stderr until it was ended.
    fn complaints(mut self) -> String {
        let _ = self.program.kill();
        let mut text = String::new();
        let _ = self.said.read_to_string(&mut text);
        text
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("hall.txt"), MAP).unwrap();
    std::fs::write(folder.path().join("hall.toml"), LONG).unwrap();
    std::fs::write(folder.path().join("full.toml"), LONG.replace("count = 5", "count = 60")).unwrap();
    std::fs::write(folder.path().join("short.toml"), LONG.replace("36000.0", "900.0")).unwrap();
    let map = root().join("scenarios/maps/missing_person.kml");
    std::fs::write(folder.path().join("earth.toml"), format!("{EARTH}map.file = '{}'\n", map.display()))
        .unwrap();
    std::fs::write(folder.path().join("crowd.toml"), CROWD).unwrap();
    folder
}

/// The repository.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}
