//! Independent libraries read the files: geojson and shapely, fastkml with the schema of KML, gpxpy.

use std::path::Path;
use std::process::Command;

use dragnet_export::{Account, geojson, gpx, kml};
use dragnet_scenario::map_file::Areas;
use serde_json::{Value, json};

use crate::interpreter::interpreter;
use crate::mission::{STEPS, at, playback, scenario};

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The results of each reader.
fn read(account: &Account) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let texts = [geojson::text(account), kml::text(account), gpx::text(account)];
    let paths = ["a.geojson", "a.kml", "a.gpx"].map(|name| folder.path().join(name));
    for (path, text) in paths.iter().zip(texts) {
        std::fs::write(path, text).unwrap();
    }
    let script = Path::new(WORKSPACE).join("tests/python/read_export.py");
    let output = Command::new(interpreter(Path::new(WORKSPACE))).arg(script).args(paths).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

fn is_near(given: &Value, expected: f64) -> bool {
    (number(given) - expected).abs() < 1e-7
}

/// Square degrees of a cell: what bands of cells must add up to.
fn cell_square_degrees(account: &Account) -> f64 {
    let (a, b) = (account.point(at(0, 0)), account.point(at(1, 1)));
    (b.longitude_degrees - a.longitude_degrees) * (b.latitude_degrees - a.latitude_degrees)
}

#[test]
fn other_libraries_read_the_files() {
    let account = Account::new(&playback(), None, None).unwrap();
    let seen = read(&account);
    check_geojson(&account, &seen["geojson"]);
    check_kml(seen["kml"].as_array().unwrap(), &seen["geojson"]);
    check_gpx(&account, &seen["gpx"]);
}

fn check_geojson(account: &Account, seen: &Value) {
    assert!(is_near(&seen["pod"], account.total.pod) && is_near(&seen["pos"], account.total.pos()));
    let features = seen["features"].as_array().unwrap();
    let of =
        |kind: &str| features.iter().filter(move |it| it["properties"]["kind"] == kind).collect::<Vec<_>>();
    let found = of("found");
    let reported = |it: &Value| json!([it["properties"]["name"], it["properties"]["declared_at"]]);
    assert_eq!(reported(found[0]), json!(["Object 1", "2026-03-01T12:00:45Z"]));
    assert_eq!(reported(found[1]), json!(["Object 2", "2026-03-01T12:02:05Z"]));
    let point = account.point(at(9, 4));
    assert!(is_near(&found[0]["bounds"][0], point.longitude_degrees));
    assert!(is_near(&found[0]["bounds"][1], point.latitude_degrees));
    let tracks = of("track");
    assert_eq!(tracks.len(), 2);
    assert_eq!(tracks[0]["positions"].as_array().unwrap().len(), STEPS as usize);
    assert_eq!(tracks[0]["properties"]["coordTimes"][17], "2026-03-01T12:02:50Z");
    check_bands(account, &of("cleared"));
    let not_searched = of("not_searched");
    let cells = account.terrain.searched_cells().filter(|cell| account.pod[cell.index()] < 0.1).count();
    assert!(cells > 0 && not_searched.len() == 1, "{not_searched:?}");
    assert_eq!(not_searched[0]["properties"]["cells"], cells);
    let south = features.iter().find(|it| it["properties"]["name"] == "South").unwrap();
    assert!(is_near(&south["properties"]["poa"], 0.6) && number(&south["properties"]["pod"]) > 0.95);
}

/// Each cell is in the band of its probability of detection, and the polygons are as large as their cells.
fn check_bands(account: &Account, bands: &[&Value]) {
    assert!(bands.len() >= 3, "{bands:?}");
    for band in bands {
        let (from, to) = (number(&band["properties"]["pod_from"]), number(&band["properties"]["pod_to"]));
        let cells = account.pod.iter().filter(|&&pod| pod >= from && (pod < to || to >= 1.0)).count();
        assert_eq!(band["properties"]["cells"], cells);
        let expected = cells as f64 * cell_square_degrees(account);
        assert!((number(&band["square_degrees"]) / expected - 1.0).abs() < 1e-9, "{band}");
    }
}

fn check_kml(seen: &[Value], geojson: &Value) {
    let of = |folder: &str| seen.iter().filter(move |it| it["folder"] == folder).collect::<Vec<_>>();
    assert_eq!(of("Found").len(), 2);
    assert_eq!(of("Found")[1]["times"], json!(["2026-03-01 12:02:05+00:00"]));
    assert_eq!(of("Tracks")[0]["times"], json!(["2026-03-01 12:00:00+00:00", "2026-03-01 12:02:50+00:00"]));
    let areas = of("Areas");
    let names: Vec<&str> = areas.iter().map(|it| it["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Field & wood", "Pond", "South", "Car"]);
    assert!(is_near(&areas[3]["data"]["spread_meters"], 50.0) && is_near(&areas[3]["data"]["poa"], 0.2));
    let features = geojson["features"].as_array().unwrap();
    let bands: Vec<_> = features.iter().filter(|it| it["properties"]["kind"] == "cleared").collect();
    assert_eq!(of("Cleared").len(), bands.len());
    for (in_kml, in_geojson) in of("Cleared").into_iter().zip(bands) {
        let (a, b) = (number(&in_kml["square_degrees"]), number(&in_geojson["square_degrees"]));
        assert!((a / b - 1.0).abs() < 1e-9);
    }
}

fn check_gpx(account: &Account, seen: &Value) {
    assert_eq!(seen["version"], "1.1");
    let waypoints = seen["waypoints"].as_array().unwrap();
    assert_eq!(json!([waypoints[1][0], waypoints[1][1]]), json!(["Object 2", "probability 0.9876"]));
    assert_eq!(waypoints[1][4], "2026-03-01T12:02:05+00:00");
    let track = seen["tracks"]["Robot 2"].as_array().unwrap();
    assert_eq!(track.len(), STEPS as usize);
    for (column, point) in (0..).zip(track) {
        let expected = account.point(at(10, column));
        assert!(
            is_near(&point[0], expected.longitude_degrees) && is_near(&point[1], expected.latitude_degrees)
        );
    }
    assert_eq!(track[3][2], "2026-03-01T12:00:30+00:00");
}

/// The next mission begins with the drawn areas: the exported features are ignored.
#[test]
fn an_export_is_a_map_again() {
    let account = Account::new(&playback(), None, None).unwrap();
    let file = Path::new("a");
    for areas in [
        Areas::from_geojson(file, &geojson::text(&account)).unwrap(),
        Areas::from_kml(file, &kml::text(&account)).unwrap(),
    ] {
        let names = |areas: &Areas| areas.areas.iter().map(|it| it.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&areas), names(&scenario().areas()));
        assert_eq!(areas.left_out.len(), 1, "{:?}", areas.left_out);
        for (given, expected) in areas.areas.iter().zip(scenario().areas().areas) {
            assert_eq!(given.purpose.word(), expected.purpose.word());
        }
    }
}

#[test]
fn names_that_no_xml_can_hold_are_cleaned() {
    let mut account = Account::new(&playback(), None, None).unwrap();
    account.name = "a\u{0}<b>&\u{1b}]]>\u{fffe}".to_owned();
    assert!(kml::text(&account).contains("<name>a&lt;b&gt;&amp;]]&gt;</name>"), "{}", kml::text(&account));
    assert_eq!(read(&account)["gpx"]["version"], "1.1");
}
