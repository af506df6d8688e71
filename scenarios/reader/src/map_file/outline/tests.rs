use std::time::Instant;

use proptest::prelude::*;

use super::*;
use crate::mentions::assert_mentions;

/// Lengths of 1 degree at the equator, meters.
const EAST_METERS: f64 = 111_319.490_793;
const NORTH_METERS: f64 = 110_574.275_821;

fn read(text: &str, cell_meters: f64) -> Result<MapFile, String> {
    let file = Path::new("a.geojson");
    let map = Areas::from_geojson(file, text).and_then(|areas| super::map(file, areas, cell_meters));
    map.map_err(|error| error.to_string())
}

/// A polygon at the equator from rings in meters.
fn polygon_of(rings: &[&[(f64, f64)]]) -> String {
    let degrees =
        |&(east, north): &(f64, f64)| format!("[{:.12},{:.12}]", east / EAST_METERS, north / NORTH_METERS);
    let ring = |ring: &&[(f64, f64)]| {
        format!("[{}]", ring.iter().chain(&ring[..1]).map(degrees).collect::<Vec<_>>().join(","))
    };
    let rings: Vec<String> = rings.iter().map(ring).collect();
    format!(r#"{{"type":"Polygon","coordinates":[{}]}}"#, rings.join(","))
}

fn check(rings: &[&[(f64, f64)]], cell_meters: f64, expected: &str) {
    let map = read(&polygon_of(rings), cell_meters).unwrap();
    assert_eq!(map.terrain, Terrain::from_ascii(expected, cell_meters).unwrap());
}

#[test]
fn half_of_the_area_opens_a_cell() {
    let square = [(0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0)];
    check(&[&square], 10.0, "....\n....\n....");
    check(&[&square], 20.0, "..\n..");
    check(&[&square], 29.0, "##\n.#");
    let triangle = [(0.0, 0.0), (39.0, 0.0), (0.0, 39.0)];
    check(&[&triangle], 10.0, "####\n.###\n..##\n...#");
}

#[test]
fn holes_are_blocked() {
    let square = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0)];
    let hole = [(10.0, 10.0), (10.0, 30.0), (20.0, 30.0), (20.0, 10.0)];
    check(&[&square, &hole], 10.0, "....\n.#..\n.#..\n....");
}

#[test]
fn features_and_collections_are_one_area() {
    let at = |west: f64| polygon_of(&[&[(west, 0.0), (west + 10.0, 0.0), (west + 10.0, 10.0), (west, 10.0)]]);
    let feature = |west: f64| format!(r#"{{"type":"Feature","properties":null,"geometry":{}}}"#, at(west));
    let collection =
        format!(r#"{{"type":"FeatureCollection","features":[{},{}]}}"#, feature(0.0), feature(30.0));
    let expected = Terrain::from_ascii(".##.", 10.0).unwrap();
    assert_eq!(read(&collection, 10.0).unwrap().terrain, expected);
    assert_eq!(read(&feature(5.0), 10.0).unwrap().terrain, Terrain::from_ascii(".", 10.0).unwrap());
    // Neighbors whose common corners are rounded, and two that share a cell of three.
    let pair = |west: f64| {
        format!(r#"{{"type":"FeatureCollection","features":[{},{}]}}"#, feature(0.0), feature(west))
    };
    assert_eq!(read(&pair(9.995), 10.0).unwrap().terrain, Terrain::from_ascii("..", 10.0).unwrap());
    assert!(read(&pair(9.995), 10.0).unwrap().overlaps.is_empty());
    let shared = read(&pair(5.0), 5.0).unwrap();
    assert_eq!(shared.terrain, Terrain::from_ascii("...\n...", 5.0).unwrap());
    assert_eq!(shared.overlaps, [["feature 1".to_owned(), "feature 2".to_owned()]]);
    // The other way around, and as one area.
    let clockwise = polygon_of(&[&[(5.0, 0.0), (5.0, 10.0), (15.0, 10.0), (15.0, 0.0)]]);
    let turned = format!(r#"{{"type":"Feature","properties":null,"geometry":{clockwise}}}"#);
    let turned = format!(r#"{{"type":"FeatureCollection","features":[{},{turned}]}}"#, feature(0.0));
    assert_eq!(read(&turned, 5.0).unwrap().terrain, shared.terrain);
    let together = format!(r#"{{"type":"GeometryCollection","geometries":[{},{clockwise}]}}"#, at(0.0));
    let one = read(&together, 5.0).unwrap();
    assert_eq!((&one.terrain, one.overlaps.len()), (&shared.terrain, 0));
}

#[test]
fn neighbors_may_share_a_border() {
    let at =
        |west: &str, east: &str| format!("[[[{west},0],[{east},0],[{east},0.1],[{west},0.1],[{west},0]]]");
    let both = [at("0.0", "0.1"), at("0.1", "0.2")].join(",");
    let text = format!(r#"{{"type":"MultiPolygon","coordinates":[{both}]}}"#);
    // Of 0.2 x 0.1 degrees, 4.45 x 2.21 cells; the border runs through the third column.
    let expected = Terrain::from_ascii("#####\n....#\n....#", 5_000.0).unwrap();
    assert_eq!(read(&text, 5_000.0).unwrap().terrain, expected);
}

/// A feature collection of shapes in meters at the equator, each with properties.
fn features(drawn: &[(&str, String)]) -> String {
    let feature = |(properties, geometry): &(&str, String)| {
        format!(r#"{{"type":"Feature","properties":{{{properties}}},"geometry":{geometry}}}"#)
    };
    let features: Vec<String> = drawn.iter().map(feature).collect();
    format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","))
}

#[test]
fn cells_that_a_no_go_area_touches_are_closed_and_searched_from_outside() {
    let area = polygon_of(&[&[(0.0, 0.0), (50.0, 0.0), (50.0, 40.0), (0.0, 40.0)]]);
    let pond = polygon_of(&[&[(12.0, 12.0), (28.0, 12.0), (28.0, 18.0), (12.0, 18.0)]]);
    let text = features(&[("", area.clone()), (r#""kind":"No-go""#, pond)]);
    let expected = Terrain::from_ascii(".....\n.....\n.~~..\n.....", 10.0).unwrap();
    assert_eq!(read(&text, 10.0).unwrap().terrain, expected);
    // A pond that is drawn twice, the other way around the second time.
    let ring = |corners: [(f64, f64); 4]| {
        let at = |(x, y): (f64, f64)| format!("[{},{}]", x / EAST_METERS, y / NORTH_METERS);
        let closed: Vec<String> = corners.into_iter().chain([corners[0]]).map(at).collect();
        format!("[[{}]]", closed.join(","))
    };
    let corners = [(2.0, 2.0), (38.0, 2.0), (38.0, 38.0), (2.0, 38.0)];
    let turned = [corners[0], corners[3], corners[2], corners[1]];
    let twice = format!(r#"{{"type":"MultiPolygon","coordinates":[{},{}]}}"#, ring(corners), ring(turned));
    let text = features(&[("", area.clone()), (r#""kind":"no_go""#, twice)]);
    let expected = Terrain::from_ascii("~~~~.\n~~~~.\n~~~~.\n~~~~.", 10.0).unwrap();
    assert_eq!(read(&text, 10.0).unwrap().terrain, expected);
    // A fence from the south, thinner than anything.
    let (east, north) = (25.0 / EAST_METERS, 22.0 / NORTH_METERS);
    let fence = format!(r#"{{"type":"LineString","coordinates":[[{east},-0.0001],[{east},{north}]]}}"#);
    let text = features(&[("", area), (r#""kind":"no_go""#, fence)]);
    let expected = Terrain::from_ascii(".....\n..~..\n..~..\n..~..", 10.0).unwrap();
    assert_eq!(read(&text, 10.0).unwrap().terrain, expected);
}

#[test]
fn a_no_go_area_far_away_is_rejected() {
    let area = polygon_of(&[&[(0.0, 0.0), (50.0, 0.0), (50.0, 40.0), (0.0, 40.0)]]);
    let far = polygon_of(&[&[(0.0, 2e5), (50.0, 2e5), (50.0, 3e5)]]);
    let text = features(&[("", area), (r#""kind":"no_go","name":"moor""#, far)]);
    let error = read(&text, 10.0).unwrap_err();
    assert_mentions(&error, r#"area "moor" .. 200 km .. at most 100 km"#);
}

#[test]
fn the_frame_starts_at_the_south_western_corner() {
    let map = read(&polygon_of(&[&[(100.0, 200.0), (140.0, 200.0), (140.0, 230.0), (100.0, 230.0)]]), 10.0)
        .unwrap();
    let frame = map.georeference.unwrap();
    let (east, north) = frame.meters(GeoPoint { longitude_degrees: 0.0, latitude_degrees: 0.0 });
    assert!((east + 100.0).abs() < 0.01 && (north + 200.0).abs() < 0.01, "{east} {north}");
}

#[test]
fn a_bad_polygon_is_reported_with_its_corner() {
    let check = |text: &str, message: &str| {
        let error = read(text, 10.0).unwrap_err();
        assert!(error.starts_with("a.geojson: "), "{error}");
        assert_mentions(&error, message);
    };
    let polygon = |coordinates: &str| format!(r#"{{"type":"Polygon","coordinates":{coordinates}}}"#);
    check("", "EOF");
    check(r#"{"type":"Polygone","coordinates":[]}"#, "Polygone");
    check(r#"{"type":"Point","coordinates":[0,0]}"#, "without a search area .. at least one polygon");
    check(r#"{"type":"FeatureCollection","features":[]}"#, "without a search area");
    check(&polygon("[]"), "geometry 1 .. polygon 1 .. without a ring .. an outer ring");
    check(&polygon("[[]]"), "polygon 1 .. ring 1 .. 0 .. at least 4");
    check(&polygon("[[[0,0],[1,0]]]"), "polygon 1 .. ring 1 .. 2 .. at least 4");
    check(
        &polygon("[[[0,0],[1,0],[1,1],[0,1]]]"),
        "polygon 1 .. ring 1 .. 4 positions .. not closed .. at least 4",
    );
    check(&polygon("[[[0,0],[1,0],[1,1],[0,1]]]"), "ring 1 .. 4 .. the last one .. the first");
    check(
        &polygon("[[[0,0],[190,0],[1,1],[0,0]]]"),
        "polygon 1 .. ring 1 .. position 2 .. [190.0, 0.0] .. [longitude, latitude]",
    );
    check(&polygon("[[[0,0],[1,95],[1,1],[0,0]]]"), "position 2 .. [1.0, 95.0]");
    check(&polygon("[[[0,0],[1],[1,1],[0,0]]]"), "position 2 .. [1.0]");
    check(&polygon("[[[0,0],[1e999,0],[1,1],[0,0]]]"), "number out of range");
    check(&polygon("[[[0,0],[NaN,0],[1,1],[0,0]]]"), "expected");
    check(
        &polygon("[[[0,0],[1,1],[1,0],[0,1],[0,0]]]"),
        "polygon 1 .. ring 1 crosses .. [0.500000, 0.500000] .. allowed",
    );
    check(&polygon("[[[0,0],[1,0],[1,0],[0,0]]]"), "ring 1 has fewer than 3 corners");
    check(&polygon("[[[0,0],[1,0],[1,1],[0,1],[0,0]],[[2,2],[3,2],[3,3],[2,2]]]"), "ring 2, is not inside");
    let hole = "[[0.1,0.1],[0.5,0.1],[0.5,0.5],[0.1,0.1]]";
    check(&polygon(&format!("[[[0,0],[1,0],[1,1],[0,1],[0,0]],{hole},{hole}]")), "rings 2 and 3, overlap");
    check(&polygon("[[[0,0],[90,0],[90,80],[0,80],[0,0]]]"), "10019 km .. [90, 0] .. at most 100 km");
    check(&polygon("[[[0,0],[0.6,0],[0.6,0.6],[0,0.6],[0,0]]]"), "allowed are 1 to 16777216 cells");
}

/// An outline with a hole, both of thousands of corners, on a million cells: the shares must add up to the
/// area.
#[test]
fn a_long_outline_on_many_cells_has_its_area() {
    let ring = |radius: f64| -> Vec<(f64, f64)> {
        (0..3000)
            .map(|step| {
                let angle = std::f64::consts::TAU * f64::from(step) / 3000.0;
                let wave = radius * (1.0 + 0.05 * (37.0 * angle).sin());
                (5000.0 + wave * angle.cos(), 5000.0 + wave * angle.sin())
            })
            .collect()
    };
    let (outer, inner) = (ring(4760.0), ring(2000.0));
    let started = Instant::now();
    let terrain = read(&polygon_of(&[&outer, &inner]), 10.0).unwrap().terrain;
    println!("{:?} for {} cells", started.elapsed(), terrain.grid().cell_count());
    let square_meters = |ring: &[(f64, f64)]| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>() / 2.0
    };
    let expected = (square_meters(&outer) - square_meters(&inner)) / 100.0;
    let open = f64::from(u32::try_from(terrain.traversable_cells().count()).unwrap());
    assert!((open / expected - 1.0).abs() < 1e-3, "{open} open cells, expected {expected}");
}

fn coordinate() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (0..6_i32).prop_map(|tenths| (f64::from(tenths) / 10.0).to_string()),
        1 => any::<f64>().prop_map(|value| value.to_string()),
    ]
}

proptest! {
    #[test]
    fn any_text_is_read_or_rejected(text in "\\PC{0,60}") {
        let _ = read(&text, 10.0);
    }

    #[test]
    fn any_rings_are_read_or_rejected(
        rings in proptest::collection::vec(
            proptest::collection::vec((coordinate(), coordinate()), 0..7),
            0..4,
        ),
        cell_meters in prop_oneof![Just(1e-9), Just(2_000.0), Just(1e30)],
    ) {
        let ring = |ring: &Vec<(String, String)>| {
            let closed = ring.iter().chain(ring.first()).map(|(x, y)| format!("[{x},{y}]"));
            format!("[{}]", closed.collect::<Vec<_>>().join(","))
        };
        let rings = rings.iter().map(ring).collect::<Vec<_>>().join(",");
        let _ = read(&format!(r#"{{"type":"Polygon","coordinates":[{rings}]}}"#), cell_meters);
        let _ = read(&format!(r#"{{"type":"MultiPolygon","coordinates":[[{rings}],[{rings}]]}}"#), cell_meters);
    }
}
