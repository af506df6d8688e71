//! `dragnet inspect` and `dragnet recover`.

use std::fs;

use super::Place;

#[test]
fn a_recording_that_was_cut_off_is_mended() {
    let place = Place::new();
    let report = place.json(&["run", "small.toml", "--record", "whole.mcap", "--json"]);
    let text = place.succeed(&["inspect", "whole.mcap"]);
    let observations = &report["observations_merged"];
    assert!(text.contains(&format!("observations  {observations}\n")) && text.contains("complete"), "{text}");

    let bytes = fs::read(place.path("whole.mcap")).unwrap();
    fs::write(place.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    assert!(place.succeed(&["inspect", "cut.mcap"]).contains("cut off"));
    assert!(place.succeed(&["recover", "cut.mcap", "mended.mcap"]).contains("mended.mcap: recovered "));
    assert!(place.succeed(&["inspect", "mended.mcap"]).contains("complete"));
    place.refuse(&["recover", "cut.mcap", "mended.mcap"], &["mended.mcap", "exists already"]);
}

#[test]
fn what_is_no_recording_is_refused() {
    let place = Place::new();
    place.refuse(&["inspect", "small.toml"], &["small.toml", "not a recording"]);
    place.refuse(&["inspect", "missing.mcap"], &["missing.mcap"]);
    place.refuse(&["recover", "small.toml", "out.mcap"], &["small.toml"]);
    assert!(!place.path("out.mcap").exists());
}
