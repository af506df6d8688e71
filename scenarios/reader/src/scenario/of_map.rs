//! A scenario for a map alone: what the map does not say is assumed.

use std::path::Path;

use dragnet_search::cell::Grid;
use dragnet_search::sensor::Sensor;

use crate::map_file::areas::Rest;
use crate::map_file::{Areas, Format, MapFile, grids_of_areas, grids_of_ros_map};

/// Edges of cells to choose from, meters, longest first.
const CELL_METERS: [f64; 15] =
    [2000.0, 1000.0, 500.0, 300.0, 200.0, 100.0, 50.0, 30.0, 20.0, 10.0, 5.0, 3.0, 2.0, 1.0, 0.5];
/// The shortest edge for areas on the earth: satellites place robots no better.
const SHORTEST_ON_EARTH_METERS: f64 = 1.0;
/// The longer side of the map, cells: the shortest edge is taken that gives no more.
const LONGEST_SIDE: u32 = 80;
/// The edge for a map that has a cell for each of its characters, and for one that cannot be read; as in scenarios.
const USUAL_CELL_METERS: f64 = 30.0;
/// The most characters of a name.
const LONGEST_NAME: usize = 64;

/// Whether a path has an extension of a map, and not of a scenario.
pub(super) fn is_map(path: &Path) -> bool {
    Format::of(path).is_some()
}

/// The text of a scenario for a map; `file` is the map's path as the scenario is to name it.
pub(super) fn text(map: &Path, file: &str) -> String {
    let areas = (Format::of(map) == Some(Format::Areas)).then(|| Areas::load(map).ok()).flatten();
    match areas {
        Some(areas) => text_of_areas(&areas, &name(map), file),
        None => text_with(&name(map), file, cells(map), 0.0),
    }
}

/// The text of a scenario of this name for areas, which it names as `file`.
pub(super) fn text_of_areas(areas: &Areas, name: &str, file: &str) -> String {
    let cells = cells_of_areas(areas).unwrap_or((USUAL_CELL_METERS, Sensor::DEFAULT_RADIUS));
    text_with(name, file, cells, beyond(areas, cells.0).unwrap_or_default())
}

/// The probability that the regions leave beyond the map: 0 unless they cover all searched cells.
fn beyond(areas: &Areas, cell_meters: f64) -> Option<f64> {
    if areas.areas.iter().all(|area| area.purpose.poa().is_none()) {
        // Without regions nothing is left, and no map need be made.
        return None;
    }
    let map = MapFile::of_areas(Path::new(""), areas.clone(), cell_meters).ok()?;
    let prior = areas.prior(Path::new(""), map.georeference.as_ref()?, &map.terrain, 1.0).ok()??;
    let Rest { poa, cells } = prior.claims.rest;
    // Written as people would.
    (cells == 0).then_some((1e6 * poa).round() / 1e6)
}

fn text_with(name: &str, file: &str, (cell_meters, side): (f64, u32), rest_of_world: f64) -> String {
    let radius = Sensor::DEFAULT_RADIUS.min(side);
    let file = toml::Value::String(file.to_owned());
    format!(
        "# Made for a map alone: all but map.file is assumed. `dragnet schema` describes all keys.\n\
         name = \"{name}\"\n\n\
         [map]\n\
         file = {file}\n\
         cell_meters = {cell_meters:?}\n\n\
         [sensor]\n\
         # In cells.\n\
         radius = {radius}\n\n\
         [objects]\n\
         count = 1\n\n\
         [prior]\n\
         # The probability that the object is outside of the search area: a find ends the search.\n\
         rest_of_world = {rest_of_world:?}\n\n\
         [robots]\n\
         count = 1\n\
         policy = \"tour\"\n\n\
         [mission]\n\
         # Six hours.\n\
         budget_seconds = 21600.0\n"
    )
}

/// The edge of the cells of a map without areas, meters, and how many the map's longer side then has.
fn cells(map: &Path) -> (f64, u32) {
    let chosen = if Format::of(map) == Some(Format::Ros) {
        grids_of_ros_map(map).ok().and_then(|grid| shortest(|cell_meters| grid(cell_meters).map(side)))
    } else {
        // Each cell is a character of the file.
        let map = MapFile::load(map, USUAL_CELL_METERS).ok();
        map.map(|map| (USUAL_CELL_METERS, side(map.terrain.grid())))
    };
    chosen.unwrap_or((USUAL_CELL_METERS, Sensor::DEFAULT_RADIUS))
}

/// The same for areas; `None` if they make no map.
pub(super) fn cells_of_areas(areas: &Areas) -> Option<(f64, u32)> {
    let grid = grids_of_areas(areas)?;
    shortest(|cell_meters| {
        let is_allowed = cell_meters >= SHORTEST_ON_EARTH_METERS;
        is_allowed.then(|| grid(cell_meters))?.map(side)
    })
}

/// The cells of a grid's longer side.
fn side(grid: Grid) -> u32 {
    grid.rows().max(grid.columns())
}

/// The shortest edge that gives a longer side of no more than [`LONGEST_SIDE`] cells, and that side.
fn shortest(side: impl Fn(f64) -> Option<u32>) -> Option<(f64, u32)> {
    let of = |cell_meters| Some((cell_meters, side(cell_meters)?));
    let mut from_longest = CELL_METERS.into_iter().map_while(of);
    let mut chosen = from_longest.next()?;
    for shorter in from_longest.take_while(|&(_, side)| side <= LONGEST_SIDE) {
        chosen = shorter;
    }
    Some(chosen)
}

/// The name of a scenario for a map.
pub(super) fn name(map: &Path) -> String {
    let is_allowed = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-');
    let name: String = map
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .chars()
        .take(LONGEST_NAME)
        .map(|letter| if is_allowed(letter) { letter } else { '_' })
        .collect();
    if name.is_empty() { "search".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use dragnet_search::subjects::Subjects;

    use super::*;
    use crate::Scenario;

    fn shipped(map: &str) -> std::path::PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../maps").join(map)
    }

    #[test]
    fn a_map_alone_is_a_scenario() {
        for map in ["missing_person.kml", "jersey.geojson", "warehouse.yaml"] {
            let scenario = Scenario::load(&shipped(map)).unwrap();
            assert!(scenario.is_of_map(), "{map}");
            let grid = scenario.terrain().grid();
            let side = grid.rows().max(grid.columns());
            assert!((LONGEST_SIDE / 3..=LONGEST_SIDE).contains(&side), "{map}: {grid:?}");
            assert_eq!(scenario.robots().len(), 1);
            assert_eq!(scenario.subjects(), Subjects::new(1, 0.0), "{map}: a find ends the search");
        }
        let drawn = tempfile::tempdir().unwrap();
        let map = drawn.path().join("The moor (west).txt");
        fs::write(&map, "....\n.##.\n....\n").unwrap();
        let scenario = Scenario::load(&map).unwrap();
        assert_eq!(scenario.name(), "The_moor__west_");
        assert!((scenario.terrain().cell_meters() - USUAL_CELL_METERS).abs() < f64::EPSILON);
    }

    /// Regions that leave some of the probability to no cell say where else the object may be.
    #[test]
    fn what_regions_leave_beyond_the_map_is_elsewhere() {
        let square = "[[[2,49],[2.01,49],[2.01,49.01],[2,49.01],[2,49]]]";
        let west = "[[[2,49],[2.005,49],[2.005,49.01],[2,49.01],[2,49]]]";
        let elsewhere = |region: &str| {
            let feature = |kind: &str, ring: &str| {
                format!(
                    r#"{{"type":"Feature","properties":{{{kind}}},"geometry":{{"type":"Polygon","coordinates":{ring}}}}}"#
                )
            };
            let features =
                [feature(r#""kind":"search""#, square), feature(r#""kind":"prior","poa":0.8"#, region)];
            let folder = tempfile::tempdir().unwrap();
            let map = folder.path().join("a.geojson");
            fs::write(&map, format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")))
                .unwrap();
            Scenario::load(&map).unwrap().subjects()
        };
        assert_eq!(elsewhere(square), Subjects::new(1, 0.2));
        assert_eq!(elsewhere(west), Subjects::new(1, 0.0));
    }

    /// Areas reach up to 100 km.
    #[test]
    fn the_largest_area_has_no_longer_side_than_others() {
        let strip =
            r#"{"type":"Polygon","coordinates":[[[10,50],[11.25,50],[11.25,50.1],[10,50.1],[10,50]]]}"#;
        let (cell_meters, side) =
            cells_of_areas(&Areas::from_geojson(Path::new("a.geojson"), strip).unwrap()).unwrap();
        assert!((cell_meters - 2000.0).abs() < f64::EPSILON && (40..=LONGEST_SIDE).contains(&side), "{side}");
    }

    #[test]
    fn areas_in_memory_are_the_scenario_of_their_file() {
        for map in ["missing_person.kml", "jersey.geojson"] {
            let (path, loaded) = (shipped(map), Scenario::load(&shipped(map)).unwrap());
            let areas = Areas::from_bytes(&path, fs::read(&path).unwrap()).unwrap();
            let text = Scenario::text_of_areas(&areas, loaded.name(), map);
            let of_areas = Scenario::from_text_and_areas(&path, text, areas.clone()).unwrap();
            assert_eq!((of_areas.file(), of_areas.map()), (loaded.file(), loaded.map()));
            let refused = |map: &str| {
                let text = format!(
                    "name = 'a'\nmap = {{ {map} }}\nobjects.count = 1\nmission.budget_meters = 1.0\n"
                );
                Scenario::from_text_and_areas(&path, text, areas.clone()).unwrap_err().to_string()
            };
            assert!(refused("shape = 'all_traversable', rows = 1, columns = 1").contains("a file of areas"));
            assert!(refused("file = 'a.kml', rows = 1").contains("map.rows"));
        }
        assert_eq!(Scenario::cells_of_areas(&Areas::default()), None);
        let refused = |file: &str, bytes: &[u8]| {
            Areas::from_bytes(Path::new(file), bytes.to_vec()).unwrap_err().to_string()
        };
        assert!(refused("a.png", b"").contains("a.png: unknown extension"));
        assert!(refused("a.kml", &[0xff, 0xfe, 0xff]).contains("a.kml"));
        let long = vec![b' '; usize::try_from(Areas::MAX_BYTES).unwrap() + 1];
        assert!(refused("a.kml", &long).contains("at most 16777216"));
    }

    #[test]
    fn a_map_that_cannot_be_read_says_why() {
        let error = Scenario::load(Path::new("nowhere.kml")).unwrap_err().to_string();
        assert!(error.contains("nowhere.kml"), "{error}");
        let folder = tempfile::tempdir().unwrap();
        let map = folder.path().join("a.kml");
        fs::write(&map, "<kml/>").unwrap();
        let error = Scenario::load(&map).unwrap_err().to_string();
        // No line of a text that nobody has written.
        assert!(error.matches("a.kml").count() == 1 && !error.contains("line 5"), "{error}");
        let error = Scenario::load(Path::new("a.kmz")).unwrap_err().to_string();
        assert!(error.contains("a.kmz: "), "{error}");
    }
}
