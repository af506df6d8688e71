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
    class: &Class,
    map: &MapFile,
) -> Result<impl Fn(usize) -> Start + use<>, Invalid> {
    let starts = match &table.start {
        Some(field) => vec![of_field("robots.start", field, class, map)?],
        None => drawn(map)
            .into_iter()
            .filter_map(|(_, point)| Some(Start::Cell(nearest(map, point)?.0)))
            .collect(),
    };
    Ok(move |robot: usize| starts.get(robot % starts.len().max(1)).copied().unwrap_or(Start::Together))
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
        StartField::Word(word) if word == "random" => Ok(Start::Together),
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
        assert!(load("", "count = 2").unwrap().robots().iter().all(|robot| robot.start == Start::Together));
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
