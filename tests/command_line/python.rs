//! The package for Python: its own tests, by pytest, in the environment that `test.sh` makes.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use dragnet_coordinator::mission::{CoordinatorConfig, Mission};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_coordinator::record::{Header, Recorder};
use dragnet_proto::command;
use dragnet_proto::state_machine::{Event, StateMachine};
use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;

use super::interpreter::interpreter;
use super::{Place, root};

/// Runs one file of tests. Without the package the failure says how to build it.
fn check(file: &str) {
    let output = Command::new(interpreter(root()))
        .args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider"])
        .arg(root().join("python/tests").join(file))
        .current_dir(root().join("python"))
        .env("DRAGNET", env!("CARGO_BIN_EXE_dragnet"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let (reported, wrong) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let hint = "the package is built by `.venv/bin/maturin develop --manifest-path python/Cargo.toml`";
    assert!(output.status.success(), "{reported}{wrong}\n{hint}");
    assert!(reported.contains(" passed"), "{reported}");
}

#[test]
fn environments_conform_to_gymnasium_and_pettingzoo() {
    check("test_standards.py");
}

#[test]
fn what_learns_in_environments_of_gymnasium_learns_in_these() {
    check("test_libraries.py");
}

#[test]
fn observations_in_python_are_finite_features_of_cells() {
    check("test_observations.py");
}

#[test]
fn a_copy_of_an_environment_in_python_has_its_future() {
    check("test_copies.py");
}

#[test]
fn policies_written_in_python_are_compared_with_the_built_in_ones() {
    check("test_comparison.py");
}

#[test]
fn policies_written_in_python_are_measured_on_the_benchmark() {
    check("test_benchmark.py");
}

#[test]
fn an_episode_in_python_is_that_of_the_command_line() {
    check("test_equality.py");
}

#[test]
fn a_team_in_python_has_the_beliefs_of_its_network() {
    check("test_teams.py");
}

#[test]
fn bad_input_from_python_is_an_exception_with_the_reason() {
    check("test_bad_input.py");
}

#[test]
fn pictures_of_searches_and_tables_of_recordings_are_made_in_python() {
    check("test_pictures.py");
}

#[test]
fn the_documentation_is_a_site_and_its_notebook_runs() {
    check("test_site.py");
}

#[test]
fn the_examples_in_python_run() {
    check("test_examples.py");
}

/// A mission on a map whose eastern cells are not searched, until the operator adds one of them.
fn record_with_added_area(file: &Path) {
    let map = "....,,\n....,,\n";
    std::fs::write(file.with_file_name("map.txt"), map).unwrap();
    let text = "name = 'a'\nmap.file = 'map.txt'\nobjects.density = 0.2\nmission.budget_seconds = 60.0\n";
    let scenario = Scenario::from_text(&file.with_file_name("a.toml"), text.to_owned()).unwrap();
    let header = Header {
        start_unix_ns: 0,
        terrain: std::sync::Arc::new(scenario.terrain().clone()),
        origin: scenario.origin(),
        prior: scenario.prior().clone(),
        scenario: text.to_owned(),
        earth: None,
        run: BTreeMap::new(),
    };
    let recorder = Recorder::create(file, header).unwrap();
    let mut node = CoordinatorNode::new(Mission::new(CoordinatorConfig::of(&scenario)), Some(recorder));
    let added = scenario.terrain().grid().cell_numbered(4).unwrap();
    node.handle(MissionTime(1), Event::Commanded(command::Command::Search(vec![added]))).unwrap();
    node.finish(MissionTime(2), BTreeMap::new()).unwrap();
}

#[test]
fn a_recording_in_python_has_the_cells_that_the_operator_added() {
    let place = Place::new();
    let file = place.folder.path().join("added.mcap");
    record_with_added_area(&file);
    let script = "import sys, numpy, dragnet\n\
                  recording = dragnet.read_recording(sys.argv[1])\n\
                  print(recording.searched.astype(int).tolist(), numpy.isfinite(recording.log_odds).astype(int).tolist())\n";
    let output = Command::new(interpreter(root())).args(["-c", script]).arg(&file).output().unwrap();
    let reported = String::from_utf8_lossy(&output.stdout);
    let expected = "[[1, 1, 1, 1, 1, 0], [1, 1, 1, 1, 0, 0]] [[1, 1, 1, 1, 1, 0], [1, 1, 1, 1, 0, 0]]";
    assert_eq!(reported.trim(), expected, "{}", String::from_utf8_lossy(&output.stderr));
}
