//! A mission in a world of others: two robots, one that follows paths and one that drives to goals by itself, search a yard in
//! the simulator ir-sim (`tests/python/ir_sim_world.py`), by the settings of `deploy/examples/yard`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use dragnet_runtime::session::free_endpoints;
use serde_json::Value;

use crate::field::{DRAGNET, Process};
use crate::interpreter::interpreter;
use crate::skip;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// The ports of the settings: the coordinator's, the robots', and those of the robots' own networks.
const PORTS: [u16; 5] = [7140, 7141, 7142, 7447, 7448];
/// Four times as long as it takes.
const PATIENCE: Duration = Duration::from_mins(4);

/// The settings and the map, with free ports.
fn yard() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let free = free_endpoints(PORTS.len()).unwrap();
    for file in std::fs::read_dir(Path::new(ROOT).join("deploy/examples/yard")).unwrap() {
        let file = file.unwrap().path();
        let copy = folder.path().join(file.file_name().unwrap());
        if file.extension().is_some_and(|extension| extension == "toml") {
            let text = std::fs::read_to_string(file).unwrap();
            let with_free = |text: String, (port, free): (u16, &String)| {
                text.replace(&format!("tcp/127.0.0.1:{port}"), free)
            };
            std::fs::write(copy, PORTS.into_iter().zip(&free).fold(text, with_free)).unwrap();
        } else {
            std::fs::copy(file, copy).unwrap();
        }
    }
    folder
}

fn is_installed(python: &Path) -> bool {
    let found = Command::new(python)
        .args(["-c", "import importlib.util as u; exit(u.find_spec('irsim') is None)"])
        .status();
    found.unwrap().success()
}

/// The cells of all finds that the coordinator has ever declared.
fn declared(log: &str) -> BTreeSet<String> {
    let cell = |line: &str| {
        let (_, find) = line.split_once("the coordinator declared")?;
        // Late observations date it: `declared before, at 31.0 s: an object at [3, 5]`.
        let (_, rest) = find.split_once("an object at ")?;
        Some(rest.split_inclusive(']').next()?.to_owned())
    };
    log.lines().filter_map(cell).collect()
}

#[test]
fn two_robots_find_everything_in_a_world_of_others() {
    let python = interpreter(Path::new(ROOT));
    if !is_installed(&python) {
        return skip("this Python has no ir-sim: see tests/python/requirements.txt");
    }
    let folder = yard();
    let file = |name: &str| folder.path().join(name);
    let log = |name: &str| -> PathBuf { file(&format!("{name}.log")) };
    let said = |name: &str| std::fs::read_to_string(log(name)).unwrap_or_default();
    let world = Process::start_logged(
        Command::new(python)
            .arg(Path::new(ROOT).join("tests/python/ir_sim_world.py"))
            .arg(file("world.toml")),
        &log("world"),
    );
    let start = |name: &str, command: &str| {
        let mut dragnet = Command::new(DRAGNET);
        // The recording is relative to it.
        let dragnet = dragnet.current_dir(folder.path());
        Process::start_logged(
            dragnet.args([command, "--config"]).arg(file(&format!("{name}.toml"))),
            &log(name),
        )
    };
    let processes =
        [start("coordinator", "coordinator"), start("robot_1", "agent"), start("robot_2", "agent")];
    let begin = Instant::now();
    while !said("coordinator").contains("done: all robots that are here (2) rest") {
        let logs = ["world", "coordinator", "robot_1", "robot_2"].map(said).join("\n");
        assert!(begin.elapsed() < PATIENCE, "the search does not end:\n{logs}");
        std::thread::sleep(Duration::from_millis(200));
    }
    assert!(Command::new("kill").arg(world.id().to_string()).status().unwrap().success());
    // It fails after a collision.
    let told = world.output();
    let ready: Value = serde_json::from_str(told.lines().next().unwrap()).unwrap();
    let cells = ready["cells"].as_array().unwrap().iter();
    let true_cells: BTreeSet<String> = cells.map(|cell| format!("[{}, {}]", cell[0], cell[1])).collect();
    assert_eq!(declared(&said("coordinator")), true_cells);
    for robot in ["robot_1", "robot_2"] {
        assert!(said(robot).contains(" resting: "), "{}", said(robot));
    }
    processes.into_iter().for_each(Process::terminate);
}
