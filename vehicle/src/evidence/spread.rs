//! How likely a track is in a cell: the normal distributions of its members over the cells of a map.
//!
//! Each distribution is laid out as 512 points of equal weight, a sunflower (Vogel, Mathematical Biosciences
//! 44, 1979): point `i` at angle `i` times the golden angle and at the radius that holds `(i + 1/2) / 512` of
//! a normal distribution. So a probability is a share of points, good to a hundredth; what lies beyond 3.7
//! standard deviations is nothing.

use std::collections::BTreeMap;

use dragnet_search::cell::Cell;
use dragnet_search::terrain::Terrain;
use nalgebra::{Matrix2, Vector2};

use crate::tracker::mixture::Mixture;

const POINTS: u32 = 512;
const GOLDEN_ANGLE_RADIANS: f64 = 2.399_963_229_728_653;

/// All tracks over all cells where one may be.
#[derive(Clone, Debug, Default)]
pub struct Spread {
    cells: BTreeMap<Cell, Presence>,
}

#[derive(Clone, Copy, Debug)]
struct Presence {
    /// The largest probability of a track that was seen.
    most_of_one_seen: f64,
    /// Probability that no track is there.
    of_none: f64,
}

impl Spread {
    /// Of tracks, and whether each was seen in the look.
    pub(super) fn of<'a>(tracks: impl Iterator<Item = (&'a Mixture, bool)>, terrain: &Terrain) -> Self {
        let sunflower = sunflower();
        let mut spread = Self::default();
        for (mixture, is_seen) in tracks {
            for (cell, probability) in over_cells(mixture, terrain, &sunflower) {
                let presence =
                    spread.cells.entry(cell).or_insert(Presence { most_of_one_seen: 0.0, of_none: 1.0 });
                presence.of_none *= (1.0 - probability).max(0.0);
                if is_seen {
                    presence.most_of_one_seen = presence.most_of_one_seen.max(probability.min(1.0));
                }
            }
        }
        spread
    }

    /// The largest probability with which one track that was seen is in a cell, `0.0..=1.0`.
    #[must_use]
    pub fn most_of_one_seen(&self, cell: Cell) -> f64 {
        self.cells.get(&cell).map_or(0.0, |presence| presence.most_of_one_seen)
    }

    /// Probability that any track is in a cell, `0.0..=1.0`, their errors taken as independent.
    #[must_use]
    pub fn of_any(&self, cell: Cell) -> f64 {
        self.cells.get(&cell).map_or(0.0, |presence| 1.0 - presence.of_none)
    }
}

/// The cell at metres east and north of the map's corner, if it is on the map.
#[must_use]
pub(super) fn cell_at(terrain: &Terrain, point_meters: Vector2<f64>) -> Option<Cell> {
    let point_cells = point_meters / terrain.cell_meters();
    terrain.grid().cell_at(point_cells.x, point_cells.y)
}

/// Points of the standard normal distribution of two dimensions.
fn sunflower() -> Vec<Vector2<f64>> {
    let point = |index: u32| {
        let share = (f64::from(index) + 0.5) / f64::from(POINTS);
        let radius = (-2.0 * (1.0 - share).ln()).sqrt();
        let (sin, cos) = (f64::from(index) * GOLDEN_ANGLE_RADIANS).sin_cos();
        Vector2::new(cos, sin) * radius
    };
    (0..POINTS).map(point).collect()
}

fn over_cells(mixture: &Mixture, terrain: &Terrain, sunflower: &[Vector2<f64>]) -> BTreeMap<Cell, f64> {
    let mut cells = BTreeMap::new();
    for member in mixture.members() {
        let place: Matrix2<f64> = member.state.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        // Positive definite, as every member of a mixture after a bearing; a long wait may have rounded it
        // away.
        let Some(root) = place.cholesky().map(|root| root.l()) else { continue };
        // A member lies in a few cells: looking those through is faster than a tree for each point.
        let mut counts: Vec<(Cell, u32)> = Vec::new();
        for point in sunflower {
            let Some(cell) = cell_at(terrain, member.state.position_meters() + root * point) else {
                continue;
            };
            match counts.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, count)) => *count += 1,
                None => counts.push((cell, 1)),
            }
        }
        for (cell, count) in counts {
            let probability = cells.entry(cell).or_insert(0.0);
            // Point by point: a product would round otherwise, and with it every recorded run.
            (0..count).for_each(|_| *probability += member.weight / f64::from(POINTS));
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sunflower_is_a_standard_normal_distribution() {
        let points = sunflower();
        let count = f64::from(POINTS);
        let mean = points.iter().sum::<Vector2<f64>>() / count;
        let covariance = points.iter().map(|point| point * point.transpose()).sum::<Matrix2<f64>>() / count;
        assert!(mean.norm() < 0.01, "{mean}");
        assert!((covariance - Matrix2::identity()).norm() < 0.02, "{covariance}");
        // Within one standard deviation of the middle to both sides: 0.6827 squared.
        let inside = points.iter().filter(|point| point.amax() < 1.0).count() as f64 / count;
        assert!((inside - 0.466).abs() < 0.01, "{inside}");
    }
}
