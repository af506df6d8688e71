//! The dates of a mission whose coordinator learned only later when it had begun.

use std::fs;
use std::path::Path;

use dragnet_coordinator::Ending;
use dragnet_coordinator::inspect::inspect;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::record::{Header, Recorder};
use dragnet_coordinator::recover::recover;
use dragnet_export::{Account, geojson, gpx};
use dragnet_scenario::time::MissionTime;
use serde_json::Value;

use crate::mission::{SECOND_NS, START_UNIX_NS, playback, scenario};

/// Records the mission in a file that is still being written, by a coordinator whose process started at this Unix time and
/// counted a second before it heard a robot, at this mission time.
fn record(path: &Path, started_unix_ns: u64, heard: MissionTime) -> Recorder {
    let (scenario, playback) = (scenario(), playback());
    let header = Header {
        start_unix_ns: started_unix_ns.cast_signed(),
        terrain: playback.terrain,
        origin: playback.origin,
        prior: scenario.prior().clone(),
        scenario: scenario.source().text.clone(),
        earth: playback.earth,
        run: playback.run,
    };
    let mut recorder = Recorder::create(path, header).unwrap();
    let Some((_, Record::Status(mut early))) = playback.records.last().cloned() else { panic!("no status") };
    (early.time_ns, early.declared) = (SECOND_NS, Vec::new());
    recorder.record(MissionTime(SECOND_NS), &Record::Status(early)).unwrap();
    let begun = Record::Began { unix_ns: START_UNIX_NS.cast_signed() };
    recorder.record(heard, &begun).unwrap();
    for (time, record) in &playback.records {
        recorder.record(heard.max(*time), record).unwrap();
    }
    recorder.tick(MissionTime(190 * SECOND_NS)).unwrap();
    recorder
}

#[track_caller]
fn check(started_unix_ns: u64, heard: MissionTime) {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let recorder = record(&file("whole.mcap"), started_unix_ns, heard);
    fs::copy(file("whole.mcap"), file("cut.mcap")).unwrap();
    recorder.finish([].into()).unwrap();
    recover(&file("cut.mcap"), &file("recovered.mcap")).unwrap();
    for (name, ending) in
        [("whole.mcap", Ending::Complete), ("cut.mcap", Ending::CutOff), ("recovered.mcap", Ending::Complete)]
    {
        let read = Playback::read(&file(name)).unwrap();
        assert_eq!((&read.ending, read.start_unix_ns), (&ending, START_UNIX_NS), "{name}");
        assert_eq!(inspect(&file(name)).unwrap().began_unix_ns, Some(START_UNIX_NS), "{name}");
        let times: Vec<MissionTime> = read.records.iter().map(|(time, _)| *time).collect();
        let before = [MissionTime(SECOND_NS)];
        let written =
            before.into_iter().chain(playback().records.into_iter().map(|(time, _)| heard.max(time)));
        assert_eq!(times, written.collect::<Vec<_>>(), "{name}");

        let account = Account::new(&read, None, None).unwrap();
        let text: Value = serde_json::from_str(&geojson::text(&account)).unwrap();
        let found = text["features"].as_array().unwrap().iter().filter_map(|feature| {
            let properties = &feature["properties"];
            (properties["kind"] == "found").then(|| properties["declared_at"].as_str().unwrap().to_owned())
        });
        let found: Vec<String> = found.collect();
        assert_eq!(found, ["2026-03-01T12:00:45Z", "2026-03-01T12:02:05Z"], "{name}");
        assert!(gpx::text(&account).contains("<time>2026-03-01T12:00:45"), "{name}");
    }
}

#[test]
fn finds_are_dated_rightly_if_the_coordinator_starts_after_the_robots() {
    let heard = MissionTime(101 * SECOND_NS);
    check(START_UNIX_NS + 100 * SECOND_NS, heard);
}

/// Its clock stands still until it hears a robot.
#[test]
fn finds_are_dated_rightly_if_the_coordinator_waits_for_the_robots() {
    check(START_UNIX_NS - 600 * SECOND_NS, MissionTime(2 * SECOND_NS));
}

#[test]
fn a_recording_without_a_new_date_keeps_that_of_its_start() {
    check(START_UNIX_NS, MissionTime(SECOND_NS));
}
