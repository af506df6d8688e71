//! Where a map lies on the earth, and the areas drawn on it, as a page shows them.

use dragnet_scenario::map_file::{Area, Earth, GeoPoint, Georeference, Purpose, Spread};
use serde::Serialize;

/// A point of the map: meters east and north of its south-western corner.
pub type MapPoint = [f64; 2];

/// Conversion of the map's meters to degrees of WGS84, `[latitude, longitude]`; it is linear.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EarthFrame {
    /// The south-western corner of the map.
    pub corner: [f64; 2],
    /// Degrees per meter along the rows,
    pub east: [f64; 2],
    /// and up the columns.
    pub north: [f64; 2],
}

/// An area or a place drawn on the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaFrame {
    /// Its name.
    pub name: String,
    /// Its kind, as map files name it.
    pub kind: &'static str,
    /// Polygons, each an outer ring and its holes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub polygons: Vec<Vec<Vec<MapPoint>>>,
    /// Lines: those that robots do not cross, and linear features.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<Vec<MapPoint>>,
    /// The place, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<MapPoint>,
    /// Standard deviation of a last known position, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread_meters: Option<f64>,
    /// Distances within which 25, 50, 75 and 95 % are found, meters, of a place or a linear feature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quartiles_meters: Option<[f64; 4]>,
    /// Probability of area, 0 to 1, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poa: Option<f64>,
}

impl EarthFrame {
    /// Of a map's position.
    #[must_use]
    pub fn of(frame: &Georeference) -> Self {
        /// Long enough that rounding of the degrees has no effect.
        const METERS: f64 = 10_000.0;
        let degrees = |point: GeoPoint| [point.latitude_degrees, point.longitude_degrees];
        let corner = degrees(frame.south_west());
        let per_meter = |meters| {
            let there = degrees(frame.point(meters));
            [0, 1].map(|axis| (there[axis] - corner[axis]) / METERS)
        };
        Self { corner, east: per_meter((METERS, 0.0)), north: per_meter((0.0, METERS)) }
    }
}

impl AreaFrame {
    /// The areas drawn on a map.
    #[must_use]
    pub fn all(earth: &Earth) -> Vec<Self> {
        earth.areas.iter().map(|area| Self::of(area, &earth.frame)).collect()
    }

    fn of(area: &Area, frame: &Georeference) -> Self {
        let polygons = area.purpose.polygons().iter().map(|polygon| {
            let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
            rings.map(|ring| ring.coords().map(|&corner| meters(frame, corner.into())).collect()).collect()
        });
        let lines = area.purpose.lines().iter();
        let lines = lines.map(|line| line.coords().map(|&corner| meters(frame, corner.into())).collect());
        let at = match &area.purpose {
            Purpose::LastKnownPosition { point, .. } | Purpose::Start(point) => Some(meters(frame, *point)),
            _ => None,
        };
        let (spread_meters, quartiles_meters) = match &area.purpose {
            Purpose::LastKnownPosition { spread: Spread::Normal(meters), .. } => (Some(*meters), None),
            Purpose::LastKnownPosition { spread: Spread::Quartiles(quartiles), .. }
            | Purpose::LinearFeature { quartiles, .. } => (None, Some(quartiles.meters())),
            _ => (None, None),
        };
        Self {
            name: area.name.clone(),
            kind: area.purpose.word(),
            polygons: polygons.collect(),
            lines: lines.collect(),
            at,
            spread_meters,
            quartiles_meters,
            poa: area.purpose.poa(),
        }
    }
}

/// A point to the decimeter: further digits would only cost bytes.
fn meters(frame: &Georeference, point: GeoPoint) -> MapPoint {
    let (east, north) = frame.meters(point);
    [east, north].map(|meters| (10.0 * meters).round() / 10.0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use dragnet_scenario::map_file::Areas;

    use super::*;

    const AREAS: &str = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"kind":"search","name":"Wood"},
         "geometry":{"type":"Polygon","coordinates":[[[-2.25,49.16],[-2.24,49.16],[-2.24,49.17],[-2.25,49.16]]]}},
        {"type":"Feature","properties":{"kind":"last_known_position","name":"Bench","spread_meters":80,"poa":0.4},
         "geometry":{"type":"Point","coordinates":[-2.245,49.165]}}]}"#;

    fn earth() -> Earth {
        let corner = GeoPoint { latitude_degrees: 49.16, longitude_degrees: -2.25 };
        let areas = Areas::from_geojson(Path::new("a.geojson"), AREAS).unwrap().areas;
        Earth { frame: Georeference::new(corner, 49.165), areas, expected_objects: 1.0 }
    }

    #[test]
    fn the_frame_of_a_page_gives_the_same_degrees_as_the_map() {
        for yaw_radians in [0.0, 0.3] {
            let frame = earth().frame.turned(yaw_radians);
            let EarthFrame { corner, east, north } = EarthFrame::of(&frame);
            let meters = (812.5, 3201.0);
            let point = frame.point(meters);
            let expected = [point.latitude_degrees, point.longitude_degrees];
            for axis in [0, 1] {
                let degrees = corner[axis] + meters.0 * east[axis] + meters.1 * north[axis];
                assert!((degrees - expected[axis]).abs() < 1e-9, "{degrees} {expected:?}");
            }
        }
    }

    #[test]
    fn areas_are_in_meters_of_the_map() {
        let areas = AreaFrame::all(&earth());
        assert_eq!((areas[0].name.as_str(), areas[0].kind), ("Wood", "search"));
        let ring = &areas[0].polygons[0][0];
        assert!(ring.contains(&[0.0, 0.0]), "{ring:?}");
        assert!(ring.iter().any(|&[east, north]| (east - 729.0).abs() < 2.0 && north < 0.1), "{ring:?}");
        assert_eq!((areas[1].poa, areas[1].spread_meters), (Some(0.4), Some(80.0)));
        let [east, north] = areas[1].at.unwrap();
        assert!((east - 364.5).abs() < 1.0 && (north - 556.1).abs() < 1.0, "{east} {north}");
    }
}
