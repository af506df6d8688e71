//! Clues, and what others have searched.

use dragnet_coordinator::mission::Record;
use dragnet_export::{Account, geojson, gpx, kml};
use dragnet_proto::marks::Marks;
use dragnet_proto::message::MarkReport;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::mark::{Clue, Mark, Searched};
use serde_json::{Value, json};

use crate::mission::{SECOND_NS, at, playback};

/// The mission with a clue, two cells that others have searched, and a clue that was withdrawn.
fn account() -> Account {
    let mut playback = playback();
    let end = MissionTime(180 * SECOND_NS);
    let clue = |cell| Mark::Clue(Clue { cell, ratio_thousandths: 20_000, radius_hundredths: 250 });
    let mut marks = Marks::default();
    marks.make(50 * SECOND_NS, clue(at(1, 1)), "withdrawn".to_owned());
    marks.make(60 * SECOND_NS, clue(at(3, 12)), "a glove, kind: search & <wet>".to_owned());
    let cells = [at(6, 6), at(6, 7)].into();
    marks.make(90 * SECOND_NS, Mark::Searched(Searched { cells, pod_thousandths: 600 }), "team 2".to_owned());
    assert!(marks.withdraw(110 * SECOND_NS, 50 * SECOND_NS));
    let report = MarkReport { from: Participant::Coordinator, time_ns: end.0, marks };
    playback.records.push((end, Record::Marks(report)));
    Account::new(&playback, None, None).unwrap()
}

#[test]
fn marks_that_count_are_exported_with_notes_and_times() {
    let account = account();
    let exported: Value = serde_json::from_str(&geojson::text(&account)).unwrap();
    let of = |kind: &str| -> Vec<Value> {
        let features = exported["features"].as_array().unwrap().iter();
        features.filter(|it| it["properties"]["kind"] == kind).cloned().collect()
    };
    let [clue] = &of("clue")[..] else { panic!("{exported}") };
    let facts = |of: &Value, names: &[&str]| {
        names.iter().map(|name| of["properties"][name].clone()).collect::<Value>()
    };
    assert_eq!(
        facts(clue, &["name", "note", "ratio", "radius_meters", "marked_at", "row"]),
        json!([
            "Clue 2",
            "a glove, kind: search & <wet>",
            20.0,
            2.5 * account.terrain.cell_meters(),
            "2026-03-01T12:01:00Z",
            3
        ])
    );
    assert_eq!(clue["geometry"]["type"], "Point");
    let [search] = &of("searched")[..] else { panic!("{exported}") };
    assert_eq!(facts(search, &["name", "note", "pod", "cells"]), json!(["Searched 1", "team 2", 0.6, 2]));
    assert_eq!(search["geometry"]["type"], "MultiPolygon");

    let (kml, gpx) = (kml::text(&account), gpx::text(&account));
    assert!(kml.contains("<name>Marks</name>") && kml.contains("a glove, kind: search &amp; &lt;wet&gt;"));
    assert!(kml.contains("<name>Searched 1</name>") && !kml.contains("Clue 1") && !kml.contains("withdrawn"));
    assert!(gpx.matches("<wpt").count() == 3 && gpx.contains("<name>Clue 2</name>"), "{gpx}");
}

#[test]
fn what_others_have_searched_counts_as_searched() {
    let (with, without) = (account(), Account::new(&playback(), None, None).unwrap());
    let grid = with.terrain.grid();
    for cell in grid.cells() {
        let by_others = if [at(6, 6), at(6, 7)].contains(&cell) { 0.6 } else { 0.0 };
        let expected = 1.0 - (1.0 - without.pod[cell.index()]) * (1.0 - by_others);
        assert!((with.pod[cell.index()] - expected).abs() < 1e-12, "{cell:?}");
    }
    assert!(with.total.pod > without.total.pod);
}

#[test]
fn the_next_search_reads_the_areas_of_an_export_with_marks() {
    let account = account();
    for (name, text) in [("next.geojson", geojson::text(&account)), ("next.kml", kml::text(&account))] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), text).unwrap();
        let next =
            format!("name = 'next'\nmap.file = '{name}'\nobjects.count = 1\nmission.budget_seconds = 60.0\n");
        let next = Scenario::from_text(&folder.path().join("next.toml"), next).unwrap();
        let before = Account::new(&playback(), None, None).unwrap();
        assert_eq!(next.earth().unwrap().areas.len(), before.areas.len(), "{name}");
    }
}
