//! Where the operator let no robot go.

use dragnet_coordinator::mission::Record;
use dragnet_export::{Account, geojson, kml, plan};
use dragnet_proto::message::ZoneReport;
use dragnet_proto::newest::Numbered;
use dragnet_proto::zones::{Zone, Zones};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use serde_json::Value;

use crate::mission::{SECOND_NS, at, playback};

/// The mission, in which four cells were closed and one of them was opened again; another is skipped.
fn account() -> Account {
    let mut playback = playback();
    let end = MissionTime(180 * SECOND_NS);
    let zone = |cell, value| (cell, Numbered { number: 5, value });
    let zones: Zones = [
        zone(at(3, 12), Zone::NoGo),
        zone(at(3, 13), Zone::NoGo),
        zone(at(4, 12), Zone::NoGo),
        zone(at(4, 13), Zone::Open),
        zone(at(6, 6), Zone::Skip),
    ]
    .into_iter()
    .collect();
    let report = ZoneReport { from: Participant::Coordinator, time_ns: end.0, zones };
    playback.records.push((end, Record::Zones(report)));
    Account::new(&playback, None, None).unwrap()
}

#[test]
fn a_no_go_zone_is_an_area_that_the_next_search_reads() {
    let account = account();
    let text = geojson::text(&account);
    let exported: Value = serde_json::from_str(&text).unwrap();
    let areas = exported["features"].as_array().unwrap().iter().map(|it| &it["properties"]);
    assert_eq!(areas.filter(|it| it["name"] == "No-go by order" && it["kind"] == "no_go").count(), 1);
    assert!(kml::text(&account).contains("<name>No-go by order</name>"));
    let fences =
        |account: &Account| plan::texts(account).unwrap()[0].1.matches("\"inclusion\": false").count();
    let before = Account::new(&playback(), None, None).unwrap();
    assert_eq!(fences(&account), fences(&before) + 1);

    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("next.geojson"), text).unwrap();
    let next = "name = 'next'\nmap.file = 'next.geojson'\nobjects.count = 1\nmission.budget_seconds = 60.0\n";
    let next = Scenario::from_text(&folder.path().join("next.toml"), next.to_owned()).unwrap();
    let closed = account.point(at(3, 12));
    let frame = next.earth().unwrap().frame;
    let (east, north) = frame.meters(closed);
    let away = |cell: &Cell| {
        let center = next.terrain().center_meters(*cell);
        (center.0 - east).hypot(center.1 - north)
    };
    let cell = next.terrain().grid().cells().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
    assert!(!next.terrain().is_traversable(cell));
}
