//! Times, and their quantiles.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// How long this takes, and what it returns.
pub(crate) fn time<T>(work: impl FnOnce() -> T) -> (Duration, T) {
    let start = Instant::now();
    let result = black_box(work());
    (start.elapsed(), result)
}

/// Times of decisions, ascending.
pub(crate) struct Times(pub(crate) Vec<Duration>);

impl Times {
    pub(crate) fn of(times: impl IntoIterator<Item = Duration>) -> Self {
        let mut times: Vec<Duration> = times.into_iter().collect();
        times.sort_unstable();
        Self(times)
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    pub(crate) fn quantile(&self, share: f64) -> Duration {
        self.0[((self.0.len() - 1) as f64 * share) as usize]
    }

    /// Number, median, 95th percentile and maximum.
    pub(crate) fn row(&self) -> String {
        let [median, high, longest] = [0.5, 0.95, 1.0].map(|share| milliseconds(self.quantile(share)));
        format!("{} | {median} | {high} | {longest}", self.0.len())
    }
}

/// As the tables have it.
pub(crate) fn milliseconds(duration: Duration) -> String {
    format!("{:.3}", duration.as_secs_f64() * 1e3)
}
