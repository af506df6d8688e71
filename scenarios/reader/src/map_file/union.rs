//! Polygons that share ground, and the ground that they cover together.

use geo::coordinate_position::CoordPos;
use geo::dimensions::Dimensions;
use geo::orient::Direction;
use geo::{Area, BooleanOps, BoundingRect, Intersects, MultiPolygon, Orient, Polygon, Relate, unary_union};

/// Share of the smaller of two polygons that may also lie in the other: corners of neighbors that are rounded.
const ROUNDED_SHARE: f64 = 1e-3;

/// Pairs of polygons, in their order, that share more than a border and what rounding adds to it.
pub(in crate::map_file) fn overlapping_pairs(polygons: &[&Polygon<f64>]) -> Vec<(usize, usize)> {
    let boxes: Vec<_> = polygons.iter().map(|polygon| polygon.bounding_rect()).collect();
    let overlap = |a: usize, b: usize| {
        let is_near = boxes[a].zip(boxes[b]).is_some_and(|(a, b)| a.intersects(&b));
        let relation = || polygons[a].relate(polygons[b]);
        is_near
            && relation().get(CoordPos::Inside, CoordPos::Inside) == Dimensions::TwoDimensional
            && shared_share(polygons[a], polygons[b]) > ROUNDED_SHARE
    };
    let count = polygons.len();
    (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b))).filter(|&(a, b)| overlap(a, b)).collect()
}

/// The share of the smaller polygon that lies in the other, too.
fn shared_share(a: &Polygon<f64>, b: &Polygon<f64>) -> f64 {
    a.intersection(b).unsigned_area() / a.unsigned_area().min(b.unsigned_area())
}

/// The ground of all polygons, in polygons that share none. Files draw rings in either direction, and geo's union takes
/// what lies on the left of a ring for its inside.
pub(in crate::map_file) fn union(polygons: &[&Polygon<f64>]) -> MultiPolygon<f64> {
    let oriented: Vec<_> = polygons.iter().map(|polygon| polygon.orient(Direction::Default)).collect();
    unary_union(&oriented)
}

#[cfg(test)]
mod tests {
    use geo::{LineString, Winding, polygon};

    use super::*;

    /// A square from `[west, 0]`, 10 by 10, with a hole of 4 by 4 in its middle.
    fn square(west: f64) -> Polygon<f64> {
        let at = |x: f64| west + x;
        polygon!(
            exterior: [(x: at(0.0), y: 0.0), (x: at(10.0), y: 0.0), (x: at(10.0), y: 10.0), (x: at(0.0), y: 10.0)],
            interiors: [[(x: at(3.0), y: 3.0), (x: at(7.0), y: 3.0), (x: at(7.0), y: 7.0), (x: at(3.0), y: 7.0)]],
        )
    }

    fn turned(polygon: &Polygon<f64>, are_clockwise: [bool; 2]) -> Polygon<f64> {
        let turn = |ring: &LineString<f64>, is_clockwise: bool| {
            let mut ring = ring.clone();
            if is_clockwise {
                ring.make_cw_winding();
            } else {
                ring.make_ccw_winding();
            }
            ring
        };
        let [outer, inner] = are_clockwise;
        let holes = polygon.interiors().iter().map(|hole| turn(hole, inner));
        Polygon::new(turn(polygon.exterior(), outer), holes.collect())
    }

    #[test]
    fn rings_cover_the_same_ground_in_either_direction() {
        let (first, second, far) = (square(0.0), square(8.0), square(100.0));
        for directions in 0..64_u8 {
            let is = |bit: u8| directions & (1 << bit) != 0;
            let drawn = [
                turned(&first, [is(0), is(1)]),
                turned(&second, [is(2), is(3)]),
                turned(&far, [is(4), is(5)]),
            ];
            let drawn: Vec<&Polygon<f64>> = drawn.iter().collect();
            assert_eq!(overlapping_pairs(&drawn), [(0, 1)]);
            let area = union(&drawn).unsigned_area();
            assert!((area - (3.0 * 84.0 - 20.0)).abs() < 1e-6, "{directions:06b}: {area}");
        }
    }
}
