//! `dragnet export`, and the report of `dragnet check` on areas.

use std::fs;

use serde_json::Value;

use super::Place;

const AREAS: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"Field"},"geometry":{"type":"Polygon","coordinates":
    [[[0,0],[0.003,0],[0.003,0.003],[0,0.003],[0,0]]]}},
{"type":"Feature","properties":{"name":"Pond","kind":"no_go"},"geometry":{"type":"Polygon","coordinates":
    [[[0.0012,0.0012],[0.0016,0.0012],[0.0016,0.0016],[0.0012,0.0012]]]}},
{"type":"Feature","properties":{"name":"Wood","poa":"70%"},"geometry":{"type":"Polygon","coordinates":
    [[[0,0],[0.001,0],[0.001,0.003],[0,0.003],[0,0]]]}},
{"type":"Feature","properties":{"name":"Tent"},"geometry":{"type":"Point","coordinates":[0,0]}}]}"#;
const DRAWN: &str = "name = 'drawn'
map = { file = 'areas.geojson', cell_meters = 30.0 }
objects.cells = [[2, 1], [8, 7]]
robots = { count = 2, start = [0, 10] }
mission.budget_meters = 3000.0
";

fn searched() -> Place {
    let place = Place::new();
    place.write("areas.geojson", AREAS);
    place.write("drawn.toml", DRAWN);
    place.json(&["run", "drawn.toml", "--record", "drawn.mcap", "--json"]);
    place
}

#[test]
fn check_lists_the_drawn_areas() {
    let place = searched();
    let text = place.succeed(&["check", "drawn.toml"]);
    for line in [
        "  south-western corner at latitude 0.000000, longitude 0.000000\n",
        "  search \"Field\": 121 searched cells\n",
        "  no_go \"Pond\": closes 3 cells\n",
        "  prior \"Wood\": POA 70.0 % in 44 cells\n",
        "  rest: POA 30.0 %, spread over 77 cells outside of all areas\n",
        "drawn.toml: warning: left out: Tent; kinds are search, no_go, prior, last_known_position, linear_feature, start\n",
    ] {
        assert!(text.contains(line), "{line}{text}");
    }
}

/// A search reports ignored features without being asked.
#[test]
fn a_run_reports_ignored_features_and_obeys_no_go_areas_in_html() {
    let place = Place::new();
    let area = |description: &str, shape: &str| {
        format!(
            "<Placemark><name>A</name><description><![CDATA[{description}]]></description>{shape}</Placemark>"
        )
    };
    let wood = "<Polygon><outerBoundaryIs><LinearRing><coordinates>8,47 8.01,47 8.01,47.01 8,47.01 8,47</coordinates>\
                </LinearRing></outerBoundaryIs></Polygon>";
    let cliff = "<LineString><coordinates>8.005,47 8.005,47.01</coordinates></LineString>";
    let tent = "<Placemark><name>Tent</name><Point><coordinates>8,47</coordinates></Point></Placemark>";
    let areas = [area("", wood), area("<div>kind: no_go</div>", cliff), tent.to_owned()].concat();
    place.write("area.kml", &format!("<kml>{areas}</kml>"));
    let scenario = "name = 'area'\nmap.file = 'area.kml'\nobjects.count = 1\nmission.budget_meters = 300.0\n";
    place.write("area.toml", scenario);
    let output = place.dragnet(&["run", "area.toml", "--record", "area.mcap", "--json"]);
    let reported = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && reported.contains("left out: Tent"), "{reported}");
    assert!(place.succeed(&["check", "area.toml"]).contains("no_go \"A\""));
    place.write("area.kml", &format!("<kml>{}</kml>", areas.replace("kind: no_go", "no_go")));
    let output = place.dragnet(&["run", "area.toml", "--record", "again.mcap"]);
    let reported = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(2) && reported.contains("\"no_go\", which is not understood"),
        "{reported}"
    );
}

#[test]
fn a_recording_alone_becomes_a_file_of_each_format() {
    let place = searched();
    let inspected = place.succeed(&["inspect", "drawn.mcap"]);
    assert!(inspected.contains("map           its south-western corner at latitude "), "{inspected}");
    assert_eq!(inspected.matches("] at latitude ").count(), 2, "{inspected}");
    let text = place.succeed(&["export", "drawn.mcap", "--to", "out.geojson"]);
    assert!(
        text.starts_with("out.geojson\ndrawn after ") && text.contains(": 2 objects found, 2 tracks"),
        "{text}"
    );
    let file: Value = serde_json::from_str(&fs::read_to_string(place.path("out.geojson")).unwrap()).unwrap();
    let kinds = |kind: &str| {
        let features = file["features"].as_array().unwrap().iter();
        features.filter(|feature| feature["properties"]["kind"] == kind).count()
    };
    assert_eq!([kinds("found"), kinds("track"), kinds("prior"), kinds("search")], [2, 2, 1, 1]);
    assert!(file["pos"].as_f64().unwrap() > 0.9, "{}", file["pos"]);
    for (name, format, beginning) in
        [("out.kml", "kml", "<?xml"), ("out.gpx", "gpx", "<?xml"), ("out.txt", "geojson", "{\"type\"")]
    {
        place.succeed(&["export", "drawn.mcap", "--to", name, "--format", format]);
        assert!(fs::read_to_string(place.path(name)).unwrap().starts_with(beginning));
    }
    let text = place.succeed(&["export", "drawn.mcap", "--to", "out.plan", "--at", "20"]);
    assert!(text.starts_with("out-robot-1.plan\nout-robot-2.plan\ndrawn after 20.0 s"), "{text}");
    assert!(place.path("out-robot-2.plan").is_file() && !place.path("out.plan").exists());
}

#[test]
fn the_same_run_gives_the_same_files() {
    let [a, b] = [searched(), searched()].map(|place| {
        ["geojson", "kml", "gpx"].map(|extension| {
            let name = format!("out.{extension}");
            place.succeed(&["export", "drawn.mcap", "--to", &name]);
            fs::read(place.path(&name)).unwrap()
        })
    });
    assert!(a == b && a.iter().all(|file| file.len() > 1000));
}

#[test]
fn a_map_without_a_place_needs_an_origin() {
    let place = Place::new();
    place.json(&["run", "small.toml", "--record", "small.mcap", "--json"]);
    let export = |rest: &[&'static str]| [&["export", "small.mcap", "--to", "a.kml"], rest].concat();
    place.refuse(&export(&[]), &["small.mcap", "does not say where on earth", "--origin"]);
    place.refuse(&export(&["--origin", "49.2"]), &["--origin", "LATITUDE,LONGITUDE"]);
    assert!(!place.path("a.kml").exists());
    place.succeed(&export(&["--origin", "-33.9,18.4"]));
    // Nothing in the table of segments depends on where the map is.
    for (to, rest) in [("without.csv", &[][..]), ("with.csv", &["--origin", "-33.9,18.4"])] {
        let printed = place.succeed(&[&["export", "small.mcap", "--to", to], rest].concat());
        assert!(printed.contains("POD"), "{printed}");
    }
    let [without, with] =
        ["without.csv", "with.csv"].map(|file| fs::read_to_string(place.path(file)).unwrap());
    assert_eq!(without, with);
    assert_eq!(without.lines().count(), 2);
    assert!(fs::read_to_string(place.path("a.kml")).unwrap().contains("<coordinates>18.4"));
    let drawn = searched();
    drawn.refuse(
        &["export", "drawn.mcap", "--to", "a.kml", "--origin", "0,1"],
        &["says itself where", "no other"],
    );
}

#[test]
fn a_recording_that_cannot_be_exported_is_rejected() {
    let place = searched();
    place.refuse(
        &["export", "drawn.mcap", "--to", "a.shp"],
        &["a.shp", ".geojson, .kml, .gpx, .csv, .plan and .belief.json"],
    );
    place.refuse(&["export", "drawn.toml", "--to", "a.kml"], &["drawn.toml", "not a recording"]);
    place.refuse(&["export", "drawn.mcap", "--to", "a.plan"], &["no robot has a plan", "--at 0"]);
    place.refuse(&["export", "drawn.mcap", "--to", "areas.geojson"], &["areas.geojson", "exists already"]);
    place.refuse(
        &["export", "drawn.mcap", "--to", "a.kml", "--at", "-1"],
        &["--at", "0 to 1000000000 seconds"],
    );
    place.refuse(
        &["export", "drawn.mcap", "--to", "a.kml", "--at", "999999"],
        &["--at 999999", "the recording ends at", "allowed is 0 to that"],
    );
}

/// Two fields that share a column of cells, and an island.
const PARTS: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"west"},"geometry":{"type":"Polygon","coordinates":[[[8,47],[8.00205,47],[8.00205,47.004],[8,47.004],[8,47]]]}},
{"type":"Feature","properties":{"name":"east"},"geometry":{"type":"Polygon","coordinates":[[[8.00205,47],[8.004,47],[8.004,47.004],[8.00205,47.004],[8.00205,47]]]}},
{"type":"Feature","properties":{"name":"island"},"geometry":{"type":"Polygon","coordinates":[[[8.02,47],[8.023,47],[8.023,47.003],[8.02,47.003],[8.02,47]]]}}]}"#;

#[test]
fn a_map_alone_with_parts_says_where_robots_start_and_what_counts_twice() {
    let place = Place::new();
    place.write("parts.geojson", PARTS);
    let checked = place.succeed(&["check", "parts.geojson"]);
    assert!(checked.contains("searched cells: one that several areas touch counts in each\n"), "{checked}");
    assert!(checked.contains("the area is in 2 parts that no way connects; 1 has no robot"), "{checked}");
    let output = place.dragnet(&["run", "parts.geojson", "--robots", "2", "--record", "parts.mcap"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.contains("2 robots that start in 2 parts of it"), "{told}");
    assert!(told.contains("2 parts that no way connects; 1 robot starts in that of"), "{told}");
    assert!(!told.contains("out of every robot's sight"), "{told}");
    let exported = place.succeed(&["export", "parts.mcap", "--to", "parts.gpx"]);
    assert!(exported.contains("a cell that several areas touch counts in the cells of each"), "{exported}");
    place.refuse(&["check", "parts.gpx"], &["it is the export of a search", "GeoJSON or the KML"]);
}

/// The values of a row, by title.
type Values = Vec<(String, Option<f64>)>;

/// The segments of a CSV file by name.
fn segments(text: &str) -> Vec<(String, Values)> {
    let mut lines = text.lines();
    let titles: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &str| {
        let values: Vec<&str> = line.split(',').collect();
        assert_eq!(values.len(), titles.len(), "{line}");
        let numbers = titles.iter().zip(&values).skip(2);
        let numbers = numbers.map(|(title, value)| ((*title).to_owned(), value.parse().ok())).collect();
        (values[0].trim_matches('"').to_owned(), numbers)
    };
    lines.map(row).collect()
}

fn value(numbers: &[(String, Option<f64>)], title: &str) -> f64 {
    numbers.iter().find(|(known, _)| known == title).and_then(|(_, number)| *number).unwrap()
}

#[test]
fn the_effort_in_each_segment_is_told_alike_by_inspect_and_export() {
    let place = searched();
    let printed = place.succeed(&["export", "drawn.mcap", "--to", "drawn.csv"]);
    let text = fs::read_to_string(place.path("drawn.csv")).unwrap();
    let rows = segments(&text);
    let names: Vec<&str> = rows.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["Field", "Wood", "in all"], "{text}");
    // The same table in both, and in it the numbers of the file.
    let table = |text: &str| -> Vec<String> {
        let from = text.lines().position(|line| line.starts_with("area ")).unwrap();
        text.lines().skip(from).take(4).map(str::to_owned).collect()
    };
    let shown = table(&printed);
    assert_eq!(shown, table(&place.succeed(&["inspect", "drawn.mcap"])));
    for ((name, numbers), line) in rows.iter().zip(&shown[1..]) {
        let [area, poa, pod, pos, width, track, effort, coverage] = [
            "area_square_meters",
            "poa",
            "pod",
            "pos",
            "sweep_width_meters",
            "track_meters",
            "effort_square_meters",
            "coverage",
        ]
        .map(|title| value(numbers, title));
        assert!(
            (pos - poa * pod).abs() < 1e-12 && (effort - width * track).abs() < 1e-6,
            "{name} {numbers:?}"
        );
        assert!((coverage - effort / area).abs() < 1e-9 && width > 30.0 && track > 0.0, "{name} {numbers:?}");
        // Of a radius of 5 cells.
        assert!(width <= 11.0 * 30.0, "{width}");
        for part in [
            format!("{:.1} %", 100.0 * poa),
            format!("{:.1} %", 100.0 * pod),
            format!("{width:.1} m"),
            format!("{:.2} km", track / 1000.0),
            format!("{coverage:.2}"),
            format!("{:.2} ha", area / 10_000.0),
        ] {
            assert!(line.starts_with(name.as_str()) && line.contains(&part), "{part} is not in {line}");
        }
    }
    // 121 cells of 30 m, and all that both robots have driven.
    let all = &rows[2].1;
    let report = place.json(&["run", "drawn.toml", "--record", "again.mcap", "--json"]);
    let cells = report["path_cells"].as_array().unwrap().iter().map(|cells| cells.as_f64().unwrap());
    let driven = 30.0 * cells.sum::<f64>();
    assert!((value(all, "area_square_meters") - 121.0 * 900.0).abs() < 1e-6);
    assert!((value(all, "track_meters") - driven).abs() < 1e-6, "{text} {driven}");
    let map: Value = {
        place.succeed(&["export", "drawn.mcap", "--to", "drawn.geojson"]);
        serde_json::from_str(&fs::read_to_string(place.path("drawn.geojson")).unwrap()).unwrap()
    };
    assert!((map["pod"].as_f64().unwrap() - value(all, "pod")).abs() < 1e-12);
}
