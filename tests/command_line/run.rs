//! `dragnet run`.

use std::fs;

use serde_json::Value;

use super::{Place, keys};

#[test]
fn one_json_object_holds_all_measures() {
    let place = Place::new();
    let report = place.json(&["run", "small.toml", "--seed", "3", "--json"]);
    let mut expected = vec![
        "scenario",
        "seed",
        "policy",
        "robots",
        "objects",
        "objects_out_of_reach",
        "found",
        "false_positives",
        "declared",
        "recall",
        "precision",
        "confirmed",
        "dismissed",
        "no_go_cells",
        "skipped_cells",
        "f1",
        "auc_f1",
        "path_cells",
        "robots_at_base",
        "mission_time_s",
        "expected_remaining",
        "cells_out_of_reach",
        "expected_out_of_reach",
        "last_find_s",
        "tail_s",
        "decisions",
        "decision_ms",
        "observations_sent",
        "observations_merged",
        "messages_over",
        "messages_sent",
        "traffic",
        "messages_unsent",
        "beliefs_equal",
        "has_all_readings",
        "belief_digest",
        "recording",
    ];
    expected.sort_unstable();
    assert_eq!(keys(&report), expected);
    assert_eq!(keys(&report["decision_ms"]), ["max", "p50", "p99"]);
    assert_eq!(
        (&report["scenario"], &report["seed"], &report["robots"]),
        (&"small".into(), &3.into(), &2.into())
    );
    assert_eq!(report["path_cells"].as_array().unwrap().len(), 2);
    assert_eq!(report["observations_sent"], report["observations_merged"]);
    assert_eq!(report["messages_over"], "memory");
    assert_eq!(report["beliefs_equal"], true);
    assert_eq!(report["has_all_readings"], true);
    assert_eq!(report["recording"], "small-3.mcap");
    let digest = report["belief_digest"].as_str().unwrap();
    assert!(digest.len() == 32 && digest.bytes().all(|byte| byte.is_ascii_hexdigit()), "{digest}");
    let share = |key: &str| report[key].as_f64().unwrap();
    assert!((share("recall") - share("found") / share("objects")).abs() < 1e-12);
    assert!(share("auc_f1") > 0.0 && share("auc_f1") <= 1.0);
    assert!((share("last_find_s") + share("tail_s") - share("mission_time_s")).abs() < 1e-6);
}

/// Objects around a lake and in it; its middle is farther from every shore than the sensor radius.
fn lake(objects: &str) -> Place {
    let place = Place::new();
    place.write(
        "lake.txt",
        &["........", "..~~~~~~", "..~~~~~~", "..~~~~~~", "..~~~~~~", "........"].join("\n"),
    );
    place.write(
        "lake.toml",
        &format!(
            "name = 'lake'\nmap.file = 'lake.txt'\nsensor.radius = 1\nobjects.cells = {objects}\n\
             mission.budget_seconds = 100000.0\n"
        ),
    );
    place
}

#[test]
fn cells_out_of_reach_are_shown_and_do_not_prolong_the_search() {
    let place = lake("[[0, 0], [2, 5]]");
    let report = place.json(&["run", "lake.toml", "--json"]);
    assert_eq!((&report["objects"], &report["objects_out_of_reach"]), (&2.into(), &1.into()));
    assert_eq!((&report["found"], &report["recall"]), (&1.into(), &1.0.into()));
    assert!(report["mission_time_s"].as_f64().unwrap() < 5000.0, "{report}");
    assert_eq!(report["cells_out_of_reach"], 10);
    let text = place.succeed(&["run", "lake.toml"]);
    for said in [
        "the search of what is in reach is complete at 0.05, that of the area is NOT: 0.42 in 10 cells out of reach",
        "~ out of reach",
        "out of reach: no robot can see them",
        "[2, 5]",
        "rests: too little is left for it to find",
    ] {
        assert!(text.contains(said), "{said:?} is missing\n{text}");
    }
}

#[test]
fn without_an_object_in_reach_there_is_no_quality() {
    let place = lake("[[2, 5]]");
    let report = place.json(&["run", "lake.toml", "--json"]);
    for key in ["recall", "precision", "f1", "auc_f1"] {
        assert_eq!(report[key], Value::Null, "{key}");
    }
    let text = place.succeed(&["run", "lake.toml"]);
    assert!(text.contains("quality       undefined: no object is in reach of a robot\n"), "{text}");
    let compare = ["compare", "lake.toml", "--policies", "greedy", "--seeds", "2"];
    let text = place.succeed(&compare);
    assert!(text.contains("\nNo object is in reach of a robot with 2 of 2 seeds."), "{text}");
    let report = place.json(&[&compare[..], &["--json"]].concat());
    assert_eq!(report["rows"][0]["seeds_without_object"], 2);
}

#[test]
fn the_same_seed_is_the_same_run_and_the_same_recording() {
    let run = |seed: &str| {
        let place = Place::new();
        let mut report = place.json(&["run", "small.toml", "--seed", seed, "--record", "a.mcap", "--json"]);
        report["decision_ms"] = Value::Null;
        (report, fs::read(place.path("a.mcap")).unwrap())
    };
    let (first, again, other) = (run("5"), run("5"), run("6"));
    assert_eq!(first.0, again.0);
    assert!(first.1 == again.1, "the recordings differ");
    assert_ne!(first.0["belief_digest"], other.0["belief_digest"]);
}

#[test]
fn the_medium_of_messages_is_reported_and_changes_nothing() {
    let place = Place::new();
    let run = |over: &str, name: &str| {
        let output = place.succeed(&["run", "small.toml", "--over", over, "--record", name]);
        (output, fs::read(place.path(name)).unwrap())
    };
    let ((zenoh, over_zenoh), (memory, in_memory)) = (run("zenoh", "a.mcap"), run("memory", "b.mcap"));
    assert!(zenoh.contains("over Zenoh") && memory.contains("in memory"), "{zenoh}{memory}");
    assert!(over_zenoh == in_memory, "the recordings differ");
    let usual = |asked: &[&str]| place.json(&[&["run", "small.toml", "--json"], asked].concat());
    assert_eq!(usual(&[])["messages_over"], "memory");
    assert_eq!(usual(&["--real-time-factor", "10000"])["messages_over"], "zenoh");
    place
        .refuse(&["run", "small.toml", "--over", "memory", "--processes"], &["--over memory", "--processes"]);
}

#[test]
fn the_output_contains_decisions_finds_the_map_and_the_measures() {
    let place = Place::new();
    let text = place.succeed(&["run", "small.toml"]);
    for said in [
        "s  robot 1  goes to [",
        "finds an object at [",
        "rests: ",
        "cleared",
        "found 4 of 4 objects",
        "recall 1.000",
    ] {
        assert!(text.contains(said), "{said:?} is missing\n{text}");
    }
    assert!(text.contains("small-0.mcap: open it in Foxglove"), "{text}");
    assert!(!text.contains('\u{1b}'), "colors or a progress bar in a file\n{text}");
    assert!(place.path("small-0.mcap").is_file());
}

#[test]
fn no_line_of_the_map_is_wider_than_a_usual_terminal() {
    let place = Place::new();
    place.write("wide.toml", &super::SMALL.replace("columns = 12", "columns = 300"));
    let text = place.succeed(&["run", "wide.toml", "--robots", "1"]);
    let map = text.split("\n\n").nth(1).unwrap();
    assert!(map.lines().all(|line| line.len() <= 80), "{map}");
}

#[test]
fn no_recording_is_ever_overwritten() {
    let place = Place::new();
    let recorded = || place.json(&["run", "small.toml", "--json"])["recording"].as_str().unwrap().to_owned();
    let (first, second) = (recorded(), recorded());
    assert_ne!(first, second);
    assert!(place.path(&first).is_file() && place.path(&second).is_file());
    place.write("kept.mcap", "precious");
    place.refuse(
        &["run", "small.toml", "--record", "kept.mcap"],
        &["--record", "kept.mcap", "exists already"],
    );
    assert_eq!(fs::read_to_string(place.path("kept.mcap")).unwrap(), "precious");
}

#[test]
fn options_change_policy_and_team() {
    let place = Place::new();
    let report = place.json(&["run", "small.toml", "--policy", "greedy", "--robots", "3", "--json"]);
    assert_eq!((&report["policy"], &report["robots"]), (&"greedy".into(), &3.into()));
}
