//! `dragnet inspect` and `dragnet recover`.

use std::fs;

use dragnet_coordinator::playback::Playback;

use super::Place;

#[test]
fn a_recording_that_was_cut_off_is_mended() {
    let place = Place::new();
    let report = place.json(&["run", "small.toml", "--record", "whole.mcap", "--json"]);
    let text = place.succeed(&["inspect", "whole.mcap"]);
    let observations = &report["observations_merged"];
    assert!(text.contains(&format!("observations  {observations}\n")) && text.contains("complete"), "{text}");
    // Cells are written as in the output of a run and a replay.
    let reported = place.succeed(&["replay", "whole.mcap"]);
    let cells: Vec<&str> = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix("cell ")?.split(", probability").next())
        .collect();
    assert!(!cells.is_empty(), "{text}");
    for cell in cells {
        assert!(cell.starts_with('[') && reported.contains(cell), "{cell} is not in {reported}");
    }

    let bytes = fs::read(place.path("whole.mcap")).unwrap();
    fs::write(place.path("cut.mcap"), &bytes[..bytes.len() * 3 / 4]).unwrap();
    assert!(place.succeed(&["inspect", "cut.mcap"]).contains("cut off"));
    assert!(place.succeed(&["recover", "cut.mcap", "mended.mcap"]).contains("mended.mcap: recovered "));
    assert!(place.succeed(&["inspect", "mended.mcap"]).contains("complete"));
    place.refuse(&["recover", "cut.mcap", "mended.mcap"], &["mended.mcap", "exists already"]);
}

/// A team exchanges messages after its search, which are not part of it.
#[test]
fn a_search_took_as_long_in_its_recording_as_when_it_ran() {
    let place = Place::new();
    let report = place.json(&["run", "small.toml", "--record", "whole.mcap", "--json"]);
    let seconds = report["mission_time_s"].as_f64().unwrap();
    let reported = format!("small after {seconds:.1} s: ");
    for arguments in [
        &["replay", "whole.mcap"] as &[&str],
        &["export", "whole.mcap", "--origin", "47,8", "--to", "out.kml"],
    ] {
        let text = place.succeed(arguments);
        assert!(text.contains(&reported), "{reported} is not in {text}");
    }
    let records = Playback::read(&place.path("whole.mcap")).unwrap().records;
    assert!(records.is_sorted_by_key(|(time, _)| *time), "the last one is of the end");
    assert!(
        records.iter().any(|(time, _)| time.as_seconds() > seconds),
        "they talked until they knew the same"
    );
}

#[test]
fn a_file_that_is_not_a_recording_is_rejected() {
    let place = Place::new();
    place.refuse(&["inspect", "small.toml"], &["small.toml", "not a recording"]);
    place.refuse(&["inspect", "missing.mcap"], &["missing.mcap"]);
    place.refuse(&["recover", "small.toml", "out.mcap"], &["small.toml"]);
    assert!(!place.path("out.mcap").exists());
}

/// The default of ROS 2 up to Humble.
#[test]
fn a_bag_in_sqlite_is_named_with_its_conversion() {
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

/// One bit of one chunk: all other chunks are read, and the loss is reported by all commands that read recordings.
#[test]
fn a_damaged_chunk_costs_itself_alone() {
    let place = Place::new();
    place.json(&["run", "small.toml", "--record", "whole.mcap", "--json"]);
    let mut bytes = fs::read(place.path("whole.mcap")).unwrap();
    // Each chunk is compressed, and begins with these bytes.
    let chunk =
        (bytes.len() / 2..bytes.len()).find(|&byte| bytes[byte..].starts_with(&[0x28, 0xb5, 0x2f, 0xfd]));
    bytes[chunk.unwrap() + 20] ^= 1;
    fs::write(place.path("bad.mcap"), &bytes).unwrap();
    let whole = place.succeed(&["recover", "whole.mcap", "copy.mcap"]);
    let recovered = place.succeed(&["recover", "bad.mcap", "mended.mcap"]);
    let messages = |text: &str| text.split_whitespace().nth(2).unwrap().parse::<u32>().unwrap();
    let (all, kept) = (messages(&whole), messages(&recovered));
    assert!(kept < all && kept > all * 9 / 10, "{kept} of {all}: {recovered}");
    assert!(recovered.contains("it is damaged in one place: "), "{recovered}");
    assert!(recovered.contains(&format!(" with {} messages; first at byte ", all - kept)), "{recovered}");
    for arguments in [
        &["inspect", "bad.mcap"] as &[&str],
        &["replay", "bad.mcap"],
        &["export", "bad.mcap", "--origin", "47,8", "--to", "out.geojson"],
    ] {
        let output = place.dragnet(arguments);
        let reported = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert!(
            output.status.success() && reported.contains("damaged in one place: "),
            "{arguments:?} {reported}"
        );
    }
}

/// As by `cat` of two recordings into one file.
#[test]
fn data_after_a_recording_are_reported() {
    let place = Place::new();
    place.json(&["run", "small.toml", "--record", "whole.mcap", "--json"]);
    let bytes = fs::read(place.path("whole.mcap")).unwrap();
    fs::write(place.path("two.mcap"), [&*bytes, &bytes].concat()).unwrap();
    let end = bytes.len();
    for arguments in [
        &["inspect", "two.mcap"] as &[&str],
        &["replay", "two.mcap"],
        &["export", "two.mcap", "--origin", "47,8", "--to", "out.geojson"],
        &["recover", "two.mcap", "first.mcap"],
    ] {
        let output = place.dragnet(arguments);
        let reported = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{arguments:?} {reported}");
        for part in [format!("{end} bytes follow its end"), format!("tail -c +{} ", end + 1)] {
            assert!(reported.contains(&part), "{arguments:?}: {part} is not in {reported}");
        }
    }
}

/// The position of a `map_server` map is that in its recording.
#[test]
fn a_recording_has_the_frame_of_its_map() {
    let place = Place::new();
    place.write("hall.pgm", &format!("P2 8 8 255{}", " 254".repeat(64)));
    place.write(
        "hall.yaml",
        "image: hall.pgm\nmode: Trinary\nresolution: '1.0'\norigin: [-20.0, '-12', 0.5]\nnegate: no\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
    );
    let scenario = "name = 'hall'\nmap = { file = 'hall.yaml', cell_meters = 1.0 }\nobjects.count = 1\n\
                    mission.budget_meters = 20.0\n";
    place.write("hall.toml", scenario);
    let corner = "south-western corner";
    let text = place.succeed(&["check", "hall.toml"]);
    assert!(text.contains(&format!("{corner} in the frame map: (-20, -12) m, turned by 0.5 rad")), "{text}");
    place.json(&["run", "hall.toml", "--record", "hall.mcap", "--json"]);
    let text = place.succeed(&["inspect", "hall.mcap"]);
    assert!(
        text.contains(&format!("map           its {corner} at (-20, -12) m, turned by 0.5 rad")),
        "{text}"
    );
}
