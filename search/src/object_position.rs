//! Where declared objects are: positions that robots with cameras know to a fraction of a cell.
//!
//! They are for people who go there. They are no evidence: beliefs and policies know cells alone.

use std::collections::BTreeMap;

use crate::cell::Cell;
use crate::observation::{Observation, Source};
use crate::terrain::Terrain;

/// Quantile of the chi-squared distribution with two degrees of freedom: 95 % of the positions are within the ellipse of
/// this squared Mahalanobis distance.
const CHI_SQUARED_95: f64 = 5.991;
/// Share of a variance by which rounding to single precision may make a covariance indefinite.
const ROUNDING: f64 = 1e-6;

/// The estimated position of the object that a robot declares in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectPosition {
    cell: Cell,
    east_meters: f64,
    north_meters: f64,
    covariance_square_meters: [f32; 3],
}

impl ObjectPosition {
    /// The maximum variance in any direction, square meters: that of an error of a kilometer.
    pub const MAX_VARIANCE_SQUARE_METERS: f32 = 1e6;
    /// The maximum number of positions in one observation.
    pub const MAX_IN_OBSERVATION: usize = 16;

    /// A position east and north of the map's south-western corner, as [`Terrain::center_meters`], and its covariance:
    /// east with east, east with north, north with north. `None` if the position is not finite, or the covariance is not
    /// positive semi-definite or exceeds [`Self::MAX_VARIANCE_SQUARE_METERS`].
    #[must_use]
    pub fn new(
        cell: Cell,
        [east_meters, north_meters]: [f64; 2],
        covariance_square_meters: [f32; 3],
    ) -> Option<Self> {
        let [east, both, north] = covariance_square_meters;
        let variances = 0.0..=Self::MAX_VARIANCE_SQUARE_METERS;
        let is_semi_definite =
            f64::from(both).powi(2) <= f64::from(east) * f64::from(north) * (1.0 + ROUNDING);
        let is_valid = east_meters.is_finite()
            && north_meters.is_finite()
            && variances.contains(&east)
            && variances.contains(&north)
            && is_semi_definite;
        is_valid.then_some(Self { cell, east_meters, north_meters, covariance_square_meters })
    }

    /// The cell in which the object is declared.
    #[must_use]
    pub const fn cell(&self) -> Cell {
        self.cell
    }

    /// Meters east and north of the map's south-western corner.
    #[must_use]
    pub const fn meters(&self) -> (f64, f64) {
        (self.east_meters, self.north_meters)
    }

    /// East with east, east with north, north with north, square meters.
    #[must_use]
    pub const fn covariance_square_meters(&self) -> [f32; 3] {
        self.covariance_square_meters
    }

    /// The largest distance of the object from the position with a probability of at least 95 %, meters: the longer half
    /// axis of the ellipse of errors.
    #[must_use]
    pub fn accuracy_meters(&self) -> f64 {
        let [east, both, north] = self.covariance_square_meters.map(f64::from);
        let largest = f64::midpoint(east, north) + (0.5 * (east - north)).hypot(both);
        (CHI_SQUARED_95 * largest).sqrt()
    }

    /// Whether it is in its cell or at most one cell beside it: an object on a border keeps the cell in which it was
    /// declared.
    #[must_use]
    pub fn is_near_its_cell(&self, terrain: &Terrain) -> bool {
        let (east, north) = terrain.center_meters(self.cell);
        let beside = (self.east_meters - east).abs().max((self.north_meters - north).abs());
        beside <= 1.5 * terrain.cell_meters()
    }

    fn trace(&self) -> f32 {
        let [east, _, north] = self.covariance_square_meters;
        east + north
    }
}

/// The positions by all observations: equal sets of observations give equal positions, in any order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectPositions {
    /// The newest of each robot in each cell.
    newest: BTreeMap<Cell, BTreeMap<Source, Numbered>>,
}

/// A position with the incarnation and sequence number of its observation.
type Numbered = ((u64, u64), ObjectPosition);

impl ObjectPositions {
    /// Takes the positions of an observation.
    pub fn add(&mut self, observation: &Observation) {
        let Observation { origin, sequence, positions, .. } = observation;
        let number = (origin.incarnation, *sequence);
        for position in positions {
            let newest = self.newest.entry(position.cell).or_default();
            let entry = newest.entry(origin.source).or_insert((number, *position));
            if number > entry.0 {
                *entry = (number, *position);
            }
        }
    }

    /// The position of the object that is declared in a cell, if a robot knows it: of several robots, that of the smallest
    /// covariance.
    #[must_use]
    pub fn of(&self, cell: Cell) -> Option<&ObjectPosition> {
        let newest = self.newest.get(&cell)?.iter();
        let best = newest.min_by(|(a, (_, x)), (b, (_, y))| x.trace().total_cmp(&y.trace()).then(a.cmp(b)));
        best.map(|(_, (_, position))| position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::Origin;

    fn terrain() -> Terrain {
        Terrain::from_ascii("....\n....", 10.0).unwrap()
    }

    fn position(number: u32, meters: [f64; 2], variance: f32) -> ObjectPosition {
        let cell = terrain().grid().cell_numbered(number).unwrap();
        ObjectPosition::new(cell, meters, [variance, 0.0, variance]).unwrap()
    }

    fn observation(robot: u16, incarnation: u64, sequence: u64, positions: &[ObjectPosition]) -> Observation {
        let origin = Origin { source: Source::numbered(robot), incarnation };
        let from = terrain().grid().cell_numbered(0).unwrap();
        Observation { origin, sequence, time_ns: 0, from, readings: Vec::new(), positions: positions.into() }
    }

    #[test]
    fn impossible_positions_and_covariances_are_refused() {
        let cell = terrain().grid().cell_numbered(1).unwrap();
        let new = |meters, covariance| ObjectPosition::new(cell, meters, covariance).is_some();
        let here = [15.0, 5.0];
        assert!(new(here, [0.0; 3]) && new(here, [4.0, 2.0, 1.0]) && new(here, [1e6, -1e6, 1e6]));
        for meters in [[f64::NAN, 5.0], [15.0, f64::INFINITY]] {
            assert!(!new(meters, [1.0, 0.0, 1.0]), "{meters:?}");
        }
        let (nan, infinity) = (f32::NAN, f32::INFINITY);
        for covariance in [
            [-1.0, 0.0, 1.0],
            [1.0, 0.0, -1.0],
            [4.0, 2.1, 1.0],
            [2e6, 0.0, 1.0],
            [1.0, 0.0, infinity],
            [nan, 0.0, 1.0],
            [1.0, nan, 1.0],
        ] {
            assert!(!new(here, covariance), "{covariance:?}");
        }
    }

    #[test]
    fn the_accuracy_is_that_of_the_worst_direction() {
        let cell = terrain().grid().cell_numbered(1).unwrap();
        let accuracy =
            |covariance| ObjectPosition::new(cell, [15.0, 5.0], covariance).unwrap().accuracy_meters();
        assert!((accuracy([1.0, 0.0, 1.0]) - 2.448).abs() < 1e-3);
        assert!((accuracy([0.25, 0.0, 4.0]) - 4.895).abs() < 1e-3);
        // Variances of 4 and 1 along the diagonals.
        assert!((accuracy([2.5, 1.5, 2.5]) - 4.895).abs() < 1e-3);
        assert_eq!(accuracy([0.0; 3]).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn a_position_may_be_up_to_a_cell_beside_its_own() {
        let is_near = |meters| position(1, meters, 1.0).is_near_its_cell(&terrain());
        assert!(is_near([15.0, 5.0]) && is_near([0.5, 19.5]) && is_near([29.5, -9.5]));
        assert!(!is_near([30.5, 5.0]) && !is_near([15.0, 20.5]) && !is_near([-0.5, 5.0]));
    }

    #[test]
    fn the_newest_of_each_robot_counts_and_of_robots_the_most_precise_in_any_order() {
        let [cell, other] = [1, 2].map(|number| terrain().grid().cell_numbered(number).unwrap());
        let precise = position(1, [15.0, 5.0], 0.1);
        let vague = position(1, [16.0, 6.0], 1.0);
        let vaguer = position(1, [17.0, 7.0], 2.0);
        let elsewhere = position(2, [25.0, 5.0], 9.0);
        let published = [
            // Replaced by its robot's later start, though it was more precise.
            observation(1, 0, 7, &[precise, elsewhere]),
            observation(1, 5, 0, &[vaguer]),
            observation(3, 0, 1, &[vague]),
            observation(2, 0, 3, &[vague]),
            observation(2, 0, 2, &[vaguer]),
        ];
        for first in 0..published.len() {
            for step in [1, 2, 3, 4] {
                let mut known = ObjectPositions::default();
                for index in 0..published.len() {
                    known.add(&published[(first + index * step) % published.len()]);
                    // Repeated messages change nothing.
                    known.add(&published[first]);
                }
                assert_eq!(known.of(cell), Some(&vague));
                assert_eq!(known.of(other), Some(&elsewhere));
            }
        }
        // Equally precise: that of the robot with the smaller number.
        let twin = position(1, [14.0, 4.0], 1.0);
        let mut known = ObjectPositions::default();
        known.add(&observation(3, 0, 0, &[vague]));
        known.add(&observation(2, 0, 0, &[twin]));
        assert_eq!(known.of(cell), Some(&twin));
        assert_eq!(known.of(terrain().grid().cell_numbered(0).unwrap()), None);
    }
}
