//! Validation of rings and lines: closed, on the earth, and without crossings.
//!
//! The rules are those of geo's `Validation`, which compares each segment with each other: 50 s for 19,000 corners. Here
//! an index says which may cross.

use std::path::Path;

use geo::coordinate_position::CoordPos;
use geo::dimensions::Dimensions;
use geo::line_intersection::{LineIntersection, line_intersection};
use geo::{
    Area, BooleanOps, BoundingRect, Coord, CoordsIter, Intersects, Line, LineString, LinesIter, MultiPolygon,
    Point, Polygon, PreparedGeometry, Relate, RemoveRepeatedPoints,
};
use rstar::primitives::GeomWithData;
use rstar::{PointDistance, RTree};

use super::feature::Position;
use crate::map_file::union::{overlapping_pairs, union};
use crate::map_file::{GeoPoint, MapFileError};

/// The greatest share of a polygon's area that mending it may change.
const MENDED_SHARE: f64 = 1e-3;
/// What computing with coordinates may change, as a share of a length.
const ROUNDING: f64 = 1e-9;
/// What the union of polygons may change, which rounds to a grid, as a share of a length or of an area.
const UNION_ROUNDING: f64 = 1e-7;

/// Valid polygons that share no ground; messages number them within the feature. The faults of those that were mended, or left out since they
/// hold no ground beside others, are added to `mended`.
pub(super) fn polygons(
    file: &Path,
    place: &str,
    polygons: &[Vec<Vec<Position>>],
    mended: &mut Vec<String>,
) -> Result<MultiPolygon<f64>, MapFileError> {
    let (mut valid, mut faults) = (Vec::new(), Vec::new());
    for (number, rings) in (1..).zip(polygons) {
        let place = format!("{place}, polygon {number}");
        let drawn = polygon(file, &place, rings)?;
        let Some(fault) = fault(&drawn) else {
            valid.push(drawn);
            continue;
        };
        let Some(parts) = parts(&drawn) else { return Err(no_area(file, &place, &fault)) };
        let is_lossless = is_lossless(&drawn, &parts);
        valid.extend(parts);
        if !is_lossless {
            faults.push((place, fault));
        }
    }
    match faults.first() {
        Some((place, fault)) if valid.is_empty() => return Err(no_area(file, place, fault)),
        _ => mended.extend(faults.into_iter().map(|(place, fault)| format!("{place}: {fault}"))),
    }
    let grounds: Vec<&Polygon<f64>> = valid.iter().collect();
    // All that follows counts by the even-odd rule.
    let is_shared = !overlapping_pairs(&grounds).is_empty();
    Ok(if is_shared { union(&grounds) } else { MultiPolygon(valid) })
}

fn no_area(file: &Path, place: &str, fault: &str) -> MapFileError {
    let allowed = "rings that neither cross themselves nor each other, with holes inside";
    MapFileError::value(file, place, format!("not an area: {fault}"), allowed)
}

fn polygon(file: &Path, place: &str, rings: &[Vec<Position>]) -> Result<Polygon<f64>, MapFileError> {
    let numbered = (1..).zip(rings);
    let mut read = numbered.map(|(number, ring)| closed(file, &format!("{place}, ring {number}"), ring));
    let Some(exterior) = read.next().transpose()? else {
        return Err(MapFileError::value(file, place, "without a ring", "an outer ring, and holes in it"));
    };
    Ok(Polygon::new(exterior, read.collect::<Result<_, _>>()?))
}

/// The valid parts of a faulty polygon, by the even-odd rule, if they have its area: digitized outlines have spikes and
/// doubled corners, which mean nothing. A figure of eight means something else than it says. Without ground it has no
/// parts.
fn parts(drawn: &Polygon<f64>) -> Option<MultiPolygon<f64>> {
    let area_of = |ring: &LineString<f64>| Polygon::new(ring.clone(), Vec::new()).unsigned_area();
    let holes: f64 = drawn.interiors().iter().map(area_of).sum();
    let area = area_of(drawn.exterior()) - holes;
    let parts = drawn.union(&MultiPolygon(Vec::new()));
    let is_mended = (parts.unsigned_area() - area).abs() <= MENDED_SHARE * area;
    (area >= 0.0 && is_mended && parts.iter().all(|part| fault(part).is_none())).then_some(parts)
}

/// Whether the parts of a polygon have all of its ground and all of its corners: its rings touch each other or themselves,
/// as the neck of a lake and the bridge to a hole do, and nothing is left out.
fn is_lossless(drawn: &Polygon<f64>, parts: &MultiPolygon<f64>) -> bool {
    let Some(bounds) = drawn.bounding_rect() else { return false };
    let index = RTree::bulk_load(parts.lines_iter().collect());
    let near = UNION_ROUNDING * bounds.width().max(bounds.height());
    let is_kept = |corner: Coord<f64>| {
        let nearest = index.nearest_neighbor(&Point::from(corner));
        nearest.is_some_and(|line| line.distance_2(&Point::from(corner)) <= near * near)
    };
    let lost = (drawn.unsigned_area() - parts.unsigned_area()).abs();
    lost <= UNION_ROUNDING * drawn.unsigned_area() && drawn.coords_iter().all(is_kept)
}

/// Whether all corners of a ring lie on one line.
fn is_line(ring: &LineString<f64>) -> bool {
    let Some(&first) = ring.0.first() else { return true };
    let length = |corner: Coord<f64>| corner.x.hypot(corner.y);
    let arms = || ring.0.iter().map(|&corner| corner - first);
    let Some(longest) = arms().max_by(|a, b| length(*a).total_cmp(&length(*b))) else { return true };
    let across = |arm: Coord<f64>| (longest.x * arm.y - longest.y * arm.x).abs();
    arms().all(|arm| across(arm) <= ROUNDING * length(longest).powi(2))
}

/// What is wrong with a polygon, if anything.
fn fault(polygon: &Polygon<f64>) -> Option<String> {
    let holes = polygon.interiors();
    for (number, ring) in std::iter::once(polygon.exterior()).chain(holes).enumerate() {
        if ring.remove_repeated_points().0.len() < 4 {
            return Some(format!("ring {} has fewer than 3 corners", number + 1));
        }
        if is_line(ring) {
            return Some(format!("ring {} has no ground: all of its corners lie on one line", number + 1));
        }
        if let Some(Coord { x, y }) = crossing(ring) {
            return Some(format!("ring {} crosses or touches itself at [{x:.6}, {y:.6}]", number + 1));
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
            return Some(format!("its hole, ring {}, is not inside", number + 2));
        }
        for other in number + 1..holes.len() {
            let is_near = bounds[number].zip(bounds[other]).is_some_and(|(a, b)| a.intersects(&b));
            if is_near && do_overlap(hole, &holes[other]) {
                return Some(format!("its holes, rings {} and {}, overlap", number + 2, other + 2));
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
