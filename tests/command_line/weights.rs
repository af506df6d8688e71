//! `--weights`, and scenarios that name weights.

use std::fs;

use dragnet_learn::shape::Shape;
use dragnet_learn::weights::{Recipe, Weights};
use serde_json::Value;

use super::{Place, SMALL};

/// Writes weights, which differ by the scale, to this file.
fn write_weights(place: &Place, name: &str, scale: f32) {
    let fill = |_: &str, shape: &[usize]| {
        let count = u16::try_from(shape.iter().product::<usize>()).unwrap();
        (0..count).map(|place| 0.1 * (f32::from(place) * scale).sin()).collect()
    };
    let weights = Weights::build(Shape::DEFAULT, Recipe::default(), fill).unwrap();
    fs::write(place.path(name), weights.to_bytes().unwrap()).unwrap();
}

/// `small.toml` and two weights files, one of them in a folder with a scenario that names it.
fn place() -> Place {
    let place = Place::new();
    write_weights(&place, "mine.safetensors", 0.1);
    fs::create_dir(place.path("deep")).unwrap();
    write_weights(&place, "deep/other.safetensors", 0.7);
    let policy = "count = 2\npolicy = { name = 'gnn', weights = 'other.safetensors' }";
    place.write("deep/named.toml", &SMALL.replace("count = 2", policy));
    place
}

/// A run without results that depend on the computer and on the recording's name.
fn run(place: &Place, arguments: &[&str]) -> Value {
    let mut report = place.json(&[&["run", "--json"], arguments].concat());
    for varies in ["decision_ms", "messages_over", "recording", "scenario"] {
        report[varies] = Value::Null;
    }
    report
}

#[test]
fn a_run_with_weights_follows_their_network() {
    let place = place();
    let mine = run(&place, &["small.toml", "--policy", "gnn", "--weights", "mine.safetensors"]);
    let other = run(&place, &["small.toml", "--policy", "gnn", "--weights", "deep/other.safetensors"]);
    assert_eq!((&mine["policy"], &mine["beliefs_equal"]), (&"gnn".into(), &true.into()));
    assert_ne!(mine["belief_digest"], other["belief_digest"]);
    assert_eq!(run(&place, &["deep/named.toml"]), other);
}

#[test]
fn processes_find_weights_wherever_they_are_named() {
    let place = place();
    let absolute = place.path("mine.safetensors");
    for arguments in [
        &["small.toml", "--policy", "gnn", "--weights", "mine.safetensors"] as &[&str],
        &["small.toml", "--policy", "gnn", "--weights", absolute.to_str().unwrap()],
        &["deep/named.toml"],
    ] {
        assert_eq!(run(&place, &[arguments, &["--processes"]].concat()), run(&place, arguments));
    }
}

#[test]
fn a_comparison_with_weights_gives_them_to_gnn_alone() {
    let place = place();
    let rows = |weights: &str| {
        let policies = ["--policies", "random,gnn", "--seeds", "2", "--budget", "40"];
        let report =
            place.json(&[&["compare", "small.toml", "--json", "--weights", weights], &policies[..]].concat());
        let row = |row: &Value| (row["policy"].clone(), row["curve"].clone());
        report["rows"].as_array().unwrap().iter().map(row).collect::<Vec<_>>()
    };
    let (mine, other) = (rows("mine.safetensors"), rows("deep/other.safetensors"));
    assert_eq!((&mine[0].0, &mine[1].0), (&"random".into(), &"gnn".into()));
    assert_eq!(mine[0], other[0]);
    assert_ne!(mine[1], other[1]);
}

#[test]
fn weights_without_gnn_are_rejected_with_the_allowed_policies() {
    let place = place();
    let weights = ["--weights", "mine.safetensors"];
    for policy in [&[] as &[&str], &["--policy", "path"], &["--policy", "gnn-path"]] {
        place.refuse(
            &[&["run", "small.toml"], policy, &weights].concat(),
            &["--weights mine.safetensors", "--policy gnn only"],
        );
    }
    place.refuse(
        &[&["compare", "small.toml", "--policies", "path,gnn-path"] as &[&str], &weights].concat(),
        &["--weights mine.safetensors", "--policies gnn only"],
    );
}

#[test]
fn weights_that_cannot_be_read_are_rejected_by_name() {
    let place = place();
    let bytes = fs::read(place.path("mine.safetensors")).unwrap();
    fs::write(place.path("cut.safetensors"), &bytes[..bytes.len() / 2]).unwrap();
    fs::write(place.path("deep/other.safetensors"), &bytes[..9]).unwrap();
    for (file, said) in [
        ("no.safetensors", "no.safetensors: cannot read the weights"),
        ("small.toml", "small.toml: no weights file"),
        ("cut.safetensors", "cut.safetensors: no weights file, or a truncated one"),
    ] {
        let said = [&format!("--weights {file}: "), "robots.policy.weights", said];
        let weights = ["--weights", file];
        place.refuse(&[&["run", "small.toml", "--policy", "gnn"] as &[&str], &weights].concat(), &said);
        let compare = ["compare", "small.toml", "--policies", "path,gnn"];
        place.refuse(&[&compare as &[&str], &weights].concat(), &said);
    }
    let said =
        ["deep/named.toml, line 10: robots.policy.weights: ", "deep/other.safetensors: no weights file"];
    place.refuse(&["check", "deep/named.toml"], &said);
    place.refuse(&["run", "deep/named.toml"], &said);
}
