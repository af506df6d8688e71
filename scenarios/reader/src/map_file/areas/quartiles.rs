//! The distribution of a distance by its quartiles, as statistics of lost person behavior give them.
//!
//! Tables of found subjects state the distances within which 25, 50, 75 and 95 % of them were found: from the last known
//! position, or from the nearest linear feature, such as a trail, which they call track offset (Koester, Lost Person
//! Behavior, 2008). Between these points the logarithm of the distance is linear in the normal quantile,
//!
//! ```text
//! F(d) = Phi(z(ln d)),      z(ln d_i) = Phi^-1(0.25, 0.5, 0.75, 0.95)
//! ```
//!
//! so that the four shares are exact, and the distribution is log-normal where the four points are those of one. Beyond them
//! the first and last lines go on.

use std::fmt;

/// Normal quantiles of 25, 50, 75 and 95 %.
const QUANTILES: [f64; 4] = [-0.674_489_750_196_081_7, 0.0, 0.674_489_750_196_081_7, 1.644_853_626_951_472_2];
/// The longest distance, meters.
const LONGEST_METERS: f64 = 100_000.0;

/// The distances within which 25, 50, 75 and 95 % of the subjects are found, meters: above 0, each above the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quartiles([f64; 4]);

impl Quartiles {
    /// What is allowed, for messages.
    pub(super) const ALLOWED: &str = "four distances in meters, within which 25, 50, 75 and 95 % are found, such as \
                                      \"40, 150, 400, 1200\": each above the one before, from above 0 to 100000";

    /// Distances in meters, if they are allowed.
    #[must_use]
    pub fn new(meters: [f64; 4]) -> Option<Self> {
        let is_allowed = meters[0] > 0.0 && meters[3] <= LONGEST_METERS;
        // Written so that NaN fails as well.
        (is_allowed && meters.windows(2).all(|pair| pair[0] < pair[1])).then_some(Self(meters))
    }

    /// Four numbers, separated by commas or spaces; brackets around them are allowed.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let inside = text.trim().trim_start_matches('[').trim_end_matches(']');
        let words = inside.split([',', ';', ' ']).map(str::trim).filter(|word| !word.is_empty());
        let meters: Vec<f64> = words.map(|word| word.parse().ok()).collect::<Option<_>>()?;
        Self::new(meters.try_into().ok()?)
    }

    /// The distances, meters.
    #[must_use]
    pub const fn meters(&self) -> [f64; 4] {
        self.0
    }

    /// The share that is found within a distance, `F(d)`, 0 to 1.
    #[must_use]
    pub fn share_within(&self, meters: f64) -> f64 {
        if meters <= 0.0 {
            return 0.0;
        }
        let after = self.0.iter().position(|&known| meters < known).unwrap_or(3).clamp(1, 3);
        let (low, high) = (self.0[after - 1].ln(), self.0[after].ln());
        let along = (meters.ln() - low) / (high - low);
        let quantile = QUANTILES[after - 1] + along * (QUANTILES[after] - QUANTILES[after - 1]);
        0.5 * libm::erfc(-quantile / std::f64::consts::SQRT_2)
    }
}

impl fmt::Display for Quartiles {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second, third, last] = self.0;
        write!(formatter, "{first}, {second}, {third}, {last}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_entered_shares_are_exact_and_the_others_lie_between_them() {
        for meters in [[40.0, 150.0, 400.0, 1200.0], [1.0, 2.0, 3.0, 90_000.0], [15.0, 16.0, 700.0, 701.0]] {
            let quartiles = Quartiles::new(meters).unwrap();
            for (distance, share) in meters.into_iter().zip([0.25, 0.5, 0.75, 0.95]) {
                assert!((quartiles.share_within(distance) - share).abs() < 1e-9, "{meters:?} {distance}");
            }
            let shares: Vec<f64> = (0..4000).map(|step| quartiles.share_within(f64::from(step))).collect();
            assert!(shares.is_sorted() && shares[0] <= 0.0 && quartiles.share_within(1e7) > 0.95);
        }
    }

    #[test]
    fn points_of_a_log_normal_give_it_back() {
        let (median, sigma) = (300.0_f64, 0.9);
        let at = |quantile: f64| median * (sigma * quantile).exp();
        let quartiles = Quartiles::new(QUANTILES.map(at)).unwrap();
        for quantile in [-2.5_f64, -1.0, -0.2, 0.3, 1.2, 2.4] {
            let expected = 0.5 * libm::erfc(-quantile / std::f64::consts::SQRT_2);
            assert!((quartiles.share_within(at(quantile)) - expected).abs() < 1e-9, "{quantile}");
        }
    }

    #[test]
    fn texts_are_four_ascending_distances() {
        let expected = Quartiles::new([40.0, 150.0, 400.5, 1200.0]);
        assert!(expected.is_some());
        for text in ["40, 150, 400.5, 1200", "[40,150,400.5,1200]", "40 150 400.5 1200", "40;150;400.5;1200"]
        {
            assert_eq!(Quartiles::parse(text), expected, "{text}");
        }
        assert_eq!(Quartiles::parse(&expected.unwrap().to_string()), expected);
        for text in [
            "",
            "40",
            "40, 150, 400",
            "1,2,3,4,5",
            "0,1,2,3",
            "1,1,2,3",
            "4,3,2,1",
            "1,2,3,nan",
            "1,2,3,1e6",
            "a,b,c,d",
        ] {
            assert_eq!(Quartiles::parse(text), None, "{text}");
        }
    }
}
