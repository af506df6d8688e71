//! Validation of rings and lines: closed, on the earth, and without crossings.
//!
//! The rules are those of geo's `Validation`, which compares each segment with each other: 50 s for 19,000 corners. Here
//! an index says which may cross.

use std::path::Path;

use geo::coordinate_position::CoordPos;
use geo::dimensions::Dimensions;
use geo::line_intersection::{LineIntersection, line_intersection};
use geo::{
    BoundingRect, Coord, Intersects, Line, LineString, MultiPolygon, Polygon, PreparedGeometry, Relate,
    RemoveRepeatedPoints,
};
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::feature::Position;
use crate::map_file::{GeoPoint, MapFileError};

/// Valid polygons; messages number them within the feature.
pub(super) fn polygons(
    file: &Path,
    place: &str,
    polygons: &[Vec<Vec<Position>>],
) -> Result<MultiPolygon<f64>, MapFileError> {
    let numbered = (1..).zip(polygons);
    numbered.map(|(number, rings)| polygon(file, &format!("{place}, polygon {number}"), rings)).collect()
}

fn polygon(file: &Path, place: &str, rings: &[Vec<Position>]) -> Result<Polygon<f64>, MapFileError> {
    let numbered = (1..).zip(rings);
    let mut read = numbered.map(|(number, ring)| closed(file, &format!("{place}, ring {number}"), ring));
    let Some(exterior) = read.next().transpose()? else {
        return Err(MapFileError::value(file, place, "without a ring", "an outer ring, and holes in it"));
    };
    let polygon = Polygon::new(exterior, read.collect::<Result<_, _>>()?);
    match fault(&polygon) {
        Some(fault) => {
            let allowed = "rings that neither cross themselves nor each other, with holes inside";
            Err(MapFileError::value(file, place, fault, allowed))
        }
        None => Ok(polygon),
    }
}

/// What is wrong with a polygon, if anything.
fn fault(polygon: &Polygon<f64>) -> Option<String> {
    let holes = polygon.interiors();
    for (number, ring) in std::iter::once(polygon.exterior()).chain(holes).enumerate() {
        if ring.remove_repeated_points().0.len() < 4 {
            return Some(format!("not an area: ring {} has fewer than 3 corners", number + 1));
        }
        if let Some(Coord { x, y }) = crossing(ring) {
            return Some(format!(
                "not an area: ring {} crosses or touches itself at [{x:.6}, {y:.6}]",
                number + 1
            ));
        }
    }
    let alone = |ring: &LineString<f64>| Polygon::new(ring.clone(), Vec::new());
    let outer = alone(polygon.exterior());
    let outer = PreparedGeometry::from(&outer);
    let holes: Vec<Polygon<f64>> = holes.iter().map(alone).collect();
    let bounds: Vec<_> = holes.iter().map(BoundingRect::bounding_rect).collect();
    for (number, hole) in holes.iter().enumerate() {
        let relation = outer.relate(hole);
        let border = relation.get(CoordPos::OnBoundary, CoordPos::OnBoundary);
        if !relation.is_contains() || border == Dimensions::OneDimensional {
            return Some(format!("not an area: its hole, ring {}, is not inside", number + 2));
        }
        for other in number + 1..holes.len() {
            let is_near = bounds[number].zip(bounds[other]).is_some_and(|(a, b)| a.intersects(&b));
            if is_near && do_overlap(hole, &holes[other]) {
                return Some(format!(
                    "not an area: its holes, rings {} and {}, overlap",
                    number + 2,
                    other + 2
                ));
            }
        }
    }
    None
}

/// Whether two share ground, or more than points of their borders.
fn do_overlap(a: &Polygon<f64>, b: &Polygon<f64>) -> bool {
    let relation = a.relate(b);
    relation.get(CoordPos::Inside, CoordPos::Inside) == Dimensions::TwoDimensional
        || relation.get(CoordPos::OnBoundary, CoordPos::OnBoundary) == Dimensions::OneDimensional
}

/// A place where a ring crosses or touches itself.
fn crossing(ring: &LineString<f64>) -> Option<Coord<f64>> {
    let segments = ring.lines().enumerate().map(|(number, line)| GeomWithData::new(line, number));
    let index = RTree::bulk_load(segments.collect());
    let is_crossed = |a: &Line<f64>, b: &Line<f64>| {
        let is_next = a.start == b.end || a.end == b.start;
        !is_next && a.intersects(b)
    };
    // Each pair comes twice.
    let (a, b) = index
        .intersection_candidates_with_other_tree(&index)
        .find(|(a, b)| a.data < b.data && is_crossed(a.geom(), b.geom()))?;
    Some(match line_intersection(*a.geom(), *b.geom()) {
        Some(LineIntersection::SinglePoint { intersection, .. }) => intersection,
        Some(LineIntersection::Collinear { intersection }) => intersection.start,
        None => a.geom().start,
    })
}

fn closed(file: &Path, place: &str, ring: &[Position]) -> Result<LineString<f64>, MapFileError> {
    let ring = corners(file, place, ring)?;
    if ring.len() >= 4 && ring.first() == ring.last() {
        return Ok(LineString(ring));
    }
    let open = if ring.first() == ring.last() { "" } else { ", and it is not closed" };
    let found = format!("a ring of {} positions{open}", ring.len());
    let allowed = "a ring of at least 4 positions, the last one equal to the first";
    Err(MapFileError::value(file, place, found, allowed))
}

/// A line of at least two corners.
pub(super) fn line(file: &Path, place: &str, line: &[Position]) -> Result<LineString<f64>, MapFileError> {
    let corners = corners(file, place, line)?;
    if corners.len() >= 2 {
        return Ok(LineString(corners));
    }
    Err(MapFileError::value(file, place, format!("a line of {} positions", corners.len()), "at least 2"))
}

fn corners(file: &Path, place: &str, positions: &[Position]) -> Result<Vec<Coord<f64>>, MapFileError> {
    let numbered = (1..).zip(positions);
    numbered
        .map(|(number, position)| corner(file, &format!("{place}, position {number}"), position))
        .collect()
}

pub(super) fn corner(file: &Path, place: &str, position: &Position) -> Result<Coord<f64>, MapFileError> {
    if let &[x, y, ..] = position.as_slice()
        && GeoPoint::checked(x, y).is_some()
    {
        return Ok(Coord { x, y });
    }
    let allowed = "[longitude, latitude] in degrees, -180 to 180 and -85 to 85";
    Err(MapFileError::value(file, place, format!("{position:?}"), allowed))
}
