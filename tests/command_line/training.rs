//! `dragnet train`: from demonstrations to a robot that searches.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Place, SMALL};

const TRAIN: [&str; 9] =
    ["train", "--demonstrations", "seen", "--hidden", "32", "--layers", "1", "--decay-channels", "8"];

/// With demonstrations of `path` in `seen`.
fn place(seeds: &str) -> Place {
    let place = Place::new();
    let reported = ["demonstrate", "small.toml", "--expert", "path", "--explore", "0.2", "--seeds", seeds];
    place.succeed(&[&reported as &[&str], &["--out", "seen"]].concat());
    place
}

fn train(place: &Place, out: &str, more: &[&str]) -> String {
    place.succeed(&[&TRAIN as &[&str], &["--out", out], more].concat())
}

/// The maximum ratio of full recall of a network that was trained for a minute to that of `random`.
const MOST_OF_RANDOM: f64 = 0.7;

#[test]
fn a_network_trained_for_a_minute_finds_all_on_a_much_shorter_path_than_chance() {
    let place = place("1000..1150");
    let reported = train(&place, "path.safetensors", &["--epochs", "4"]);
    assert!(
        reported.contains("best at epoch") && reported.contains("written: path.safetensors"),
        "{reported}"
    );
    let metrics = fs::read_to_string(place.path("path.safetensors.metrics.csv")).unwrap();
    assert_eq!(metrics.lines().count(), 5, "{metrics}");
    assert!(fs::read_to_string(place.path("path.safetensors.svg")).unwrap().contains("held out"));
    assert!(!place.path("path.safetensors.checkpoint").exists());

    // A robot that rests once nothing is expected sometimes leaves an object behind, with any policy.
    place.write("restless.toml", &format!("{SMALL}stop_when_expected_remaining = 0\n"));
    let compare = ["compare", "restless.toml", "--policies", "random,gnn", "--weights", "path.safetensors"];
    let report = place.json(&[&compare as &[&str], &["--seeds", "40", "--json"]].concat());
    let full_recall = |row: usize| report["rows"][row]["cells_to_full_recall"].clone();
    let cells = |recall: &Value| recall["mean"].as_f64().unwrap();
    let (random, learned) = (full_recall(0), full_recall(1));
    assert_eq!(learned["reached"], 40);
    assert!(cells(&learned) < MOST_OF_RANDOM * cells(&random), "{learned} {random}");
}

#[test]
fn a_training_that_was_killed_goes_on_to_the_same_weights() {
    let place = place("1000..1040");
    let epochs = ["--epochs", "6"];
    train(&place, "whole.safetensors", &epochs);
    let mut killed = place
        .command(&[&TRAIN as &[&str], &["--out", "killed.safetensors"], &epochs].concat())
        .spawn()
        .unwrap();
    let checkpoint = place.path("killed.safetensors.checkpoint");
    wait_for(&checkpoint);
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(!place.path("killed.safetensors").exists(), "it was killed before its end");

    place.refuse(
        &[&TRAIN as &[&str], &["--out", "killed.safetensors", "--epochs", "7"]].concat(),
        &["killed.safetensors.checkpoint", "another training"],
    );
    train(&place, "killed.safetensors", &epochs);
    let read = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(read("whole.safetensors") == read("killed.safetensors"));
    place.refuse(
        &[&TRAIN as &[&str], &["--out", "whole.safetensors"]].concat(),
        &["no weights are overwritten"],
    );
}

/// Waits for a file, with a generous limit.
pub(super) fn wait_for(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_mins(5), "{} does not appear", path.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn unusable_demonstrations_are_rejected() {
    let place = place("1000..1003");
    let train = |more: &[&str], said: &[&str]| {
        place.refuse(&[&["train", "--out", "a.safetensors"], more].concat(), said);
    };
    fs::create_dir(place.path("empty")).unwrap();
    train(&["--demonstrations", "empty"], &["empty", "no demonstrations"]);
    train(&["--demonstrations", "absent"], &["absent", "cannot read"]);
    train(&["--demonstrations", "seen", "--hidden", "33"], &["--hidden", "multiple of 32"]);
    train(&["--demonstrations", "seen", "--learning-rate", "0"], &["--learning-rate", "above 0"]);
    train(&["--demonstrations", "seen", "--choice-weight", "2"], &["--choice-weight", "0 to 1"]);
    train(&["--demonstrations", "seen", "--target-exponent", "nan"], &["--target-exponent"]);
    place.refuse(
        &["train", "--demonstrations", "seen", "--out", "absent/a.safetensors"],
        &["--out", "there is no folder absent"],
    );
    let mixed = ["demonstrate", "small.toml", "--expert", "greedy", "--seeds", "2000..2001", "--out", "seen"];
    place.succeed(&mixed);
    train(&["--demonstrations", "seen"], &["greedy", "those before it are of path"]);
}
