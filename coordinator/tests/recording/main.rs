//! Recordings of a mission: their contents, their readers, and what remains after a crash.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod damage;
mod earth;
mod episode;
#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;
#[path = "../../../tests/mentions/mod.rs"]
mod mentions;
mod python;

use std::fs;
use std::path::Path;

use dragnet_coordinator::Ending;
use dragnet_coordinator::inspect::inspect;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::record::Recorder;
use tempfile::tempdir;

use crate::episode::{Episode, ORIGIN, header, seconds};

#[test]
fn the_same_mission_makes_the_same_bytes() {
    let folder = tempdir().unwrap();
    let episode = Episode::play();
    let write = |name: &str| {
        let path = folder.path().join(name);
        episode.record(&path);
        fs::read(path).unwrap()
    };
    let bytes = write("first.mcap");
    assert_eq!(bytes, write("second.mcap"));
    let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes.len();
    assert!(chunks > 10, "{chunks} chunks");
}

#[test]
fn an_inspection_lists_the_contents_of_a_recording() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let episode = Episode::play();
    episode.record(&path);
    let found = inspect(&path).unwrap();
    assert_eq!(found.ending, Ending::Complete);
    assert_eq!((found.file_bytes, found.readable_bytes), {
        let bytes = fs::metadata(&path).unwrap().len();
        (bytes, bytes)
    });
    assert_eq!(found.observations, episode.count(|record| matches!(record, Record::Observation(_))));
    assert_eq!(
        found.topics["/mission/status"].messages,
        episode.count(|record| matches!(record, Record::Status(_)))
    );
    assert_eq!(
        found.topics["/belief"].messages,
        1 + episode.count(|record| matches!(record, Record::Belief(_)))
    );
    assert_eq!(found.topics["/objects"].message, "dragnet_msgs/msg/Detection");
    assert_eq!(found.topics["/objects"].messages, 2, "one of them withdrawn");
    assert_eq!(found.robots.iter().copied().collect::<Vec<_>>(), [1, 2]);
    let declared: Vec<u32> = found.declared.iter().map(|object| object.cell).collect();
    assert_eq!(declared, [episode::OBJECT]);
    assert_eq!(found.attachments["scenario.toml"], header().scenario.len() as u64);
    assert_eq!(found.run, header().run);
    assert_eq!(found.summary["found"], "1");
    assert!((found.times.unwrap().seconds() - episode::SECONDS as f64).abs() < 1e-9);

    let began = u64::try_from(header().start_unix_ns).unwrap();
    assert_eq!(found.began_unix_ns, Some(began));
    let table = found.to_string();
    for line in [
        "mission time  0 s is Unix time 1760000000.000 s",
        "complete",
        "robots        1 2",
        "map           its south-western corner at (-20, -12.5) m, turned by 0.5 rad",
        "run           seed = 7",
        "summary       found = 1",
        "       2  /objects               dragnet_msgs/msg/Detection",
    ] {
        assert!(table.contains(line), "{line:?} in\n{table}");
    }
    let origin = found.origin.unwrap();
    assert!((origin.yaw_radians - ORIGIN.yaw_radians).abs() < 1e-12, "{origin:?}");
    let json = serde_json::to_value(&found).unwrap();
    assert_eq!(json["ending"]["kind"], "complete");
    assert_eq!(json["topics"]["/map"]["messages"], 1);
}

#[test]
fn a_recording_that_is_dropped_is_complete_without_a_summary() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    drop(Recorder::create(&path, header()).unwrap());
    let found = inspect(&path).unwrap();
    assert_eq!((found.ending, found.summary.len()), (Ending::Complete, 0));
    assert_eq!(found.topics["/map"].messages, 1);
}

/// The file on disk while the recorder still runs is what remains when it is killed.
#[test]
fn a_crash_loses_at_most_a_second() {
    let folder = tempdir().unwrap();
    let (path, crashed) = (folder.path().join("run.mcap"), folder.path().join("crashed.mcap"));
    let episode = Episode::play();
    let mut recorder = Recorder::create(&path, header()).unwrap();
    let crash = seconds(10.5);
    let before_crash = || episode.records.iter().filter(|(now, _)| *now <= crash);
    for (now, record) in before_crash() {
        recorder.record(*now, record).unwrap();
    }
    fs::copy(&path, &crashed).unwrap();
    let found = inspect(&crashed).unwrap();
    assert_eq!(found.ending, Ending::CutOff);
    assert_eq!(found.readable_bytes, found.file_bytes, "it ends after a whole chunk");
    let observed = |until| {
        let observations =
            before_crash().filter(|(now, record)| *now <= until && matches!(record, Record::Observation(_)));
        observations.count() as u64
    };
    let kept = observed(seconds(9.5))..=observed(crash);
    assert!(kept.contains(&found.observations), "{} of {kept:?}", found.observations);
    assert!(!kept.is_empty() && *kept.start() > 10, "{kept:?}");
    assert_eq!(found.run, header().run);
}

#[test]
fn a_recording_that_cannot_be_created_names_path_and_reason() {
    let folder = tempdir().unwrap();
    let check = |path: &Path, expected: &str| {
        let error = Recorder::create(path, header()).err().unwrap().to_string();
        assert!(error.starts_with(&path.display().to_string()) && error.contains(expected), "{error}");
    };
    check(&folder.path().join("missing/run.mcap"), "cannot create the recording: No such file");
    let earlier = folder.path().join("earlier.mcap");
    fs::write(&earlier, "precious").unwrap();
    check(&earlier, "exists already");
    assert_eq!(fs::read_to_string(&earlier).unwrap(), "precious");
}
