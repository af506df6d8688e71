//! A mission on the earth: where robots, objects and areas are, as maps of viewers show it.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_coordinator::mission::Record;
use dragnet_coordinator::record::Header;
use dragnet_coordinator::record::encoder::{Encoded, Encoder};
use dragnet_ros2::cdr;
use dragnet_ros2::schema::RosMessage;
use dragnet_ros2::wire::markers::Marker;
use dragnet_ros2::wire::robot::NavSatFix;
use dragnet_ros2::wire::standard::GeoJson;
use dragnet_scenario::map_file::Earth;
use dragnet_scenario::time::MissionTime;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::{Observation, Origin, RobotId};
use serde_json::{Value, json};

use crate::episode::{Episode, OBJECT, header};

const AREA: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"Wood"},"geometry":
    {"type":"Polygon","coordinates":[[[9.5,47.0],[9.502,47.0],[9.502,47.001],[9.5,47.0]]]}}]}"#;

fn earth() -> Earth {
    let facts = [
        ("south_west_latitude_degrees", "47.0"),
        ("south_west_longitude_degrees", "9.5"),
        ("reference_latitude_degrees", "47.0"),
        ("expected_objects", "1"),
    ];
    let facts: BTreeMap<String, String> =
        facts.into_iter().map(|(name, text)| (name.to_owned(), text.to_owned())).collect();
    Earth::read(&facts, AREA).unwrap()
}

/// All messages of the episode.
fn messages(header: &Header) -> Vec<Encoded> {
    let (mut encoder, episode) = (Encoder::new(header), Episode::play());
    let opening = encoder.opening(&header.prior);
    let later = episode.records.iter().flat_map(|(now, record)| encoder.encode(*now, record));
    opening.into_iter().chain(later).collect()
}

fn of<'a>(messages: &'a [Encoded], topic: &str, schema: &str) -> Vec<&'a Encoded> {
    let of = messages.iter().filter(|message| message.topic().to_string() == topic);
    of.inspect(|message| assert_eq!(message.schema_name(), schema)).collect()
}

/// Each text of a topic, as JSON.
fn geojson(messages: &[Encoded], topic: &str) -> Vec<Value> {
    let of = of(messages, topic, GeoJson::NAME).into_iter();
    of.map(|message| {
        let GeoJson { geojson } = cdr::decode(message.data()).unwrap();
        serde_json::from_str(&geojson).unwrap()
    })
    .collect()
}

#[test]
fn robots_objects_and_areas_have_places_on_the_earth() {
    let messages = messages(&Header { earth: Some(earth()), ..header() });
    // Degrees of a meter on the ellipsoid at 47 degrees north.
    let [north, east] = [1.0 / 111_171.0, 1.0 / 76_056.0];
    let fixes = of(&messages, "/robots/1/fix", NavSatFix::NAME);
    assert_eq!(fixes.len(), of(&messages, "/robots/1/pose", "geometry_msgs/msg/PoseStamped").len());
    let first: NavSatFix = cdr::decode(fixes[0].data()).unwrap();
    let last: NavSatFix = cdr::decode(fixes[fixes.len() - 1].data()).unwrap();
    assert_eq!(first.header.frame_id, "robot_1");
    assert!((first.latitude - 47.0 - 15.0 * north).abs() < 1e-7, "{first:?}");
    assert!((first.longitude - 9.5 - 15.0 * east).abs() < 1e-7, "{first:?}");
    assert!(first.altitude.is_nan() && last.longitude > first.longitude + 29.0 * east, "{last:?}");

    let balls = of(&messages, "/objects/marker", Marker::NAME).into_iter();
    let balls = balls.map(|message| cdr::decode::<Marker>(message.data()).unwrap().points.len());
    assert_eq!(balls.collect::<Vec<_>>(), [1, 2, 1], "one is withdrawn");

    let places = geojson(&messages, "/objects/geojson");
    let names = |place: &Value| {
        let features = place["features"].as_array().unwrap().iter();
        features.map(|feature| feature["properties"]["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let names: Vec<Vec<String>> = places.iter().map(names).collect();
    let (mirage, object) = ("object in cell [0, 3]".to_owned(), "object in cell [2, 5]".to_owned());
    assert_eq!(names, [vec![mirage.clone()], vec![mirage, object.clone()], vec![object]], "one is withdrawn");
    let found = &places[2]["features"][0]["geometry"];
    assert_eq!(found["type"], "Point");
    let at = |index: usize| found["coordinates"][index].as_f64().unwrap();
    assert!(
        (at(0) - 9.5 - 165.0 * east).abs() < 1e-7 && (at(1) - 47.0 - 75.0 * north).abs() < 1e-7,
        "{found}"
    );

    let areas = geojson(&messages, "/areas/geojson");
    assert_eq!(areas.len(), 1);
    assert_eq!(areas[0]["features"][0]["properties"]["name"], json!("Wood"));
}

/// The robot locates the object again after it was declared.
#[test]
fn located_objects_are_drawn_at_their_positions_and_anew_when_they_are_known_better() {
    let header = Header { earth: Some(earth()), ..header() };
    let (mut encoder, episode) = (Encoder::new(&header), Episode::play());
    let locate = |sequence, meters| {
        let cell = header.terrain.grid().cell_numbered(OBJECT).unwrap();
        let positions = ObjectPosition::new(cell, meters, [0.25, 0.0, 0.25]).into_iter().collect();
        let origin = Origin { source: RobotId::FIRST.into(), incarnation: 9 };
        let (time_ns, from, readings) = (1, cell, Vec::new());
        Record::Observation(Arc::new(Observation { origin, sequence, time_ns, from, readings, positions }))
    };
    let mut messages = encoder.encode(MissionTime(1), &locate(0, [161.0, 72.0]));
    assert_eq!(messages.len(), 1, "nothing is declared yet");
    messages.extend(episode.records.iter().flat_map(|(now, record)| encoder.encode(*now, record)));
    let end = episode.records.last().unwrap().0;
    let again = encoder.encode(end, &locate(1, [161.5, 72.5]));
    assert_eq!(again.len(), 3, "the observation, the marker and the place");
    assert_eq!(encoder.encode(end, &locate(1, [161.5, 72.5])).len(), 1, "a repeated one is no news");
    messages.extend(again);
    let balls = of(&messages, "/objects/marker", Marker::NAME).into_iter();
    let last = balls.map(|message| cdr::decode::<Marker>(message.data()).unwrap().points);
    let last: Vec<(f64, f64)> = last.map(|points| points.last().map(|at| (at.x, at.y)).unwrap()).collect();
    let at = |meters| header.origin.point(meters);
    assert_eq!(last[1..], [at((161.0, 72.0)), at((161.0, 72.0)), at((161.5, 72.5))]);
    let places = geojson(&messages, "/objects/geojson");
    let place = &places.last().unwrap()["features"][0];
    assert_eq!(place["properties"]["name"], "object in cell [2, 5], within 1.3 m with 95 % probability");
    let point = earth().frame.point((161.5, 72.5));
    assert_eq!(place["geometry"]["coordinates"], json!([point.longitude_degrees, point.latitude_degrees]));
}

#[test]
fn a_mission_elsewhere_has_none() {
    let has_place = |message: &Encoded| {
        let topic = message.topic().to_string();
        topic.ends_with("/fix") || topic.ends_with("/geojson")
    };
    assert!(!messages(&header()).iter().any(has_place));
}
