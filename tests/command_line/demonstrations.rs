//! `dragnet demonstrate`, its shards, and rejected input of `dragnet train`.

use std::collections::BTreeMap;
use std::fs;

use super::Place;

const FEW: [&str; 7] = ["demonstrate", "small.toml", "--expert", "path", "--seeds", "0..5", "--out"];

/// The trajectories of a folder, by name.
fn trajectories(place: &Place, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(place.path(folder)).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.filter(|path| path.extension().is_some_and(|extension| extension == "safetensors"));
    files
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect()
}

fn demonstrate(place: &Place, folder: &str, more: &[&str]) -> String {
    place.succeed(&[&FEW as &[&str], &[folder], more].concat())
}

#[test]
fn an_expert_is_watched_once_and_the_same_on_any_number_of_threads() {
    let place = Place::new();
    let reported = demonstrate(&place, "a", &["--threads", "1"]);
    assert!(reported.starts_with("5 trajectories, ") && reported.contains("decisions of path"), "{reported}");
    let first = trajectories(&place, "a");
    assert_eq!(first.len(), 5);
    demonstrate(&place, "b", &["--threads", "2"]);
    assert!(first == trajectories(&place, "b"));

    fs::remove_file(place.path("a/small-3.demo.safetensors")).unwrap();
    let reported = demonstrate(&place, "a", &[]);
    assert!(reported.contains("4 were there already"), "{reported}");
    assert!(first == trajectories(&place, "a"));

    demonstrate(&place, "c", &["--explore", "0.9"]);
    assert!(first != trajectories(&place, "c"), "straying changes where robots come to");
}

#[test]
fn the_expert_may_be_asked_where_a_network_leads() {
    let place = Place::new();
    let weights = concat!(env!("CARGO_MANIFEST_DIR"), "/learn/weights/gnn-tour.safetensors");
    let tour = ["demonstrate", "small.toml", "--expert", "tour", "--seeds", "2", "--out"];
    place.succeed(&[&tour as &[&str], &["a"]].concat());
    let reported = place.succeed(&[&tour as &[&str], &["b", "--follow", weights]].concat());
    assert!(reported.contains("decisions of tour"), "{reported}");
    assert!(trajectories(&place, "a") != trajectories(&place, "b"));
    place.refuse(&[&tour as &[&str], &["a", "--follow", weights]].concat(), &["made otherwise", "network"]);
}

#[test]
fn shards_give_the_same_files_as_the_whole() {
    let place = Place::new();
    demonstrate(&place, "whole", &[]);
    for shard in ["1/3", "2/3", "3/3"] {
        demonstrate(&place, &format!("part-{}", &shard[..1]), &["--shard", shard]);
    }
    place.refuse(&["merge", "part-1", "part-3", "--out", "joined"], &["of 3 shards", "missing: 2"]);
    let reported = place.succeed(&["merge", "part-1", "part-2", "part-3", "--out", "joined"]);
    assert!(
        reported.contains("3 parts complete: 5 trajectories") && reported.contains("5 copied to joined"),
        "{reported}"
    );
    assert!(trajectories(&place, "whole") == trajectories(&place, "joined"));

    fs::remove_file(place.path("part-2").join(trajectories(&place, "part-2").keys().next().unwrap()))
        .unwrap();
    place.refuse(&["merge", "part-1", "part-2", "part-3", "--out", "again"], &["part-2", "cannot read"]);
}

#[test]
fn files_made_otherwise_are_neither_kept_nor_overwritten() {
    let place = Place::new();
    demonstrate(&place, "a", &[]);
    let first = trajectories(&place, "a");
    place.refuse(
        &["demonstrate", "small.toml", "--expert", "greedy", "--seeds", "5", "--out", "a"],
        &["made otherwise", "path", "greedy", "Choose another --out"],
    );
    place.refuse(&[&FEW as &[&str], &["a", "--density", "0.1"]].concat(), &["made otherwise", "scenario"]);
    assert!(first == trajectories(&place, "a"));

    let cut = place.path("a/small-2.demo.safetensors");
    fs::write(&cut, &first["small-2.demo.safetensors"][..1000]).unwrap();
    place.refuse(&[&FEW as &[&str], &["a"]].concat(), &["small-2.demo.safetensors", "truncated"]);
}

#[test]
fn an_expert_that_cannot_be_recorded_is_rejected() {
    let place = Place::new();
    place.refuse(&["demonstrate", "--expert", "path", "--out", "a"], &["<SCENARIO>"]);
    place.refuse(&["demonstrate", "small.toml", "--out", "a"], &["--expert"]);
    place
        .refuse(&[&FEW as &[&str], &["a", "--follow", "small.toml"]].concat(), &["small.toml", "no weights"]);
    place.refuse(&[&FEW as &[&str], &["a", "--explore", "1.5"]].concat(), &["--explore", "0 to 1"]);
    place.refuse(
        &["demonstrate", "small.toml", "small.toml", "--expert", "path", "--out", "a"],
        &["small", "is taken"],
    );
    place.refuse(
        &["demonstrate", "--mixture", "--expert", "path", "--seeds", "4294967296..4294967297", "--out", "a"],
        &["--seeds", "4294967295"],
    );
    place.write("file", "");
    place.refuse(&[&FEW as &[&str], &["file/a"]].concat(), &["--out file/a"]);
}

#[cfg(not(feature = "train"))]
#[test]
fn without_libtorch_the_error_explains_how_to_get_training() {
    Place::new().refuse(&["train", "--demonstrations", "a", "--out", "b"], &["--features train"]);
}
