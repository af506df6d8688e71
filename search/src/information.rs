//! The information table: information gain by log-odds and precision.
//!
//! A cell of log-odds `L` that is observed with total precision `k` yields the mutual information of a Bernoulli
//! variable through a Gaussian channel,
//!
//! ```text
//! I(L, k) = H(L) - E_y[H(L + k (y - 1/2))],    y | theta ~ N(theta, 1/k).
//! ```
//!
//! No closed form is known. Readings of one cell are independent given what it holds, so the information of any set of
//! observations depends on their summed precision only, and one table of two axes serves every policy.

use std::sync::LazyLock;

use crate::belief::entropy_nats;

/// `I(L, k)` by bilinear interpolation over `|L|` and `k`; the error is below 1e-4 nat everywhere.
///
/// Both axes are linear within an octave of `1 + x` and double their step with each, so that index and fraction are
/// the exponent and mantissa of one floating-point number: no logarithm is taken in a lookup.
#[derive(Debug)]
pub struct InformationTable {
    /// Bilinear coefficients `[constant, k, L, k L]` of each patch, row-major, rows by `|L|`.
    patches: Vec<[f32; 4]>,
}

/// Where log-odds fall on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Index of the row's first patch.
    start: u32,
    /// `0.0..1.0` within the row.
    fraction: f32,
}

impl Row {
    /// Cells of this row can yield nothing.
    #[must_use]
    pub const fn is_certain(self) -> bool {
        self.start == LOG_ODDS.certain()
    }
}

/// From this precision on (units of evidence) a cell is as good as known: more of it adds below 1e-6 nat.
pub const SATURATION: i32 = 127 << 16;

/// A precision of 1, in units of evidence.
const ONE: f32 = 65_536.0;

/// An axis of `octaves` octaves of `1 + x`, each of `2^bits` equal steps.
struct Axis {
    octaves: u32,
    bits: u32,
}

/// `|L|` from 0 to 31, where the entropy is 1e-12 nat.
const LOG_ODDS: Axis = Axis { octaves: 5, bits: 6 };
/// `k` from 0 to 127.
const PRECISION: Axis = Axis { octaves: 7, bits: 5 };

impl Axis {
    const fn steps(&self) -> u32 {
        self.octaves << self.bits
    }

    /// The row that is all zero: the one past the last step of the axis of log-odds.
    const fn certain(&self) -> u32 {
        self.steps() * PRECISION.steps()
    }

    /// Step and fraction of `base + x base`, where `base` is a power of 2 and `0 <= x < 2^octaves - 1`.
    fn place(&self, shifted: f32, base: f32) -> (u32, f32) {
        let shift = f32::MANTISSA_DIGITS - 1 - self.bits;
        let bits = shifted.to_bits() - base.to_bits();
        let mask = (1 << shift) - 1;
        let fraction = (bits & mask) as f32 / (1_u32 << shift) as f32;
        (bits >> shift, fraction)
    }

    /// Value at the lower end of a step.
    fn value(&self, step: u32) -> f64 {
        let within = f64::from(step & ((1 << self.bits) - 1)) / f64::from(1_u32 << self.bits);
        f64::from(1_u32 << (step >> self.bits)) * (1.0 + within) - 1.0
    }
}

impl InformationTable {
    /// The one table, built on first use.
    #[must_use]
    pub fn shared() -> &'static Self {
        static TABLE: LazyLock<InformationTable> = LazyLock::new(InformationTable::build);
        &TABLE
    }

    /// Builds the one table, which all decisions share, so that the first one is not measured with it.
    pub fn warm_up() {
        let _ = Self::shared();
    }

    /// Builds the table by quadrature.
    #[must_use]
    pub fn build() -> Self {
        let columns: Vec<Vec<f64>> =
            (0..=PRECISION.steps()).map(|step| column(PRECISION.value(step))).collect();
        let mut patches = Vec::new();
        for row in 0..LOG_ODDS.steps() as usize {
            for pair in columns.windows(2) {
                let (low, high) = (&pair[0], &pair[1]);
                let corner = low[row];
                let (along_k, along_l) = (high[row] - corner, low[row + 1] - corner);
                let across = high[row + 1] - corner - along_k - along_l;
                #[expect(clippy::cast_possible_truncation, reason = "f32 holds 1e-7 of a nat")]
                patches.push([corner, along_k, along_l, across].map(|value| value as f32));
            }
        }
        patches.resize(patches.len() + PRECISION.steps() as usize, [0.0; 4]);
        Self { patches }
    }

    /// The row of log-odds (nats).
    #[must_use]
    pub fn row(&self, log_odds_nats: f64) -> Row {
        #[expect(clippy::cast_possible_truncation, reason = "a position on the axis")]
        let shifted = (1.0 + log_odds_nats.abs()) as f32;
        // NaN, which no belief holds, would count as certain.
        if shifted.is_nan() || shifted >= (1_u32 << LOG_ODDS.octaves) as f32 {
            return Row { start: LOG_ODDS.certain(), fraction: 0.0 };
        }
        let (step, fraction) = LOG_ODDS.place(shifted, 1.0);
        Row { start: step * PRECISION.steps(), fraction }
    }

    /// Information of an observation of this total precision (units of evidence, from 0; all above [`SATURATION`] are
    /// equal), nats.
    #[must_use]
    #[inline]
    pub fn information(&self, row: Row, precision: i32) -> f32 {
        let shifted = (precision.min(SATURATION - 1) as f32) + ONE;
        let (step, fraction) = PRECISION.place(shifted, ONE);
        let [constant, along_k, along_l, across] = self.patches[(row.start + step) as usize];
        constant + fraction * along_k + row.fraction * (along_l + fraction * across)
    }
}

/// `I(L, k)` of one precision at every step of the axis of log-odds, nats.
///
/// The expectation is a trapezoidal sum over a uniform grid of posterior log-odds, which for a Gaussian weight
/// converges faster than any power of the step. All rows share the grid, and so the entropies on it.
fn column(precision: f64) -> Vec<f64> {
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
        let table = InformationTable::shared();
        #[expect(clippy::cast_possible_truncation)]
        let units = (precision * UNITS) as i32;
        f64::from(table.information(table.row(log_odds), units))
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
    fn a_certain_cell_yields_nothing() {
        let table = InformationTable::shared();
        for log_odds in [f64::NEG_INFINITY, f64::INFINITY, 31.0, -40.0, f64::NAN] {
            let row = table.row(log_odds);
            assert!(row.is_certain());
            assert!(table.information(row, SATURATION).abs() < f32::MIN_POSITIVE);
        }
        assert!(!table.row(30.9).is_certain());
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
