//! The sweep width of a sensor: how wide a strip a straight pass searches, if its partial detections are put together.
//!
//! By Koopman (Search and Screening, 1980, chapter 3) it is the integral of the lateral range curve, the probability of
//! detection `POD(y)` of an object at the distance `y` beside a long straight path:
//!
//! ```text
//! W = integral of POD(y) dy = a sum over lateral offsets j from -R to R of POD(j)
//! ```
//!
//! with the edge `a` of the cells and the radius `R` of the sensor. A robot that passes along a row of cells observes from
//! each of them, so that a cell `j` rows beside its path gets the precision `k(j) = sum over i of 1 / v(|i| + |j|)`, and
//! `POD(j)` is that of [`crate::detection`]. It depends on the prior too: where an object is less likely, more evidence is
//! needed to declare one.
//!
//! Departures: cells are wide, so the integral is a sum; and ground that hides objects is not modeled by the sensor.

use crate::detection::probability_of_detection;
use crate::evidence::{CellEvidence, precision_units};
use crate::sensor::Sensor;

/// Sweep width of one straight pass along a row of cells, cells: 0 to `2 R + 1`, for cells with these prior log-odds and the
/// detection threshold `tau`.
#[must_use]
pub fn sweep_width_cells(sensor: &Sensor, prior_log_odds_nats: f64, tau: f64) -> f64 {
    let at = |lateral: u32| {
        let ahead = (1..=sensor.radius() - lateral).map(|along| 2 * units(sensor, along + lateral));
        let precision = units(sensor, lateral) + ahead.sum::<i64>();
        probability_of_detection(prior_log_odds_nats, CellEvidence { precision, weighted_sum: 0 }, tau)
    };
    at(0) + 2.0 * (1..=sensor.radius()).map(at).sum::<f64>()
}

fn units(sensor: &Sensor, distance: u32) -> i64 {
    precision_units(sensor.variance(distance))
}

#[cfg(test)]
mod tests {
    use crate::belief::Belief;
    use crate::cell::Position;
    use crate::evidence::Reading;
    use crate::sensor::Noise;
    use crate::terrain::Terrain;

    use super::*;

    /// A robot drives along the middle row of a field, and the PODs of the column in its middle are added up.
    #[test]
    fn it_is_the_area_under_the_lateral_range_curve_of_a_pass() {
        let mut met = [0, 0];
        for (radius, noise_variance, prior) in
            [(1, 0.005, 0.01), (4, 0.02, 0.01), (4, 0.5, 0.01), (4, 0.5, 0.000_1), (6, 0.2, 0.3)]
        {
            let sensor = Sensor::new(radius, noise_variance, Noise::Gaussian).unwrap();
            let side = 4 * radius + 3;
            let row = ".".repeat(side as usize);
            let terrain = Terrain::from_ascii(&vec![row; side as usize].join("\n"), 30.0).unwrap();
            let (grid, middle) = (terrain.grid(), side / 2);
            let mut belief = Belief::uniform(&terrain, prior).unwrap();
            for column in 0..side {
                let from = grid.cell(Position { row: middle, column }).unwrap();
                for seen in sensor.footprint() {
                    let Some(cell) = grid.step(from, seen.offset) else { continue };
                    belief.add(&Reading { cell, value: 0.0, variance: seen.variance });
                }
            }
            let log_odds = (prior / (1.0 - prior)).ln();
            let pods: Vec<f64> = (0..side)
                .map(|row| grid.cell(Position { row, column: middle }).unwrap())
                .map(|cell| probability_of_detection(log_odds, belief.evidence().of(cell), 0.95))
                .collect();
            let (given, expected) = (sweep_width_cells(&sensor, log_odds, 0.95), pods.iter().sum::<f64>());
            assert!((given - expected).abs() < 1e-9, "{radius} {noise_variance}: {given} {expected}");
            assert!(given <= f64::from(2 * radius + 1), "{given}");
            met[usize::from(given < f64::from(2 * radius))] += 1;
        }
        assert!(met.iter().all(|&count| count > 0), "wide and narrow: {met:?}");
    }

    #[test]
    fn it_is_0_where_nothing_is_searched_and_falls_with_noise() {
        let sensor = |noise| Sensor::new(5, noise, Noise::Gaussian).unwrap();
        assert!(sweep_width_cells(&sensor(0.1), f64::NEG_INFINITY, 0.95) <= 0.0);
        let widths = [0.01, 0.1, 1.0, 10.0].map(|noise| sweep_width_cells(&sensor(noise), -5.0, 0.95));
        assert!(widths.is_sorted_by(|a, b| a >= b) && widths[0] > widths[3], "{widths:?}");
    }
}
