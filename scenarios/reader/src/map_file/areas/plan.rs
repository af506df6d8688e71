//! The geofence of a plan of `QGroundControl` (`.plan`, version 1, with a geofence of version 2) as areas: inclusion polygons are
//! search areas, exclusion polygons no-go areas. Its mission and its rally points are not read.

use std::path::Path;

use serde::Deserialize;

use super::feature::{Facts, Feature, Position};
use super::kind::{NO_GO, SEARCH};
use crate::map_file::MapFileError;

const FILE_TYPE: &str = "Plan";
const VERSION: i64 = 1;
const FENCE_VERSION: i64 = 2;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct PlanFile {
    file_type: String,
    version: i64,
    geo_fence: Option<GeoFence>,
}

#[derive(Deserialize)]
struct GeoFence {
    version: i64,
    #[serde(default)]
    polygons: Vec<Polygon>,
    #[serde(default)]
    circles: Vec<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
struct Polygon {
    inclusion: bool,
    /// Corners, `[latitude, longitude]`, of which the last is not the first again.
    polygon: Vec<[f64; 2]>,
}

pub(super) fn features(file: &Path, text: &str) -> Result<Vec<Feature>, MapFileError> {
    let plan: PlanFile = serde_json::from_str(text)
        .map_err(|error| MapFileError::syntax(file, format!("no plan of QGroundControl: {error}")))?;
    if plan.file_type != FILE_TYPE {
        let found = format!("{:?}", plan.file_type.chars().take(40).collect::<String>());
        return Err(MapFileError::value(file, "fileType", found, "\"Plan\""));
    }
    check_version(file, "version", plan.version, VERSION)?;
    let Some(fence) = plan.geo_fence else {
        let allowed = "a geofence with an inclusion polygon, which becomes the search area";
        return Err(MapFileError::value(file, "geoFence", "missing", allowed));
    };
    check_version(file, "geoFence.version", fence.version, FENCE_VERSION)?;
    if !fence.circles.is_empty() {
        let found = format!("{} of them", fence.circles.len());
        return Err(MapFileError::value(file, "geoFence.circles", found, "none: draw polygons instead"));
    }
    Ok((1..).zip(fence.polygons).map(|(number, polygon)| feature(number, &polygon)).collect())
}

fn check_version(file: &Path, key: &str, found: i64, allowed: i64) -> Result<(), MapFileError> {
    if found == allowed {
        return Ok(());
    }
    let allowed = format!("{allowed}, as current versions of QGroundControl write it");
    Err(MapFileError::value(file, key, found, allowed))
}

fn feature(number: usize, Polygon { inclusion, polygon }: &Polygon) -> Feature {
    let mut feature = Feature::at(&format!("fence polygon {number}"), None);
    feature.facts.add_property(Facts::KIND, if *inclusion { SEARCH } else { NO_GO });
    let corners = polygon.iter().chain(polygon.first());
    let ring: Vec<Position> = corners.map(|&[latitude, longitude]| vec![longitude, latitude]).collect();
    feature.shapes.polygons.push(vec![ring]);
    feature
}

#[cfg(test)]
mod tests {
    use super::super::{Areas, Purpose};
    use super::*;
    use crate::mentions::assert_mentions;

    /// A plan as the developer guide of `QGroundControl` defines it, with all parts.
    const PLAN: &str = r#"{
    "fileType": "Plan",
    "geoFence": {
        "circles": [
        ],
        "polygons": [
            {
                "inclusion": true,
                "polygon": [
                    [ 49.241, -2.241 ],
                    [ 49.241, -2.231 ],
                    [ 49.236, -2.231 ],
                    [ 49.236, -2.241 ]
                ],
                "version": 1
            },
            {
                "inclusion": false,
                "polygon": [
                    [ 49.239, -2.238 ],
                    [ 49.239, -2.236 ],
                    [ 49.238, -2.237 ]
                ],
                "version": 1
            }
        ],
        "version": 2
    },
    "groundStation": "QGroundControl",
    "mission": {
        "cruiseSpeed": 15,
        "firmwareType": 12,
        "globalPlanAltitudeMode": 1,
        "hoverSpeed": 5,
        "items": [
            {
                "AMSLAltAboveTerrain": null,
                "Altitude": 50,
                "AltitudeMode": 1,
                "autoContinue": true,
                "command": 22,
                "doJumpId": 1,
                "frame": 3,
                "params": [ 15, 0, 0, null, 49.24, -2.24, 50 ],
                "type": "SimpleItem"
            }
        ],
        "plannedHomePosition": [ 49.24, -2.24, 60 ],
        "vehicleType": 2,
        "version": 2
    },
    "rallyPoints": {
        "points": [ [ 49.24, -2.24, 50 ] ],
        "version": 2
    },
    "version": 1
}
"#;

    fn read(text: &str) -> Result<Areas, String> {
        Areas::from_bytes(Path::new("a.plan"), text.as_bytes().to_vec()).map_err(|error| error.to_string())
    }

    #[test]
    fn inclusion_fences_are_searched_and_exclusion_fences_are_not_entered() {
        let Areas { areas, left_out, .. } = read(PLAN).unwrap();
        assert_eq!(left_out, [""; 0]);
        let [search, no_go] = &areas[..] else { panic!("{areas:?}") };
        assert_eq!((search.name.as_str(), no_go.name.as_str()), ("fence polygon 1", "fence polygon 2"));
        let corners = |purpose: &Purpose| purpose.polygons()[0].exterior().0.clone();
        let first = corners(&search.purpose)[0];
        assert!((first.x + 2.241).abs() < 1e-12 && (first.y - 49.241).abs() < 1e-12, "{first:?}");
        assert_eq!(corners(&search.purpose).len(), 5);
        assert!(matches!(search.purpose, Purpose::Search(_)) && matches!(no_go.purpose, Purpose::NoGo(..)));
    }

    #[test]
    fn a_plan_is_a_map_with_its_position() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.plan");
        std::fs::write(&file, PLAN).unwrap();
        let map = crate::map_file::MapFile::load(&file, 30.0).unwrap();
        let cells = map.terrain.grid().cells();
        let searched = cells.clone().filter(|&cell| map.terrain.is_searched(cell)).count();
        let closed = cells.filter(|&cell| !map.terrain.is_traversable(cell)).count();
        // 728 m by 556 m, and a triangle of half of 146 m by 111 m, with every cell that it touches.
        assert!((430..=500).contains(&searched), "{searched}");
        assert!((10..=40).contains(&closed), "{closed}");
        assert!(map.georeference.is_some());
    }

    #[test]
    fn what_is_no_area_is_rejected() {
        let check = |from: &str, to: &str, message: &str| {
            assert_mentions(&read(&PLAN.replace(from, to)).unwrap_err(), message);
        };
        check("\"Plan\"", "\"Mission\"", "a.plan: fileType is \"Mission\"; allowed is \"Plan\"");
        check("    \"version\": 1\n}", "    \"version\": 2\n}", "a.plan: version is 2; allowed is 1");
        check(
            "        \"version\": 2\n    },\n    \"ground",
            "\"version\": 1\n    },\n    \"ground",
            "geoFence.version is 1",
        );
        let circle = r#""circles": [ { "circle": { "center": [ 1, 2 ], "radius": 20 }, "inclusion": false, "version": 1 } "#;
        check("\"circles\": [", circle, "geoFence.circles is 1 of them; allowed is none: draw polygons");
        check("\"geoFence\"", "\"fence\"", "geoFence is missing .. an inclusion polygon");
        check("[ 49.238, -2.237 ]", "[ 49.238 ]", "no plan of QGroundControl .. line 22");
        check("[ 49.238, -2.237 ]", "[ 149.238, -2.237 ]", "fence polygon 2 .. 149.238");
        check("\"inclusion\": true,", "", "no plan of QGroundControl .. inclusion");
        assert_mentions(&read("[]").unwrap_err(), "no plan of QGroundControl");
        assert_mentions(&read(&PLAN[..400]).unwrap_err(), "no plan of QGroundControl .. EOF");
    }
}
