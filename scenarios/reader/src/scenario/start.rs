//! Start cells of robots: drawn at random, given as cells, or as points on the earth.

use dragnet_search::cell::{Cell, Position};
use dragnet_search::terrain::Terrain;

use super::check::{self, Invalid};
use super::class::Class;
use super::file::{GeoPointTable, RobotsTable, StartField};
use super::robots::Start;
use super::warning::Warning;
use crate::map_file::areas::Purpose;
use crate::map_file::{GeoPoint, Georeference, MapFile};

const ALLOWED: &str = "\"random\", \"scattered\", a cell as [row, column], or a point as { latitude_degrees, longitude_degrees }";

/// The start of each robot of a team by number, from 0, as far as it has none of its own.
pub(super) fn of_team(
    table: &RobotsTable,
    count: u32,
    class: &Class,
    map: &MapFile,
) -> Result<impl Fn(usize) -> Start + use<>, Invalid> {
    let mut starts = match &table.start {
        Some(field) => vec![of_field("robots.start", field, class, map)?],
        None => drawn(map)
            .into_iter()
            .filter_map(|(_, point)| Some(Start::Cell(nearest(map, point)?.0)))
            .collect(),
    };
    if starts.is_empty() {
        // Robots that fly reach every area from any other.
        let is_spread = count > 1 && !class.flies && map.areas.has_search_area();
        starts = if is_spread { spread(&map.terrain, count) } else { vec![Start::Together { area: 0 }] };
    }
    Ok(move |robot: usize| starts[robot % starts.len()])
}

/// How many times its cells an area without a robot counts: it would not be searched at all, where others take longer.
const ALONE: usize = 10;

/// Starts in the connected areas: each next robot where most cells are for each robot so far. So the first starts in the
/// largest area, and the start of a robot does not depend on how many follow it.
fn spread(terrain: &Terrain, count: u32) -> Vec<Start> {
    // The smaller ones get no robot before each of these has one.
    let areas = terrain.connected_areas().into_iter().take(count as usize);
    let mut robots: Vec<(usize, usize)> = areas.map(|area| (area.len(), 0)).collect();
    // As a fraction, which compares exactly.
    let cells_each =
        |(cells, robots): (usize, usize)| if robots == 0 { (ALONE * cells, 1) } else { (cells, robots) };
    let is_less = |a, b| {
        let ((a, of_a), (b, of_b)) = (cells_each(a), cells_each(b));
        a * of_b < b * of_a
    };
    let mut next = || {
        // Of equal ones the larger, which is the first.
        let area =
            (0..robots.len()).reduce(|best, it| if is_less(robots[best], robots[it]) { it } else { best })?;
        robots[area].1 += 1;
        Some(Start::Together { area })
    };
    (0..count).map_while(|_| next()).collect()
}

/// The start that a field gives to robots of a class.
pub(super) fn of_field(
    key: &str,
    field: &StartField,
    class: &Class,
    map: &MapFile,
) -> Result<Start, Invalid> {
    let terrain = &map.terrain;
    match field {
        StartField::Word(word) if word == "random" => Ok(Start::Together { area: 0 }),
        StartField::Word(word) if word == "scattered" => Ok(Start::Scattered),
        StartField::Word(word) => Err(Invalid::new(key, format!("{word:?}"), ALLOWED)),
        &StartField::Cell(position) => {
            let cell = check::cell(key, position, terrain.grid())?;
            if class.flies || terrain.is_traversable(cell) {
                Ok(Start::Cell(cell))
            } else {
                let found = format!("{position:?}, not traversable");
                Err(Invalid::new(key, found, "a traversable cell"))
            }
        }
        StartField::Point(table) => of_point(key, table, map),
    }
}

fn of_point(key: &str, table: &GeoPointTable, map: &MapFile) -> Result<Start, Invalid> {
    let &GeoPointTable { latitude_degrees, longitude_degrees } = table;
    let found = || format!("latitude {latitude_degrees:?}, longitude {longitude_degrees:?}");
    let Some(frame) = &map.georeference else {
        let allowed = "a cell: the map is not georeferenced; map.origin would place it";
        return Err(Invalid::new(key, found(), allowed));
    };
    let point = GeoPoint::checked(longitude_degrees, latitude_degrees)
        .ok_or_else(|| Invalid::new(key, found(), GeoPoint::ALLOWED))?;
    frame
        .check_near(point)
        .map_err(|far| Invalid::new(key, format!("{}, {far}", found()), Georeference::NEAR))?;
    let nearest =
        nearest(map, point).ok_or_else(|| Invalid::new(key, found(), "a map with a traversable cell"))?;
    Ok(Start::Cell(nearest.0))
}

/// Starts that the map draws, by name.
fn drawn(map: &MapFile) -> Vec<(String, GeoPoint)> {
    let start = |purpose: &Purpose| match purpose {
        Purpose::Start(point) => Some(*point),
        _ => None,
    };
    map.areas
        .areas
        .iter()
        .filter_map(|area| Some((format!("start {:?}", area.name), start(&area.purpose)?)))
        .collect()
}

/// The traversable cell whose center is nearest to a point, and how far that is, meters.
fn nearest(map: &MapFile, point: GeoPoint) -> Option<(Cell, f64)> {
    let (east, north) = map.georeference?.meters(point);
    let terrain = &map.terrain;
    let distance = |cell: Cell| {
        let center = terrain.center_meters(cell);
        (center.0 - east).hypot(center.1 - north)
    };
    let cells = terrain.traversable_cells().map(|cell| (cell, distance(cell)));
    cells.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Starts on the earth that lie in no traversable cell.
pub(super) fn warnings(table: &RobotsTable, map: &MapFile) -> Vec<Warning> {
    let point = |key: String, field: Option<&StartField>| match field {
        Some(StartField::Point(table)) => {
            Some((key, GeoPoint::checked(table.longitude_degrees, table.latitude_degrees)?))
        }
        _ => None,
    };
    let of_team = match &table.start {
        None => drawn(map),
        field => point("robots.start".to_owned(), field.as_ref()).into_iter().collect(),
    };
    let own = table
        .robot
        .iter()
        .filter_map(|robot| point(format!("the start of robot {}", robot.number), robot.start.as_ref()));
    of_team.into_iter().chain(own).filter_map(|(name, point)| moved(name, point, map)).collect()
}

fn moved(name: String, point: GeoPoint, map: &MapFile) -> Option<Warning> {
    let (cell, meters) = nearest(map, point)?;
    let is_inside = is_inside(&map.terrain, cell, map.georeference?.meters(point));
    let Position { row, column } = map.terrain.grid().position(cell);
    (!is_inside).then_some(Warning::MovedStart { name, cell: Position { row, column }, meters })
}

fn is_inside(terrain: &Terrain, cell: Cell, (east, north): (f64, f64)) -> bool {
    let (x, y) = terrain.center_meters(cell);
    let half = terrain.cell_meters() / 2.0;
    (x - east).abs() <= half && (y - north).abs() <= half
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::Scenario;

    /// A square of 1.11 km at the equator: 11 x 11 cells of 100 m, with these features beside it.
    fn load(features: &str, robots: &str) -> Result<Scenario, String> {
        let folder = tempfile::tempdir().unwrap();
        let square = r#"{"type":"Polygon","coordinates":[[[0,0],[0.01,0],[0.01,0.01],[0,0.01],[0,0]]]}"#;
        let area = format!(r#"{{"type":"Feature","properties":{{"kind":"search"}},"geometry":{square}}}"#);
        let text = format!(r#"{{"type":"FeatureCollection","features":[{area}{features}]}}"#);
        fs::write(folder.path().join("area.geojson"), text).unwrap();
        let scenario = format!(
            "name = 'a'\nmap = {{ file = 'area.geojson', cell_meters = 100.0 }}\nobjects.count = 1\n\
             mission.budget_seconds = 60.0\n[robots]\n{robots}\n"
        );
        let path = folder.path().join("a.toml");
        fs::write(&path, scenario).unwrap();
        Scenario::load(&path).map_err(|error| error.to_string())
    }

    fn drawn(name: &str, longitude: f64, latitude: f64) -> String {
        format!(
            r#",{{"type":"Feature","properties":{{"name":"{name}","kind":"start"}},
                "geometry":{{"type":"Point","coordinates":[{longitude},{latitude}]}}}}"#
        )
    }

    fn starts(scenario: &Scenario) -> Vec<[u32; 2]> {
        let position = |start| match start {
            Start::Cell(cell) => {
                let Position { row, column } = scenario.terrain().grid().position(cell);
                [row, column]
            }
            other => panic!("{other:?}"),
        };
        scenario.robots().iter().map(|robot| position(robot.start)).collect()
    }

    #[test]
    fn robots_start_in_turn_where_the_map_says() {
        let posts = drawn("post", 0.0005, 0.0005) + &drawn("hut", 0.0095, 0.0014);
        let scenario = load(&posts, "count = 3").unwrap();
        assert_eq!(starts(&scenario), [[0, 0], [1, 10], [0, 0]]);
        assert_eq!(scenario.warnings(), []);
        assert_eq!(starts(&scenario.with_robots(4).unwrap()).len(), 4);
        // The scenario's own start is stronger, for all or for one.
        let own = load(&posts, "count = 2\nstart = 'scattered'").unwrap();
        assert!(own.robots().iter().all(|robot| robot.start == Start::Scattered));
        let one = load(&posts, "count = 2\nrobot = [{ number = 1, start = [3, 4] }]").unwrap();
        assert_eq!(starts(&one), [[3, 4], [1, 10]]);
        let together = Start::Together { area: 0 };
        assert!(load("", "count = 2").unwrap().robots().iter().all(|robot| robot.start == together));
    }

    /// Beside the square of 11 x 11 cells: one of 5 x 11, and one of 2 x 2.
    const ISLANDS: &str = r#",{"type":"Feature","properties":{"name":"island"},"geometry":{"type":"MultiPolygon",
        "coordinates":[[[[0.02,0],[0.0245,0],[0.0245,0.01],[0.02,0.01],[0.02,0]]],
        [[[0.03,0],[0.0318,0],[0.0318,0.0018],[0.03,0.0018],[0.03,0]]]]}}"#;

    #[test]
    fn without_starts_robots_are_spread_over_the_parts_of_the_area() {
        let areas = |robots: &str| -> Vec<usize> {
            let scenario = load(ISLANDS, robots).unwrap();
            let areas = scenario.terrain().connected_areas();
            assert_eq!(areas.iter().map(Vec::len).collect::<Vec<_>>(), [121, 55, 4]);
            let area = |start| match start {
                Start::Together { area } => area,
                other => panic!("{other:?}"),
            };
            scenario.robots().iter().map(|robot| area(robot.start)).collect()
        };
        assert_eq!(areas("count = 1"), [0]);
        // The most of 121, 55 and 4 cells for each robot so far, tenfold without one: 1210, 550, 121, 121 / 2, 55, 121 / 3, 40.
        assert_eq!(areas("count = 7"), [0, 1, 0, 0, 1, 0, 2]);
        // Told to start together they do.
        assert_eq!(areas("count = 3\nstart = 'random'"), [0; 3]);
        let posts = ISLANDS.to_owned() + &drawn("post", 0.0005, 0.0005);
        assert_eq!(starts(&load(&posts, "count = 2").unwrap()), [[0, 0], [0, 0]]);
        let above =
            "count = 2\nclass = 'drone'\n[classes.drone]\nflies = true\nspeed_meters_per_second = 6.0";
        assert_eq!(areas(above), [0, 0]);
    }

    #[test]
    fn parts_without_a_robot_are_told_with_their_cells() {
        let told = |robots: &str| {
            let scenario = load(ISLANDS, robots).unwrap();
            let said: Vec<String> = scenario.warnings().iter().map(ToString::to_string).collect();
            let parts: Vec<&String> = said.iter().filter(|it| it.contains("no way connects")).collect();
            assert!(parts.len() <= 1 && !said.iter().any(|it| it.contains("no path connects")), "{said:?}");
            parts.first().map(|it| (*it).clone()).unwrap_or_default()
        };
        let one = told("count = 1");
        assert!(
            one.starts_with(
                "the area is in 3 parts that no way connects; 2 have no robot, of 55 and 4 cells"
            ),
            "{one}"
        );
        assert!(
            one.contains("a start drawn in each") && one.ends_with("; 1 robot starts in that of 121 cells"),
            "{one}"
        );
        let three = told("count = 3");
        assert!(three.contains("3 parts that no way connects; 1 has no robot, of 4 cells"), "{three}");
        assert!(three.ends_with("; 2 robots start in that of 121 cells, 1 in that of 55"), "{three}");
        // The smallest is seen from its neighbor, and all are seen from above.
        assert_eq!(
            told("count = 2\n[sensor]\nradius = 11"),
            "the area is in 2 parts that no way connects; 1 robot starts in that of 121 cells, 1 in that of 55"
        );
        assert_eq!(
            told("count = 2\nclass = 'drone'\n[classes.drone]\nflies = true\nspeed_meters_per_second = 6.0"),
            ""
        );
    }

    #[test]
    fn a_start_beside_the_map_is_the_nearest_cell_and_told() {
        let scenario = load(&drawn("post", -0.002, 0.0005), "count = 2").unwrap();
        assert_eq!(starts(&scenario), [[0, 0], [0, 0]]);
        let said: Vec<String> = scenario.warnings().iter().map(ToString::to_string).collect();
        assert!(
            said.len() == 1 && said[0].contains("\"post\"") && said[0].contains("[0, 0], 27"),
            "{said:?}"
        );
        let point = |latitude: f64| {
            format!("start = {{ latitude_degrees = {latitude:?}, longitude_degrees = 0.0051 }}")
        };
        assert_eq!(starts(&load("", &point(0.0095)).unwrap()), [[10, 5]]);
        let said = load("", &point(0.02)).unwrap().warnings()[0].to_string();
        assert!(said.contains("robots.start"), "{said}");
    }

    #[test]
    fn a_start_that_is_no_place_near_the_map_is_an_error() {
        let refuse = |features: &str, robots: &str, parts: &[&str]| {
            let error = load(features, robots).unwrap_err();
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        };
        let start =
            |latitude: &str| format!("start = {{ latitude_degrees = {latitude}, longitude_degrees = 0.0 }}");
        refuse("", &start("5.0"), &["robots.start", "km away", "100 km"]);
        refuse("", &start("nan"), &["robots.start", "-85 to 85"]);
        refuse("", "start = { latitude_degrees = 0.0 }", &["robots.start", "longitude_degrees"]);
        let area = r#",{"type":"Feature","properties":{"kind":"start"},"geometry":{"type":"LineString","coordinates":[[0,0],[0.001,0]]}}"#;
        refuse(area, "count = 1", &["start", "one point"]);
        let likely = drawn("post", 0.001, 0.001).replace("\"kind\"", "\"poa\":0.5,\"kind\"");
        refuse(&likely, "count = 1", &["poa", "none with start"]);
        refuse(&drawn("swapped", 47.0, 11.0), "count = 1", &["swapped", "km away", "100 km"]);
    }
}
