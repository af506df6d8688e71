//! The probability of detection of a cell.
//!
//! Readings of an object of total precision `k = sum 1/v` move the log-odds of their cell from the prior `L0` to a
//! normal distribution around `L0 + k / 2` of variance `k` (see [`crate::evidence`]: the log-likelihood ratio of
//! Gaussian readings). The object is declared if that is at least `ln(tau / (1 - tau))`, so that
//!
//! ```text
//! POD = P(declared | object) = Phi((L0 + k / 2 - ln(tau / (1 - tau))) / sqrt k),      0 where k = 0
//! ```
//!
//! with the standard normal distribution `Phi`. It is cumulative, since `k` is; it measures the effort, not the
//! readings; and it makes the assumption of the belief, Gaussian readings that are independent given the truth.

use crate::evidence::{CellEvidence, UNITS};
use crate::utility::{found, log_odds_nats};

/// Probability that an object would be declared by now, 0 to 1, in a cell with these prior log-odds (`-inf` where
/// nothing is searched) and this precision of readings, with the detection threshold `tau`.
#[must_use]
pub fn probability_of_detection(prior_log_odds_nats: f64, evidence: CellEvidence, tau: f64) -> f64 {
    let precision = evidence.precision as f64 / UNITS;
    // Without a reading nothing has been detected, even where the prior alone would do.
    if precision <= 0.0 { 0.0 } else { found(prior_log_odds_nats, precision, log_odds_nats(tau)) }
}

#[cfg(test)]
mod tests {
    use crate::belief::Belief;
    use crate::evidence::Reading;
    use crate::seed::{Purpose, stream};
    use crate::sensor::{Noise, Sensor};
    use crate::terrain::Terrain;

    use super::*;

    /// Of many objects observed with the sensor model, the belief declares this share.
    #[test]
    fn of_many_objects_this_share_is_declared() {
        let terrain = Terrain::from_ascii(".", 30.0).unwrap();
        let cell = terrain.grid().cells().next().unwrap();
        let sensor = Sensor::new(8, 0.02, Noise::Gaussian).unwrap();
        let mut random = stream(11, Purpose::Noise, 0);
        let mut met = [0, 0];
        for (prior, observations, tau) in [(0.02, 3, 0.95), (0.2, 4, 0.95), (0.002, 6, 0.8), (0.5, 1, 0.99)] {
            let observation =
                *sensor.footprint().iter().find(|observation| observation.offset.manhattan() == 4).unwrap();
            let count = 4000;
            let mut declared = 0;
            let mut expected = 0.0;
            for _ in 0..count {
                let mut belief = Belief::uniform(&terrain, prior).unwrap();
                let prior_log_odds_nats = belief.log_odds_nats(cell);
                for _ in 0..observations {
                    let value = sensor.draw(true, &observation, &mut random);
                    belief.add(&Reading { cell, value, variance: observation.variance });
                }
                declared += i32::from(belief.is_found(cell, tau));
                expected = probability_of_detection(prior_log_odds_nats, belief.evidence().of(cell), tau);
            }
            let share = f64::from(declared) / f64::from(count);
            assert!(
                (share - expected).abs() < 0.025,
                "{prior} {observations} {tau}: {share}, expected {expected}"
            );
            met[usize::from(expected > 0.3)] += 1;
        }
        assert!(met.iter().all(|&count| count > 0), "both well and badly searched cells: {met:?}");
    }

    #[test]
    fn it_grows_with_every_observation_from_0_to_1() {
        let evidence = |units: i64| CellEvidence { precision: units, weighted_sum: 0 };
        let mut last = 0.0;
        for step in 0..60 {
            let given = probability_of_detection(-4.0, evidence(step * 65_536), 0.95);
            assert!(given >= last && given <= 1.0, "{step}: {given}");
            last = given;
        }
        assert!(last > 0.99 && probability_of_detection(-4.0, evidence(0), 0.95) <= 0.0);
        assert!(probability_of_detection(f64::NEG_INFINITY, evidence(1 << 40), 0.95) <= 0.0);
    }
}
