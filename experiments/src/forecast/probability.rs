//! A probability that is estimated from missions.

use serde::Serialize;

/// The 97.5 % quantile of the standard normal distribution: 95 % lie within this many deviations.
const DEVIATIONS: f64 = 1.959_964;

/// A probability that is estimated from missions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Probability {
    /// The estimate, 0 to 1.
    pub mean: f64,
    /// The lower end of its 95 % interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Probability {
    /// The mean of shares of 0 to 1, one for each mission, with the score interval of Wilson (JASA 1927) for as many
    /// trials as there are shares.
    ///
    /// It holds for missions that succeed or fail. Of all distributions on 0 to 1 with one mean these have the largest
    /// variance, so for shares of several objects it is rather too wide. Unlike the mean ± its standard error it does
    /// not shrink to a point where all missions succeed. `shares` must not be empty.
    pub(super) fn of(shares: impl Iterator<Item = f64>) -> Self {
        let (count, sum) = shares.fold((0.0, 0.0), |(count, sum), share| (count + 1.0, sum + share));
        let mean: f64 = sum / count;
        let squared = DEVIATIONS.powi(2) / count;
        let middle = (mean + squared / 2.0) / (1.0 + squared);
        let half =
            (squared * mean * (1.0 - mean) + (squared / 2.0).powi(2)).max(0.0).sqrt() / (1.0 + squared);
        Self { mean, low: (middle - half).clamp(0.0, mean), high: (middle + half).clamp(mean, 1.0) }
    }

    /// The probability of this and of something independent, whose probability is known.
    pub(super) fn times(self, known: f64) -> Self {
        Self { mean: self.mean * known, low: self.low * known, high: self.high * known }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(shares: &[f64], expected: [f64; 3]) {
        let Probability { mean, low, high } = Probability::of(shares.iter().copied());
        let is_close =
            [mean, low, high].iter().zip(expected).all(|(found, value)| (found - value).abs() < 5e-4);
        assert!(is_close, "{shares:?}: {mean} in {low} to {high}, not {expected:?}");
    }

    #[test]
    fn the_interval_is_that_of_wilson_and_never_a_point() {
        check(&[1.0; 10], [1.0, 0.7225, 1.0]);
        check(&[0.0; 10], [0.0, 0.0, 0.2775]);
        check(&[1.0], [1.0, 0.2065, 1.0]);
        check(&[[0.0; 5], [1.0; 5]].concat(), [0.5, 0.2366, 0.7634]);
        // Shares of several objects: as of missions with the same mean.
        check(&[0.5; 10], [0.5, 0.2366, 0.7634]);
    }

    #[test]
    fn what_lies_beyond_the_map_is_never_found() {
        let Probability { mean, low, high } = Probability::of([1.0; 10].into_iter()).times(0.5);
        assert!(mean.to_bits() == 0.5_f64.to_bits() && high.to_bits() == mean.to_bits(), "{mean} {high}");
        assert!((low - 0.36125).abs() < 5e-4, "{low}");
    }
}
