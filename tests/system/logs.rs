//! The logs of a mission's processes.

use std::path::Path;
use std::process::Command;

use crate::field::{DRAGNET, Field, Process};

const SEARCH: &str = "name = \"field\"\n[map]\nshape = \"all_traversable\"\nrows = 10\ncolumns = 10\n\
                      [objects]\ncount = 2\n[robots]\ncount = 2\npolicy = \"path\"\n\
                      [mission]\nbudget_seconds = 3600.0\nstop_when_expected_remaining = 0.001\n";

fn read(log: &Path) -> String {
    let log = std::fs::read_to_string(log).unwrap();
    assert!(!log.contains('\x1b'), "colors are for terminals: {log}");
    log
}

/// The log lines after these words.
fn reported<'a>(log: &'a str, words: &str) -> Vec<&'a str> {
    log.lines().filter_map(|line| line.split_once(words).map(|(_, rest)| rest)).collect()
}

#[test]
fn logs_contain_decisions_finds_declarations_and_reasons_to_rest() {
    let field = Field::new(SEARCH, 2, 3);
    let log = |name: &str| field.path(&format!("{name}.log"));
    let start = |name: &str, verb: &str, settings: &Path| {
        let mut command = Command::new(DRAGNET);
        Process::start_logged(command.args([verb, "--config"]).arg(settings), &log(name))
    };
    let coordinator =
        start("coordinator", "coordinator", &field.coordinator_settings(&field.path("field.mcap")));
    let robots =
        [1, 2].map(|number| start(&format!("robot_{number}"), "agent", &field.robot_settings(number, None)));
    field.world().output();
    robots.into_iter().for_each(Process::terminate);
    coordinator.terminate();
    let declared = read(&log("coordinator"));
    // On a busy machine an observation comes later than a heartbeat: that find is "declared before", with its time.
    let declared: Vec<&str> = reported(&declared, "the coordinator declared")
        .into_iter()
        .filter_map(|line| line.split_once(": an object at ").map(|(_, place)| place))
        .collect();
    assert_eq!(declared.len(), 2, "{declared:?}");
    for number in [1, 2] {
        let log = read(&log(&format!("robot_{number}")));
        let reported = |words: &str| reported(&log, &format!("robot {number} {words}: "));
        let decided = reported("decided");
        assert!(decided.len() > 2 && decided[0].contains(" to ["), "{log}");
        assert_eq!(reported("resting").last(), Some(&"too little is left for it to find"), "{log}");
        let learned = format!("learned from robot {}", 3 - number);
        let found: Vec<&str> = [reported("found"), reported(&learned)]
            .concat()
            .into_iter()
            .map(|line| line.trim_start_matches("an object at "))
            .collect();
        for cell in &found {
            assert!(declared.iter().any(|declared| declared.starts_with(cell)), "{cell}: {declared:?}");
        }
        assert_eq!(found.len(), 2, "by itself or by its teammate: {log}");
    }
}

#[test]
fn an_error_names_no_folder_of_the_machine_that_built_the_program() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("field.toml"), SEARCH).unwrap();
    std::fs::write(folder.path().join("zenoh.json5"), "{ mode: 7, listen: ").unwrap();
    for zenoh in ["listen = [\"tcp\"]", "listen = [\"tcp/0.0.0.256:x\"]", "config = \"zenoh.json5\""] {
        let settings = folder.path().join("robot.toml");
        let common = "mission = \"field\"\nscenario = \"field.toml\"";
        let text = format!("robot = 1\n[common]\n{common}\n[common.zenoh]\n{zenoh}\n");
        std::fs::write(&settings, text).unwrap();
        let output = Command::new(DRAGNET).args(["agent", "--config"]).arg(&settings).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.len() > 20 && !said.contains(".cargo") && !said.contains(".rs:"), "{said}");
        assert!(!said.contains('\x1b'), "{said}");
    }
}
