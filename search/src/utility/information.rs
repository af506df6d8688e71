//! The information of an observation.
//!
//! A cell of log-odds `L` that is observed with total precision `k` yields the mutual information of a Bernoulli
//! variable through a Gaussian channel,
//!
//! ```text
//! I(L, k) = H(L) - E_y[H(L + k (y - 1/2))],    y | theta ~ N(theta, 1/k).
//! ```
//!
//! No closed form is known.

use super::LOG_ODDS;
use crate::belief::entropy_nats;

/// `I(L, k)` of one precision at every step of the axis of log-odds, nats.
///
/// The expectation is a trapezoidal sum over a uniform grid of posterior log-odds, which for a Gaussian weight
/// converges faster than any power of the step. All rows share the grid, and so the entropies on it.
pub(super) fn column(precision: f64) -> Vec<f64> {
    let log_odds = (0..=LOG_ODDS.steps()).map(|step| LOG_ODDS.value(step));
    if precision <= 0.0 {
        return log_odds.map(|_| 0.0).collect();
    }
    let deviation = precision.sqrt();
    let step = (deviation / 4.0).min(0.25);
    let reach = LOG_ODDS.value(LOG_ODDS.steps()) + precision / 2.0 + TAIL_DEVIATIONS * deviation;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand")]
    let half = (reach / step).ceil() as usize + 1;
    let entropies: Vec<f64> = (0..=half).map(|index| entropy_nats(index as f64 * step)).collect();
    let posterior = PosteriorEntropy { entropies, step, deviation };
    log_odds
        .map(|log_odds| {
            let object = 1.0 / (1.0 + (-log_odds).exp());
            let expected = object * posterior.mean(log_odds + precision / 2.0)
                + (1.0 - object) * posterior.mean(log_odds - precision / 2.0);
            (entropy_nats(log_odds) - expected).max(0.0)
        })
        .collect()
}

/// Number of deviations beyond which a Gaussian weighs less than 1e-15.
const TAIL_DEVIATIONS: f64 = 8.0;

struct PosteriorEntropy {
    /// Entropy at `index * step`; it is even, so half of the axis serves all of it.
    entropies: Vec<f64>,
    /// Step of the grid of log-odds, nats.
    step: f64,
    /// Deviation of the posterior log-odds, nats.
    deviation: f64,
}

impl PosteriorEntropy {
    /// `E[H(x)]` for `x ~ N(mean, deviation^2)`. Successive Gaussian weights are in a ratio that itself falls
    /// geometrically, so that one weight costs two products.
    fn mean(&self, mean: f64) -> f64 {
        let scale = self.step / self.deviation;
        let first = ((mean - TAIL_DEVIATIONS * self.deviation) / self.step).ceil();
        let start = first * scale - mean / self.deviation;
        let mut weight = (-start * start / 2.0).exp();
        let mut ratio = (-scale * (start + scale / 2.0)).exp();
        let fall = (-scale * scale).exp();
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand")]
        let (first, count) = (first as isize, (2.0 * TAIL_DEVIATIONS / scale) as isize);
        let mut sum = 0.0;
        for index in first..first + count {
            sum += weight * self.entropies[index.unsigned_abs()];
            weight *= ratio;
            ratio *= fall;
        }
        sum * scale / (2.0 * std::f64::consts::PI).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::evidence::UNITS;
    use crate::utility::UtilityTable;

    /// `I(L, k)` by 64-point Gauss-Hermite quadrature of the log-likelihood form
    /// `I = h(p) - p E[ln(1 + e^-(L + l))] - (1 - p) E[ln(1 + e^(L - l))]`, `l = k/2 + sqrt(k) z`.
    fn reference(log_odds: f64, precision: f64) -> f64 {
        let softplus = |x: f64| if x > 30.0 { x } else { x.exp().ln_1p() };
        let object = 1.0 / (1.0 + (-log_odds).exp());
        let loss = hermite(64, |z| {
            let l = precision / 2.0 + precision.sqrt() * z;
            object * softplus(-(log_odds + l)) + (1.0 - object) * softplus(log_odds - l)
        });
        entropy_nats(log_odds) - loss
    }

    /// `E[f(z)]`, `z ~ N(0, 1)`: nodes are the eigenvalues of the Jacobi matrix (Golub and Welsch, 1969).
    fn hermite(points: usize, f: impl Fn(f64) -> f64) -> f64 {
        let jacobi = nalgebra::DMatrix::from_fn(points, points, |i, j| {
            if i.abs_diff(j) == 1 { f64::from(u32::try_from(i.max(j)).unwrap()).sqrt() } else { 0.0 }
        });
        let eigen = jacobi.symmetric_eigen();
        (0..points).map(|i| eigen.eigenvectors[(0, i)].powi(2) * f(eigen.eigenvalues[i])).sum()
    }

    fn table(log_odds: f64, precision: f64) -> f64 {
        let table = UtilityTable::information();
        #[expect(clippy::cast_possible_truncation)]
        let units = (precision * UNITS) as i32;
        f64::from(table.utility(table.row(log_odds), units))
    }

    #[test]
    fn the_table_agrees_with_quadrature_everywhere() {
        let mut worst = (0.0, 0.0, 0.0);
        let hermite_nodes = 1.0_f64;
        assert!((hermite(64, |z| z * z) - hermite_nodes).abs() < 1e-12);
        for step in 0..=248 {
            let log_odds = f64::from(step) * 0.125 + 0.03;
            for scale in 0..28 {
                let precision = 0.013 * 1.4_f64.powi(scale);
                let error = (table(log_odds, precision) - reference(log_odds, precision)).abs();
                if error > worst.0 {
                    worst = (error, log_odds, precision);
                }
            }
        }
        assert!(worst.0 < 1e-4, "error {} at log-odds {}, precision {}", worst.0, worst.1, worst.2);
    }

    #[test]
    fn endless_precision_yields_all_the_entropy() {
        let saturated = table(-3.0, 1000.0);
        assert!((saturated - entropy_nats(3.0)).abs() < 1e-5, "{saturated}");
    }

    proptest! {
        #[test]
        fn more_precision_never_yields_less(
            log_odds in -32.0_f64..32.0, precision in 0.0_f64..200.0, more in 0.0_f64..50.0,
        ) {
            prop_assert!(table(log_odds, precision + more) >= table(log_odds, precision) - 1e-6);
        }
    }
}
