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

/// As ROS 2 records it unless it is told otherwise, up to Humble.
#[test]
fn a_bag_in_sqlite_is_called_that_and_how_to_convert_it_is_said() {
    let place = Place::new();
    fs::create_dir(place.path("drive")).unwrap();
    fs::write(place.path("drive/drive_0.db3"), b"SQLite format 3\0and more").unwrap();
    let said = [
        "not a recording: a bag in SQLite (.db3)",
        "`ros2 bag convert -i drive -o mcap.yaml`",
        "storage_id: mcap",
    ];
    for verb in ["inspect", "replay"] {
        place.refuse(&[verb, "drive/drive_0.db3"], &said);
    }
    place.refuse(&["recover", "drive/drive_0.db3", "out.mcap"], &said);
    assert!(!place.path("out.mcap").exists());
    place.write(
        "robot.toml",
        "robot = 1\n[common]\nmission = \"a\"\nscenario = \"small.toml\"\n[vehicle]\n[ros]\ntransport = \"bridge\"\n",
    );
    for bag in ["drive", "drive/drive_0.db3"] {
        place.refuse(&["agent", "--config", "robot.toml", "--dry-run", bag], &said);
    }
}
