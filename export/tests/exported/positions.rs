//! Finds at the positions that robots know.

use std::sync::Arc;

use dragnet_coordinator::mission::Record;
use dragnet_export::{Account, geojson, gpx, kml};
use dragnet_scenario::time::MissionTime;
use dragnet_search::object_position::ObjectPosition;
use serde_json::Value;

use crate::mission::{at, playback};

#[test]
fn a_find_is_where_a_robot_has_located_it_and_the_others_in_the_middle_of_their_cells() {
    let mut playback = playback();
    let before = Account::new(&playback, None, None).unwrap();
    // 258 m east and 61.5 m north; the middle of its cell is at 250 m and 70 m.
    let position = ObjectPosition::new(at(3, 12), [258.0, 61.5], [0.04, 0.0, 0.25]).unwrap();
    let first = playback.records.iter_mut().find_map(|(_, record)| match record {
        Record::Observation(observation) => Some(observation),
        _ => None,
    });
    Arc::make_mut(first.unwrap()).positions = [position].into();
    let account = Account::new(&playback, None, None).unwrap();
    let there = account.frame.point((258.0, 61.5));
    assert_eq!(account.place(at(3, 12)), there);
    assert_eq!(account.place(at(9, 4)), account.point(at(9, 4)));

    let found = |account: &Account| {
        let text: Value = serde_json::from_str(&geojson::text(account)).unwrap();
        let features = text["features"].as_array().unwrap().clone();
        let of = |feature: &Value| feature["properties"]["kind"] == "found";
        features.into_iter().filter(of).collect::<Vec<_>>()
    };
    let [other, object] = &found(&account)[..] else { panic!("two are found") };
    assert_eq!((other, &other["properties"]["accuracy_meters"]), (&found(&before)[0], &Value::Null));
    let coordinate = |axis: usize| object["geometry"]["coordinates"][axis].as_f64().unwrap();
    let off = [coordinate(0) - there.longitude_degrees, coordinate(1) - there.latitude_degrees];
    assert!(off.iter().all(|degrees| degrees.abs() < 1e-9), "{object}");
    let accuracy = object["properties"]["accuracy_meters"].as_f64().unwrap();
    assert!((accuracy - 0.5 * 2.4477).abs() < 1e-3, "{accuracy}");

    let degrees = |degrees: f64| format!("{degrees:.7}");
    let [latitude, longitude] = [there.latitude_degrees, there.longitude_degrees].map(degrees);
    let gpx = gpx::text(&account);
    assert!(gpx.contains(&format!("lat=\"{latitude}\" lon=\"{longitude}\"")), "{gpx}");
    assert!(gpx.contains("probability 0.9876, within 1.3 m with 95 % probability<"), "{gpx}");
    assert_eq!(gpx.matches("within").count(), 1);
    let kml = kml::text(&account);
    assert_eq!(kml.matches("accuracy_meters").count(), 1, "{kml}");

    // Before the mission is declared over, only what was known by then counts.
    let earlier = Account::new(&playback, None, Some(MissionTime(0))).unwrap();
    assert!(earlier.found.is_empty() && earlier.positions.is_empty());
}
