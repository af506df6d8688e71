//! Computing times of decisions.

use std::time::Duration;

/// Computing times of decisions, ascending.
pub struct Latencies {
    sorted: Vec<Duration>,
}

impl Latencies {
    /// Sorts the times of decisions.
    #[must_use]
    pub fn new(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        Self { sorted: times }
    }

    /// Number of decisions.
    #[must_use]
    pub fn count(&self) -> usize {
        self.sorted.len()
    }

    /// The given percentile of the times, milliseconds; `None` without a decision.
    #[must_use]
    pub fn percentile_ms(&self, percent: usize) -> Option<f64> {
        let rank = (self.sorted.len() * percent).div_ceil(100).max(1);
        self.sorted.get(rank - 1).map(|time| time.as_secs_f64() * 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_a_time_that_was_measured() {
        let latencies = Latencies::new((1..=200).rev().map(Duration::from_millis).collect());
        for (percent, expected) in [(0, 1.0), (50, 100.0), (99, 198.0), (100, 200.0)] {
            let found = latencies.percentile_ms(percent).unwrap();
            assert!((found - expected).abs() < 1e-9, "{percent}: {found}");
        }
        assert_eq!(Latencies::new(Vec::new()).percentile_ms(50), None);
        assert!(Latencies::new(vec![Duration::from_secs(1)]).percentile_ms(1).is_some());
    }
}
