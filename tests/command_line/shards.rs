//! `dragnet compare --shard` and `dragnet merge`.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::Place;

/// Two policies, five seeds: ten episodes.
const COMPARISON: [&str; 8] =
    ["compare", "small.toml", "--policies", "random,path", "--seeds", "5", "--budget", "40"];

/// Parts in this folder.
fn run_shards(place: &Place, comparison: &[&str], folder: &str, count: usize) {
    for number in 1..=count {
        let shard = format!("{number}/{count}");
        place.succeed(&[comparison, &["--out", folder, "--shard", &shard]].concat());
    }
}

/// A folder with three parts of the comparison in `parts`.
fn in_three() -> Place {
    let place = Place::new();
    run_shards(&place, &COMPARISON, "parts", 3);
    place
}

/// A table without the columns of computing times, which must exist.
fn timeless(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_path(path).unwrap();
    let rows: Vec<Vec<String>> =
        reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect();
    let kept: Vec<usize> =
        (0..rows[0].len()).filter(|&column| !rows[0][column].starts_with("decision_ms")).collect();
    assert_eq!(rows[0].len() - kept.len(), 2, "{:?}", rows[0]);
    rows.iter().map(|row| kept.iter().map(|&column| row[column].clone()).collect()).collect()
}

/// Checks that two folders hold the same results, except for computing times.
pub(super) fn assert_same_results(place: &Place, a: &str, b: &str) {
    for name in ["episodes.csv", "curves.csv", "small.svg"] {
        let read = |folder: &str| fs::read_to_string(place.path(folder).join(name)).unwrap();
        assert!(read(a) == read(b), "{name}\n{}\n{}", read(a), read(b));
    }
    let summary = |folder: &str| timeless(&place.path(folder).join("summary.csv"));
    assert_eq!(summary(a), summary(b));
    assert_eq!(summary(a).len(), 3);
}

#[test]
fn parts_give_the_results_of_the_whole() {
    let place = in_three();
    place.succeed(&[&COMPARISON as &[&str], &["--out", "whole"]].concat());
    place.succeed(&["merge", "parts", "--out", "merged"]);
    assert_same_results(&place, "whole", "merged");

    let json = |arguments: &[&str]| {
        let mut report = place.json(&[arguments, &["--json"]].concat());
        for row in report["rows"].as_array_mut().unwrap() {
            assert!(row["decision_ms"]["p50"].as_f64().unwrap() > 0.0);
            row["decision_ms"] = Value::Null;
        }
        report
    };
    assert_eq!(json(&COMPARISON), json(&["merge", "parts"]));
}

#[test]
fn merged_text_differs_only_in_the_number_of_parts() {
    let place = in_three();
    // Fields of each line, without the times of decisions.
    let text = |arguments: &[&str]| {
        let mut is_timed = false;
        let mut fields_of = |line: &str| {
            is_timed = (is_timed || line.ends_with("p99 ms")) && !line.is_empty();
            let fields: Vec<String> =
                line.split("  ").map(str::trim).filter(|it| !it.is_empty()).map(str::to_owned).collect();
            fields[..fields.len() - if is_timed { 2 } else { 0 }].to_vec()
        };
        place.succeed(arguments).lines().map(&mut fields_of).collect::<Vec<_>>()
    };
    let (whole, merged) = (text(&COMPARISON), text(&["merge", "parts"]));
    assert_eq!(merged[0], ["5 seeds (0 to 4): 10 episodes in 3 parts"]);
    assert!(whole.len() > 20);
    assert_eq!(whole[1..], merged[1..]);
}

#[test]
fn parts_may_be_named_one_by_one_in_any_order() {
    let place = in_three();
    let parts = ["parts/part-3-of-3.json", "parts/part-1-of-3.json", "parts/part-2-of-3.json"];
    let text = place.succeed(&[&["merge"] as &[&str], &parts].concat());
    assert!(text.contains("10 episodes in 3 parts"), "{text}");
}

#[test]
fn shards_share_the_episodes_evenly_and_some_may_have_none() {
    let place = Place::new();
    let mut episodes = Vec::new();
    for number in 1..=11 {
        let shard = format!("{number}/11");
        let text = place.succeed(&[&COMPARISON as &[&str], &["--out", "parts", "--shard", &shard]].concat());
        assert!(text.starts_with(&format!("shard {shard}: ")), "{text}");
        let part = fs::read(place.path(&format!("parts/part-{number}-of-11.json"))).unwrap();
        let part: Value = serde_json::from_slice(&part).unwrap();
        episodes.push(part["trials"].as_array().unwrap().len());
    }
    episodes.sort_unstable();
    assert_eq!(episodes, [vec![0], vec![1; 10]].concat());
    assert!(place.succeed(&["merge", "parts"]).contains("10 episodes in 11 parts"));
}

#[test]
fn a_shard_that_is_done_is_not_run_again() {
    let place = in_three();
    let part = place.path("parts/part-2-of-3.json");
    let before = fs::read(&part).unwrap();
    let again = [&COMPARISON as &[&str], &["--out", "parts", "--shard", "2/3"]].concat();
    assert_eq!(place.succeed(&again), "shard 2/3: done already: parts/part-2-of-3.json\n");
    // Computing times would differ.
    assert!(before == fs::read(&part).unwrap());
    assert_eq!(fs::read_dir(place.path("parts")).unwrap().count(), 3, "nothing unfinished is left");
}

#[test]
fn a_part_of_another_experiment_is_never_taken_for_ones_own() {
    let place = in_three();
    let second = ["--out", "parts", "--shard", "2/3"];
    for (comparison, said) in [
        (["--policies", "random,path", "--seeds", "6", "--budget", "40"], "5 seeds (0 to 4) and not 6 seeds"),
        (
            ["--policies", "path,random", "--seeds", "5", "--budget", "40"],
            "random on small and not path on small",
        ),
        (
            ["--policies", "random", "--seeds", "5", "--budget", "40"],
            "random on small, path on small and not",
        ),
        (["--policies", "random,path", "--seeds", "5", "--budget", "41"], "random on small is not the same"),
    ] {
        let arguments = [&["compare", "small.toml"] as &[&str], &comparison, &second].concat();
        place.refuse(&arguments, &["parts/part-2-of-3.json", "another experiment", said]);
    }
    place.write("small.toml", &super::SMALL.replace("count = 4", "count = 5"));
    place.refuse(&[&COMPARISON as &[&str], &second].concat(), &["random on small is not the same"]);
    fs::copy(place.path("parts/part-1-of-3.json"), place.path("parts/part-2-of-3.json")).unwrap();
    place.write("small.toml", super::SMALL);
    place.refuse(&[&COMPARISON as &[&str], &second].concat(), &["shard 1/3 and not 2/3"]);
}

#[test]
fn shards_that_are_missing_doubled_or_of_another_number_are_named() {
    let place = in_three();
    place.refuse(&["merge", "parts/part-2-of-3.json"], &["of 3 shards", "missing: 1, 3"]);
    place.refuse(
        &["merge", "parts", "parts/part-2-of-3.json"],
        &["shard 2/3 is there twice", "parts/part-2-of-3.json"],
    );
    run_shards(&place, &COMPARISON, "parts", 1);
    place.refuse(
        &["merge", "parts"],
        &["parts/part-1-of-3.json: shard 1/3", "parts/part-1-of-1.json is one of 1"],
    );
}

#[test]
fn parts_of_two_experiments_are_not_mixed() {
    let place = in_three();
    let other = ["compare", "small.toml", "--policies", "random,path", "--seeds", "5", "--budget", "41"];
    place.succeed(&[&other as &[&str], &["--out", "other", "--shard", "3/3"]].concat());
    fs::copy(place.path("other/part-3-of-3.json"), place.path("parts/part-3-of-3.json")).unwrap();
    place.refuse(
        &["merge", "parts", "--out", "merged"],
        &["parts/part-3-of-3.json", "parts/part-1-of-3.json", "random on small is not the same"],
    );
    change(&place, "parts/part-3-of-3.json", |part| part["origin"]["program"] = json!("0.0.9 (beef)"));
    place.refuse(&["merge", "parts"], &["part-3-of-3.json", "dragnet 0.0.9 (beef) and not "]);
    assert!(!place.path("merged").exists());
}

/// Rewrites a part.
fn change(place: &Place, name: &str, change: impl FnOnce(&mut Value)) {
    let mut part: Value = serde_json::from_slice(&fs::read(place.path(name)).unwrap()).unwrap();
    change(&mut part);
    place.write(name, &part.to_string());
}

#[test]
fn an_incomplete_part_is_rejected() {
    let place = in_three();
    let part = "parts/part-1-of-3.json";
    let text = fs::read_to_string(place.path(part)).unwrap();
    place.refuse(&["merge", "small.toml"], &["small.toml", "no part of a comparison", "compare --shard"]);
    place.refuse(&["merge", "missing.json"], &["missing.json"]);
    for end in [0, 20, text.len() / 2, text.len() - 1] {
        place.write(part, &text[..end]);
        place.refuse(&["merge", "parts"], &[part, "cut off", "run its shard again"]);
    }
    let second = [&COMPARISON as &[&str], &["--out", "parts", "--shard", "1/3"]].concat();
    place.refuse(&second, &[part, "cut off"]);
    for (damage, said) in [
        (("/format", json!("other")), "no part of a comparison"),
        (("/format_version", json!(2)), "format version 2; this program reads version 4"),
        (("/trials/0/seed", json!(77)), "not those of shard 1/3"),
        (("/trials/0/curve", json!([0.0])), "not those of shard 1/3"),
        (("/trials/0", json!({})), "a damaged part"),
        (("/shard", json!("2/3")), "not those of shard 2/3"),
        (("/origin/design/seeds", json!("9..3")), "9..3"),
        (("/origin/design/settings/0/scenario", json!("../small")), "letters, digits"),
    ] {
        place.write(part, &text);
        change(&place, part, |part| *part.pointer_mut(damage.0).unwrap() = damage.1);
        place.refuse(&["merge", "parts"], &[part, said]);
    }
}

#[test]
fn a_folder_without_parts_is_rejected() {
    let place = Place::new();
    fs::create_dir(place.path("empty")).unwrap();
    place.refuse(&["merge", "empty"], &["empty: no part", "part-I-of-N"]);
    place.refuse(&["merge"], &["<PART>"]);
}
