//! `dragnet reinforce`: from a network and its own searches to another network.

use std::fs;
use std::process::Stdio;

use super::Place;
use super::training::wait_for;

/// Two rounds of three searches at most, and a few that measure.
const REINFORCE: [&str; 9] = [
    "reinforce",
    "--seeds",
    "3000000..3000006",
    "--validation-seeds",
    "6000..6003",
    "--rounds",
    "2",
    "--batch",
    "64",
];

fn reinforce(place: &Place, out: &str, more: &[&str]) -> String {
    place.succeed(&[&REINFORCE as &[&str], &["--out", out], more].concat())
}

#[test]
fn a_reinforcement_that_was_stopped_goes_on_to_the_same_weights() {
    let place = Place::new();
    let every = ["--validation-every", "1"];
    let reported = reinforce(&place, "whole.safetensors", &every);
    assert!(reported.contains("round 2") && reported.contains("written: whole.safetensors"), "{reported}");
    let metrics = fs::read_to_string(place.path("whole.safetensors.metrics.csv")).unwrap();
    assert_eq!(metrics.lines().count(), 4, "{metrics}");
    assert!(fs::read_to_string(place.path("whole.safetensors.svg")).unwrap().contains("held out"));
    assert!(!place.path("whole.safetensors.checkpoint").exists());

    let mut killed = place
        .command(&[&REINFORCE as &[&str], &["--out", "killed.safetensors"], &every].concat())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for(&place.path("killed.safetensors.checkpoint"));
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(!place.path("killed.safetensors").exists(), "it was killed before its end");
    place.refuse(
        &[&REINFORCE as &[&str], &["--out", "killed.safetensors", "--trace", "0.3"]].concat(),
        &["killed.safetensors.checkpoint", "another training"],
    );
    reinforce(&place, "killed.safetensors", &every);
    let read = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(read("whole.safetensors") == read("killed.safetensors"));

    let compare =
        ["compare", "small.toml", "--policies", "gnn", "--weights", "whole.safetensors", "--seeds", "2"];
    place.succeed(&compare);
}

#[test]
fn impossible_reinforcements_are_rejected() {
    let place = Place::new();
    let refuse = |more: &[&str], said: &[&str]| {
        place.refuse(&[&["reinforce", "--out", "a.safetensors"], more].concat(), said);
    };
    refuse(&["--temperature", "0"], &["--temperature", "above 0"]);
    refuse(&["--trace", "1.5"], &["--trace", "0 to 1"]);
    refuse(&["--learning-rate", "nan"], &["--learning-rate", "above 0"]);
    refuse(&["--seeds", "5", "--rounds", "6"], &["--seeds", "--rounds"]);
    refuse(&["--start", "absent.safetensors"], &["absent.safetensors"]);
    refuse(&["--validation-seeds", "4294967296..4294967297"], &["--validation-seeds", "4294967296"]);
    refuse(&["--seeds", "4294967000..4294967297"], &["--seeds", "4294967296"]);
    place.refuse(&["reinforce", "--out", "absent/a.safetensors"], &["there is no folder absent"]);
}
