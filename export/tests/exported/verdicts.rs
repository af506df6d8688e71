//! What the operator has decided about finds.

use std::sync::Arc;

use dragnet_coordinator::mission::Record;
use dragnet_export::{Account, geojson, gpx, kml};
use dragnet_proto::message::VerdictReport;
use dragnet_proto::picture::{Picture, PictureFacts};
use dragnet_proto::verdict::{Decision, Verdicts};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;
use serde_json::{Value, json};

use crate::mission::{SECOND_NS, at, playback, scenario};

/// The mission, in which the object in `[3, 12]` is confirmed and one in `[5, 5]` was dismissed.
fn account() -> Account {
    let (mut playback, belief) = (playback(), scenario().prior().clone());
    let end = MissionTime(180 * SECOND_NS);
    let verdicts = Verdicts::default()
        .with(150 * SECOND_NS, at(3, 12), Decision::Confirmed, &belief)
        .with(160 * SECOND_NS, at(5, 5), Decision::Dismissed, &belief)
        .with(170 * SECOND_NS, at(9, 4), Decision::Undone, &belief);
    let report = VerdictReport { from: Participant::Coordinator, time_ns: end.0, verdicts };
    playback.records.push((end, Record::Verdicts(report)));
    Account::new(&playback, None, None).unwrap()
}

#[test]
fn finds_tell_what_the_operator_has_decided() {
    let exported: Value = serde_json::from_str(&geojson::text(&account())).unwrap();
    let features = exported["features"].as_array().unwrap();
    let of = |kind: &str| -> Vec<Value> {
        let of = features.iter().map(|it| &it["properties"]).filter(|it| it["kind"] == kind);
        of.map(|it| json!([it["name"], it["operator"], it["row"], it["column"]])).collect()
    };
    assert_eq!(of("found"), [json!(["Object 1", null, 9, 4]), json!(["Object 2", "confirmed", 3, 12])]);
    assert_eq!(of("dismissed"), [json!(["Dismissed 1", "dismissed", 5, 5])]);
    let dismissed = features.iter().find(|it| it["properties"]["kind"] == "dismissed").unwrap();
    assert_eq!(dismissed["properties"]["dismissed_at"], "2026-03-01T12:02:40Z");
}

#[test]
fn a_find_names_the_file_of_its_picture() {
    let mut playback = playback();
    let facts = PictureFacts {
        robot: RobotId::FIRST,
        time_ns: 5,
        cell: at(3, 12),
        camera: "<front>".to_owned(),
        label: "person".to_owned(),
        score: 0.91,
        quality: 50.0,
    };
    let picture = Picture { facts, jpeg: [0xff, 0xd8].as_slice().into() };
    playback.records.push((MissionTime(170 * SECOND_NS), Record::Picture(Arc::new(picture))));
    let mut account = Account::new(&playback, None, None).unwrap();
    account.pictures_folder = "a & b-pictures".to_owned();
    let file = "a & b-pictures/find-3-12.jpg";
    let exported: Value = serde_json::from_str(&geojson::text(&account)).unwrap();
    let found =
        exported["features"].as_array().unwrap().iter().filter(|it| it["properties"]["kind"] == "found");
    let pictures: Vec<&Value> = found.map(|it| &it["properties"]["picture"]).collect();
    assert_eq!(pictures, [&Value::Null, &json!(file)]);
    assert!(gpx::text(&account).contains("<link href=\"a &amp; b-pictures/find-3-12.jpg\"/>"));
    // HTML in XML.
    let kml = kml::text(&account);
    let shown =
        "&lt;img src=&quot;a &amp;amp; b-pictures/find-3-12.jpg&quot; width=&quot;320&quot;&gt;&lt;br&gt;";
    let source = "robot 1&amp;apos;s camera &amp;lt;front&amp;gt; (person, 0.91)";
    assert!(kml.contains(&format!("<description>{shown}{source}</description>")), "{kml}");
}

#[test]
fn a_receiver_gets_no_waypoint_of_a_dismissed_find() {
    let (kml, gpx) = (kml::text(&account()), gpx::text(&account()));
    assert_eq!(gpx.matches("<wpt").count(), 2);
    assert!(
        gpx.contains("probability 0.9876, confirmed by hand") && gpx.contains("probability 0.9600<"),
        "{gpx}"
    );
    assert!(kml.contains("<name>Dismissed</name>") && kml.contains("<name>Dismissed 1</name>"));
    assert_eq!(kml.matches("Data name=\"operator\"").count(), 2);
    let undecided = kml::text(&Account::new(&playback(), None, None).unwrap());
    assert!(!undecided.contains("Dismissed") && !undecided.contains("operator"));
}

#[test]
fn verdicts_move_the_belief_and_not_how_thoroughly_the_area_was_searched() {
    let before = Account::new(&playback(), None, None).unwrap();
    assert_eq!(account().pod, before.pod);
    assert!((account().total.pos() - before.total.pos()).abs() < 1e-12);
}
