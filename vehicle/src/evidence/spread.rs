//! The probability of a track in each cell: the normal distributions of its range hypotheses over the cells of a map.
//!
//! Each distribution is represented by points of equal weight, a sunflower (Vogel, Mathematical Biosciences 44, 1979):
//! of `n` points, point `i` at angle `i` times the golden angle and at the radius that holds `(i + 1/2) / n` of a
//! normal distribution. So a probability is a share of points, and nothing lies beyond 3.7 standard deviations.

use std::collections::BTreeMap;

use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;
use nalgebra::{Matrix2, Vector2};

use crate::tracker::track::Track;

/// Points of a hypothesis, if there are few of them.
const POINTS: u32 = 512;
/// And if there are many narrow ones.
const FEW_POINTS: u32 = 96;
const FEW_MEMBERS: usize = 8;
/// Prior odds of an object outside of the search area, relative to one inside.
const ELSEWHERE: f64 = 0.01;
const GOLDEN_ANGLE_RADIANS: f64 = 2.399_963_229_728_653;

/// The cell at meters east and north of the map's corner, if it is on the map.
#[must_use]
pub(super) fn cell_at(terrain: &Terrain, point_meters: Vector2<f64>) -> Option<Cell> {
    let point_cells = point_meters / terrain.cell_meters();
    terrain.grid().cell_at(point_cells.x, point_cells.y)
}

/// Points of the standard normal distribution of two dimensions.
fn sunflower(count: u32) -> Vec<Vector2<f64>> {
    let point = |index: u32| {
        let share = (f64::from(index) + 0.5) / f64::from(count);
        let radius = (-2.0 * (1.0 - share).ln()).sqrt();
        let (sin, cos) = (f64::from(index) * GOLDEN_ANGLE_RADIANS).sin_cos();
        Vector2::new(cos, sin) * radius
    };
    (0..count).map(point).collect()
}

/// The probability that a track's object is in each searched cell. An object elsewhere is [`ELSEWHERE`] times as likely as
/// the track alone says: what is searched for is in the search area, and what is detected outside is something else.
pub(super) fn over_cells(track: &Track, terrain: &Terrain) -> BTreeMap<Cell, f64> {
    let mut cells = over_map(track, terrain);
    cells.retain(|&cell, _| terrain.is_searched(cell));
    let inside: f64 = cells.values().sum();
    let all = inside + ELSEWHERE * (1.0 - inside).max(0.0);
    for probability in cells.values_mut() {
        *probability /= all;
    }
    cells
}

/// The distribution of a track over the cells of the map.
fn over_map(track: &Track, terrain: &Terrain) -> BTreeMap<Cell, f64> {
    let members = track.mixture().members();
    let count = if members.len() > FEW_MEMBERS { FEW_POINTS } else { POINTS };
    let sunflower = sunflower(count);
    let lasting = Matrix2::identity() * track.lasting_std_meters().powi(2);
    let mut cells = BTreeMap::new();
    for member in members {
        // Positive definite, like every hypothesis after a bearing; a long prediction may have lost this by rounding.
        let place = member.state.place_covariance() + lasting;
        let Some(root) = place.cholesky().map(|root| root.l()) else { continue };
        // A hypothesis covers few cells: scanning them is faster than a tree lookup for each point.
        let mut counts: Vec<(Cell, u32)> = Vec::new();
        for point in &sunflower {
            let Some(cell) = cell_at(terrain, member.state.position_meters() + root * point) else {
                continue;
            };
            match counts.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, count)) => *count += 1,
                None => counts.push((cell, 1)),
            }
        }
        for (cell, points) in counts {
            *cells.entry(cell).or_insert(0.0) += member.weight * f64::from(points) / f64::from(count);
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sunflower_is_a_standard_normal_distribution() {
        for count in [POINTS, FEW_POINTS] {
            let points = sunflower(count);
            let count = f64::from(count);
            let mean = points.iter().sum::<Vector2<f64>>() / count;
            let covariance =
                points.iter().map(|point| point * point.transpose()).sum::<Matrix2<f64>>() / count;
            assert!(mean.norm() < 0.04, "{mean}");
            assert!((covariance - Matrix2::identity()).norm() < 0.1, "{covariance}");
            // Within one standard deviation of the center along both axes: 0.6827 squared.
            let inside = points.iter().filter(|point| point.amax() < 1.0).count() as f64 / count;
            assert!((inside - 0.466).abs() < 0.03, "{inside}");
        }
    }
}
