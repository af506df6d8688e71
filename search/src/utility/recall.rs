//! The expected recall of an observation.
//!
//! Readings of total precision `k` of a cell with an object add `N(k/2, k)` to its log-odds `L`. They bring them to the
//! detection threshold `theta` with probability `Phi((L + k/2 - theta) / sqrt k)`, so that they are expected to find
//!
//! ```text
//! R(L, k) = p(L) Phi((L + k/2 - theta) / sqrt k)
//! ```
//!
//! objects. A cell that is found already yields none: that further readings may take its object back is not counted, so
//! that a robot never avoids what it found.

use std::f64::consts::SQRT_2;

use super::LOG_ODDS;

/// Log-odds of a probability, nats.
pub(crate) fn log_odds_nats(probability: f64) -> f64 {
    libm::log(probability / (1.0 - probability))
}

/// `R(L, k)` of one precision at every step of the axis of log-odds of this sign. Above the threshold, where cells yield
/// nothing, it goes on smoothly, for interpolation next to it.
pub(super) fn column(found_nats: f64, sign: f64, precision: f64) -> Vec<f64> {
    (0..=LOG_ODDS.steps())
        .map(|step| {
            let log_odds_nats = sign * LOG_ODDS.value(step);
            let probability = 1.0 / (1.0 + libm::exp(-log_odds_nats));
            if precision <= 0.0 {
                return 0.0;
            }
            probability * found(log_odds_nats.min(found_nats), precision, found_nats)
        })
        .collect()
}

/// Probability that readings of this total precision bring the log-odds of a cell with an object to a threshold.
pub(crate) fn found(log_odds_nats: f64, precision: f64, found_nats: f64) -> f64 {
    if precision <= 0.0 {
        return f64::from(u8::from(log_odds_nats >= found_nats));
    }
    let deviations = (log_odds_nats + precision / 2.0 - found_nats) / precision.sqrt();
    libm::erfc(-deviations / SQRT_2) / 2.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand_distr::{Distribution, Normal};

    use crate::evidence::UNITS;
    use crate::seed::{Purpose, stream};
    use crate::utility::UtilityTable;

    const TAU: f64 = 0.95;

    fn table(table: &UtilityTable, log_odds: f64, precision: f64) -> f64 {
        #[expect(clippy::cast_possible_truncation)]
        let units = (precision * UNITS) as i32;
        f64::from(table.utility(table.row(log_odds), units))
    }

    #[test]
    fn the_table_agrees_with_readings_that_are_drawn() {
        let recall = UtilityTable::recall(TAU);
        let mut random = stream(3, Purpose::Noise, 1);
        for (log_odds, precision) in
            [(-4.6, 12.0), (-4.6, 30.0), (-1.4, 4.0), (0.0, 1.0), (1.5, 8.0), (2.7, 0.5)]
        {
            let probability = 1.0 / (1.0 + f64::exp(-log_odds));
            let reading = Normal::new(1.0, 1.0 / f64::sqrt(precision)).unwrap();
            let count = 40_000;
            let threshold = f64::ln(TAU / (1.0 - TAU));
            let is_found = |value: f64| log_odds + precision * (value - 0.5) >= threshold;
            let hits = (0..count).filter(|_| is_found(reading.sample(&mut random))).count();
            let drawn = probability * hits as f64 / f64::from(count);
            assert!(
                (table(&recall, log_odds, precision) - drawn).abs() < 0.01,
                "{log_odds} {precision}: {drawn}"
            );
        }
    }

    proptest! {
        #[test]
        fn more_precision_never_finds_less_and_never_more_than_there_is(
            log_odds in -30.0_f64..2.9, precision in 0.0_f64..126.0, more in 0.0_f64..50.0,
        ) {
            let recall = UtilityTable::recall(TAU);
            let (less, more) =
                (table(&recall, log_odds, precision), table(&recall, log_odds, precision + more));
            prop_assert!(more >= less - 1e-6 && less >= 0.0);
            prop_assert!(more <= 1.0 / (1.0 + f64::exp(-log_odds)) + 1e-3);
        }
    }
}
