//! `dragnet benchmark`.

use std::fs;

use serde_json::Value;

use super::{Place, root, stderr};

/// A result of a fast policy on the smallest track.
fn written(place: &Place, policies: &str) -> Value {
    let text = place.succeed(&[
        "benchmark",
        "smoke",
        "--policies",
        policies,
        "--out",
        "result.json",
        "--threads",
        "2",
    ]);
    assert!(text.contains("whole track") && text.contains("written: result.json, digest "), "{text}");
    serde_json::from_str(&fs::read_to_string(place.path("result.json")).unwrap()).unwrap()
}

#[test]
fn the_tracks_are_listed_and_documented() {
    let list = Place::new().succeed(&["benchmark"]);
    let guide = fs::read_to_string(root().join("docs/benchmark.md")).unwrap();
    assert!(list.lines().count() > 4, "{list}");
    for line in list.lines().skip(1) {
        let name = line.split_whitespace().next().unwrap();
        assert!(guide.contains(&format!("| `{name}` |")), "docs/benchmark.md: {name}");
    }
}

#[test]
fn a_result_is_verified_and_an_edited_one_is_not() {
    let place = Place::new();
    let result = written(&place, "greedy,gnn-path");
    let policies = result["policies"].as_array().unwrap();
    assert_eq!(policies.len(), 2);
    assert_eq!(policies[0]["episodes"].as_array().unwrap().len(), 12);
    assert_eq!(policies[0]["decider"]["policy"]["weights"], Value::Null);
    assert_eq!(policies[1]["decider"]["policy"]["weights"].as_str().unwrap().len(), 32);
    let verified = place.succeed(&["benchmark", "--verify", "result.json"]);
    assert!(verified.starts_with("result.json: 0 of 24 episodes differ, run in "), "{verified}");
    let sampled = place.succeed(&["benchmark", "--verify", "result.json", "--sample", "3", "--seed", "9"]);
    assert!(sampled.starts_with("result.json: 0 of 3 episodes differ"), "{sampled}");

    let text = fs::read_to_string(place.path("result.json")).unwrap();
    place.write("edited.json", &text.replacen("\"recall\":1.0", "\"recall\":0.75", 1));
    place.refuse(&["benchmark", "--verify", "edited.json"], &["edited.json: an edited or damaged result"]);
    place.write("cut.json", &text[..1000]);
    place.refuse(&["benchmark", "--verify", "cut.json"], &["cut.json: a result that was cut off"]);
    place.refuse(&["benchmark", "--verify", "small.toml"], &["small.toml: no result of a benchmark"]);
    place.refuse(&["benchmark", "--verify", "none.json"], &["none.json"]);
    place.refuse(
        &["benchmark", "--verify", "result.json", "--sample", "25"],
        &["a sample of 25; allowed is 1 to 24"],
    );
    place.refuse(
        &["benchmark", "smoke", "--policies", "path", "--out", "result.json"],
        &["--out result.json: exists already"],
    );
}

/// Its digest fits: everybody can compute one.
#[test]
fn a_result_of_another_policy_fails_with_the_episodes_that_differ() {
    let place = Place::new();
    written(&place, "greedy");
    let text = fs::read_to_string(place.path("result.json")).unwrap();
    let forged = text.replacen("{\"policy\":\"greedy\"", "{\"policy\":\"random\"", 1);
    let start = forged.rfind("\"digest\":\"").unwrap() + "\"digest\":\"".len();
    let content = format!("{}\"}}", &forged[..start]);
    let digest = format!("{:032x}", xxhash_rust::xxh3::xxh3_128(content.as_bytes()));
    place.write("forged.json", &format!("{}{digest}\"}}", &forged[..start]));
    let output = place.dragnet(&["benchmark", "--verify", "forged.json"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let listed = String::from_utf8(output.stdout.clone()).unwrap();
    let differing = listed.lines().filter(|line| line.starts_with("greedy on ")).count();
    assert!(differing > 6, "{listed}");
    assert!(stderr(&output).contains(&format!("forged.json: {differing} of 12 episodes differ")), "{listed}");
}

#[test]
fn requests_that_make_no_sense_are_refused() {
    let place = Place::new();
    place.refuse(
        &["benchmark", "double", "--policies", "path"],
        &["track \"double\": no such track; allowed are smoke, single, generated, team-3, team-8"],
    );
    place.refuse(&["benchmark", "single"], &["--policies"]);
    place.refuse(&["benchmark", "--policies", "path"], &["TRACK"]);
    place.refuse(&["benchmark", "single", "--policies", "pat"], &["pat"]);
    place.refuse(&["benchmark", "smoke", "--policies", "path(evaluations=3)"], &["evaluations"]);
    place.refuse(&["benchmark", "smoke", "--policies", "path", "--weights", "a"], &["--weights a"]);
    place.refuse(
        &["benchmark", "smoke", "--policies", "gnn(weights=\"a.safetensors\")"],
        &["allowed is the policy gnn with --weights"],
    );
}
