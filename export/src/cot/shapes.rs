//! Drawn areas and no-go zones as shapes and markers of maps.

use dragnet_scenario::map_file::{Area, GeoPoint, Purpose};
use geo::{LineString, Polygon, Simplify};

use super::event::{Color, Detail};

/// The most corners of a shape: with more the event would not go into a few packets of a radio.
const MAX_CORNERS: usize = 150;
/// Deviation from which outlines with more corners are simplified, degrees: about a meter. It doubles until they have few.
const FINEST_DEGREES: f64 = 1e-5;

const BLUE: Color = Color(0xff00_66ff);
const RED: Color = Color(0xffff_0000);
const VIOLET: Color = Color(0xff99_33ff);

/// An area, or a part of one, on a map.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shape {
    /// Its number within the mission, such as `area-2-1`.
    pub name: String,
    pub kind: &'static str,
    pub point: GeoPoint,
    pub detail: Detail,
}

/// The shapes of areas, whose names begin with a word. Holes are left out: shapes of maps have none.
pub(super) fn shapes(word: &str, areas: &[Area]) -> Vec<Shape> {
    (1..).zip(areas).flat_map(|(number, area)| parts(&format!("{word}-{number}"), area)).collect()
}

fn parts(name: &str, area: &Area) -> Vec<Shape> {
    let percent = |poa: f64| format!("probability of area {:.1} %", 100.0 * poa);
    let (remarks, color) = match &area.purpose {
        Purpose::Search(_) => ("search area".to_owned(), BLUE),
        Purpose::NoGo(..) => ("no-go area: no robot enters it".to_owned(), RED),
        Purpose::Prior { poa, .. } => (percent(*poa), VIOLET),
        Purpose::LinearFeature { poa, .. } => (format!("linear feature, {}", percent(*poa)), VIOLET),
        Purpose::LastKnownPosition { point, poa, .. } => {
            let remarks = format!("last known position, {}", percent(*poa));
            let detail = Detail::Marker { callsign: area.name.clone(), remarks, color: VIOLET };
            return vec![Shape { name: name.to_owned(), kind: "b-m-p-s-m", point: *point, detail }];
        }
        Purpose::Start(_) => return Vec::new(),
    };
    let outlines = area.purpose.polygons().iter().map(Polygon::exterior).chain(area.purpose.lines());
    let shape = |(part, line): (usize, &LineString<f64>)| {
        let corners = corners(line);
        let point = *corners.first()?;
        let detail = Detail::Shape { callsign: area.name.clone(), remarks: remarks.clone(), color, corners };
        Some(Shape { name: format!("{name}-{part}"), kind: "u-d-f", point, detail })
    };
    (1..).zip(outlines).filter_map(shape).collect()
}

/// The corners of a line, simplified if there are many.
fn corners(line: &LineString<f64>) -> Vec<GeoPoint> {
    let (mut few, mut degrees) = (line.clone(), FINEST_DEGREES);
    while few.0.len() > MAX_CORNERS {
        few = line.simplify(degrees);
        degrees *= 2.0;
    }
    few.0.into_iter().map(GeoPoint::from).collect()
}

#[cfg(test)]
mod tests {
    use geo::{MultiLineString, MultiPolygon};

    use super::*;

    fn ring(corners: usize, radius_degrees: f64) -> Polygon<f64> {
        let corner = |number: usize| {
            let angle = std::f64::consts::TAU * number as f64 / corners as f64;
            (9.5 + radius_degrees * angle.cos(), 47.5 + radius_degrees * angle.sin())
        };
        Polygon::new((0..corners).map(corner).collect(), Vec::new())
    }

    #[test]
    fn each_polygon_and_line_of_an_area_is_a_shape_of_few_corners() {
        let wood = MultiPolygon::new(vec![ring(4, 0.01), ring(3000, 0.02)]);
        let fence = MultiLineString::new(vec![LineString::from(vec![(9.5, 47.5), (9.6, 47.5)])]);
        let areas = [
            Area { name: "Wood".to_owned(), purpose: Purpose::Search(wood) },
            Area {
                name: "Hut".to_owned(),
                purpose: Purpose::Start(GeoPoint::from(geo::coord! { x: 9.5, y: 47.5 })),
            },
            Area {
                name: "Cliff".to_owned(),
                purpose: Purpose::NoGo(MultiPolygon::new(vec![ring(3, 0.001)]), fence),
            },
        ];
        let shapes = shapes("area", &areas);
        let corners = |shape: &Shape| match &shape.detail {
            Detail::Shape { corners, .. } => {
                (corners.len(), corners.first() == corners.last(), corners[0] == shape.point)
            }
            other => panic!("{other:?}"),
        };
        let seen: Vec<_> = shapes.iter().map(|it| (it.name.as_str(), corners(it))).collect();
        let [first, large, cliff, fence] = seen[..] else { panic!("{seen:?}") };
        assert_eq!(first, ("area-1-1", (5, true, true)));
        assert_eq!((cliff, fence), (("area-3-1", (4, true, true)), ("area-3-2", (2, false, true))));
        let (name, (count, is_closed, _)) = large;
        assert!(name == "area-1-2" && is_closed && (50..=MAX_CORNERS).contains(&count), "{large:?}");
    }
}
