//! Mission time, real or simulated.

use std::ops::Add;
use std::time::Duration;

/// Nanoseconds since the mission's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MissionTime(pub u64);

impl MissionTime {
    /// The mission's start.
    pub const START: Self = Self(0);

    /// Seconds since the mission's start.
    #[must_use]
    pub fn as_seconds(self) -> f64 {
        Duration::from_nanos(self.0).as_secs_f64()
    }

    /// The duration since an earlier time; zero if it is not earlier.
    #[must_use]
    pub fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Duration> for MissionTime {
    type Output = Self;

    fn add(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)))
    }
}
