//! A vehicle's footprint: the ground that it covers.

use crate::plane::Pose;

/// Squares that are only touched are not covered; without this tolerance, rounding would decide.
const TOUCH: f64 = 1e-6;

/// Maximum number of corners of a polygon.
pub const MAX_CORNERS: usize = 64;
/// Maximum distance of a footprint's points from the reference point, in cells of the map.
pub const MAX_FOOTPRINT_CELLS: f64 = 128.0;

/// A vehicle's outline at the reference point, x forward and y to the left, meters.
#[derive(Clone, Debug, PartialEq)]
pub enum Footprint {
    /// A disc around the reference point; of radius 0 it covers the cell of the reference point.
    Circle {
        /// Meters, 0 or more.
        radius_meters: f64,
    },
    /// A simple polygon, convex or not, its corners in either order.
    Polygon {
        /// At least 3, at most [`MAX_CORNERS`].
        corners_meters: Vec<(f64, f64)>,
    },
}

/// Why an outline is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FootprintError {
    /// NaN, infinite, negative or too large.
    #[error(
        "a footprint with {0} m: allowed are finite lengths, within {MAX_FOOTPRINT_CELLS} cells of the map"
    )]
    Length(f64),
    /// Too few or too many corners.
    #[error("a footprint of {0} corners: allowed are 3 to {MAX_CORNERS}")]
    CornerCount(usize),
    /// Its edges cross.
    #[error("edges {0} and {1} of the footprint cross or touch: allowed is a simple polygon")]
    Crossing(usize, usize),
}

impl Footprint {
    /// A rectangle with the reference point at its center.
    #[must_use]
    pub fn rectangle(length_meters: f64, width_meters: f64) -> Self {
        let (x, y) = (length_meters / 2.0, width_meters / 2.0);
        Self::Polygon { corners_meters: vec![(x, y), (-x, y), (-x, -y), (x, -y)] }
    }

    /// Checks the outline for a map of that resolution.
    pub(super) fn check(&self, resolution_meters: f64) -> Result<(), FootprintError> {
        let max_meters = MAX_FOOTPRINT_CELLS * resolution_meters;
        let corners = match self {
            Self::Circle { radius_meters } if (0.0..=max_meters).contains(radius_meters) => return Ok(()),
            Self::Circle { radius_meters } => return Err(FootprintError::Length(*radius_meters)),
            Self::Polygon { corners_meters } => corners_meters,
        };
        if !(3..=MAX_CORNERS).contains(&corners.len()) {
            return Err(FootprintError::CornerCount(corners.len()));
        }
        let is_bad = |length: &f64| length.is_nan() || length.abs() > max_meters;
        if let Some(bad) = corners.iter().flat_map(|&(x, y)| [x, y]).find(is_bad) {
            return Err(FootprintError::Length(bad));
        }
        let count = corners.len();
        for a in 0..count {
            for b in a + 1..count {
                let is_next = b == a + 1 || (a == 0 && b == count - 1);
                let edge = |index: usize| (corners[index], corners[(index + 1) % count]);
                let fails = if is_next { edge(a).0 == edge(a).1 } else { cross(edge(a), edge(b)) };
                if fails || corners[a] == corners[b] {
                    return Err(FootprintError::Crossing(a, b));
                }
            }
        }
        Ok(())
    }

    /// Distance of its farthest point from the reference point, meters.
    #[must_use]
    pub fn circumscribed_meters(&self) -> f64 {
        match self {
            Self::Circle { radius_meters } => *radius_meters,
            Self::Polygon { corners_meters } => {
                corners_meters.iter().map(|c| c.0.hypot(c.1)).fold(0.0, f64::max)
            }
        }
    }

    /// Cells that it covers at a pose, as (north, east) from the cell whose center is the origin, in order.
    pub(super) fn cells(&self, pose: Pose, resolution_meters: f64) -> Vec<(i32, i32)> {
        let scaled = |meters: f64| meters / resolution_meters;
        let (x, y) = (scaled(pose.x_meters), scaled(pose.y_meters));
        let reach = scaled(self.circumscribed_meters());
        let (sin, cos) = pose.heading_radians.sin_cos();
        let place = |&(a, b): &(f64, f64)| {
            let (forward, left) = (scaled(a), scaled(b));
            (x + forward * cos - left * sin, y + forward * sin + left * cos)
        };
        let corners: Vec<(f64, f64)> = match self {
            Self::Circle { .. } => Vec::new(),
            Self::Polygon { corners_meters } => corners_meters.iter().map(place).collect(),
        };
        let range = |center: f64| nearest(center - reach)..=nearest(center + reach);
        let mut cells = Vec::new();
        for north in range(y) {
            for east in range(x) {
                let (dx, dy) = (f64::from(east) - x, f64::from(north) - y);
                let is_covered = if corners.is_empty() {
                    let outside = |d: f64| (d.abs() - 0.5 + TOUCH).max(0.0);
                    outside(dx).hypot(outside(dy)) < reach.max(TOUCH)
                } else {
                    covers(&corners, f64::from(east), f64::from(north))
                };
                if is_covered {
                    cells.push((north, east));
                }
            }
        }
        cells
    }
}

/// The cell that a coordinate in cells lies in: cell 0 is centered at 0.
#[expect(clippy::cast_possible_truncation, reason = "footprints and primitives reach a few hundred cells")]
pub(super) fn nearest(cells: f64) -> i32 {
    (cells + 0.5).floor() as i32
}

type Point = (f64, f64);

/// Whether a polygon and the unit square around a point share more than a border: an edge enters the square, or the
/// square lies inside.
fn covers(corners: &[Point], east: f64, north: f64) -> bool {
    let half = 0.5 - TOUCH;
    let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
    let enters = |(a, b): (&Point, &Point)| {
        // Liang and Barsky (1984): the part of the edge between both pairs of parallel sides.
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for (from, to, center) in [(a.0, b.0, east), (a.1, b.1, north)] {
            let (low, high, along) = (center - half - from, center + half - from, to - from);
            if along == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
            } else {
                begin = begin.max((low / along).min(high / along));
                end = end.min((low / along).max(high / along));
            }
        }
        begin <= end
    };
    let is_above = |(a, b): &(&Point, &Point)| {
        (a.1 > north) != (b.1 > north) && east < a.0 + (north - a.1) * (b.0 - a.0) / (b.1 - a.1)
    };
    edges().any(enters) || edges().filter(is_above).count() % 2 == 1
}

/// Whether two segments have a point in common.
fn cross((a, b): (Point, Point), (c, d): (Point, Point)) -> bool {
    let side = |from: Point, to: Point, point: Point| {
        let area = (to.0 - from.0) * (point.1 - from.1) - (to.1 - from.1) * (point.0 - from.0);
        if area == 0.0 { 0.0 } else { area.signum() }
    };
    let is_between = |from: Point, to: Point, point: Point| {
        side(from, to, point) == 0.0
            && (from.0.min(to.0)..=from.0.max(to.0)).contains(&point.0)
            && (from.1.min(to.1)..=from.1.max(to.1)).contains(&point.1)
    };
    (side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0)
        || is_between(a, b, c)
        || is_between(a, b, d)
        || is_between(c, d, a)
        || is_between(c, d, b)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(x_meters: f64, y_meters: f64, heading_radians: f64) -> Pose {
        Pose { x_meters, y_meters, heading_radians }
    }

    #[test]
    fn squares_that_are_only_touched_are_not_covered() {
        let check = |footprint: Footprint, pose, expected: &[(i32, i32)]| {
            assert_eq!(footprint.cells(pose, 0.1), expected);
        };
        check(Footprint::rectangle(0.1, 0.1), at(0.0, 0.0, 0.0), &[(0, 0)]);
        check(Footprint::rectangle(0.3, 0.1), at(0.0, 0.0, 0.0), &[(0, -1), (0, 0), (0, 1)]);
        let up = std::f64::consts::FRAC_PI_2;
        check(Footprint::rectangle(0.3, 0.1), at(0.0, 0.0, up), &[(-1, 0), (0, 0), (1, 0)]);
        check(Footprint::rectangle(0.1, 0.1), at(0.1, 0.05, 0.0), &[(0, 1), (1, 1)]);
        check(Footprint::Circle { radius_meters: 0.0 }, at(0.0, 0.0, 0.0), &[(0, 0)]);
        check(
            Footprint::Circle { radius_meters: 0.06 },
            at(0.0, 0.0, 1.0),
            &[(-1, 0), (0, -1), (0, 0), (0, 1), (1, 0)],
        );
    }

    #[test]
    fn invalid_outlines_are_reported() {
        let polygon = |corners: &[Point]| Footprint::Polygon { corners_meters: corners.to_vec() }.check(0.1);
        assert_eq!(polygon(&[(0.0, 0.0), (1.0, 0.0)]), Err(FootprintError::CornerCount(2)));
        let bow = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        assert_eq!(polygon(&bow), Err(FootprintError::Crossing(0, 2)));
        assert_eq!(polygon(&[(0.0, 0.0), (1.0, 0.0), (0.0, 13.0)]), Err(FootprintError::Length(13.0)));
        assert!(polygon(&[(0.0, 0.0), (1.0, 0.0), (0.0, f64::NAN)]).is_err());
        assert!(Footprint::Circle { radius_meters: -1.0 }.check(0.1).is_err());
        assert_eq!(polygon(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]), Ok(()));
    }

    proptest! {
        /// Points inside the outline lie in covered cells.
        #[test]
        fn every_point_of_a_vehicle_lies_in_a_covered_cell(
            x in -0.1_f64..0.1, y in -0.1_f64..0.1, heading in -7.0_f64..7.0,
            along in -0.999_f64..0.999, across in -0.999_f64..0.999,
        ) {
            let cells = Footprint::rectangle(0.7, 0.4).cells(at(x, y, heading), 0.1);
            let (forward, left) = (along * 0.35, across * 0.2);
            let (sin, cos) = heading.sin_cos();
            let point = (x + forward * cos - left * sin, y + forward * sin + left * cos);
            prop_assert!(cells.contains(&(nearest(point.1 / 0.1), nearest(point.0 / 0.1))));
        }
    }
}
