//! The error of a vehicle's pose, which its bearings share.

/// How far off a vehicle's pose may be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseError {
    /// Standard deviation of the heading, radians, at least 0.
    pub heading_std_radians: f64,
    /// Standard deviation of the place, meters, at least 0.
    pub position_std_meters: f64,
    /// Poses within this time are off alike, seconds, at least 0.
    pub correlation_seconds: f64,
}

impl PoseError {
    /// What a bearing adds that is taken so long after another one of the same thing. Errors that last
    /// `t` seconds are taken in as white ones of equal power: of `n` bearings in that time each is taken to be
    /// `n` times as vague (in its variance) as the pose, so that together they tell what one pose tells.
    #[must_use]
    pub fn after(&self, elapsed_seconds: f64) -> Self {
        const MOST: f64 = 1e4;
        let times = (self.correlation_seconds / elapsed_seconds.max(1e-9)).clamp(1.0, MOST).sqrt();
        Self {
            heading_std_radians: self.heading_std_radians * times,
            position_std_meters: self.position_std_meters * times,
            correlation_seconds: self.correlation_seconds,
        }
    }

    /// Variance of the bearing to a thing at a range, radians squared; the place counts as it is seen from
    /// there.
    #[must_use]
    pub fn bearing_variance(&self, range_meters: f64) -> f64 {
        let lever = self.position_std_meters.atan2(range_meters);
        self.heading_std_radians.powi(2) + lever.powi(2)
    }

    pub(super) fn is_sound(&self) -> bool {
        let Self { heading_std_radians, position_std_meters, correlation_seconds } = *self;
        [heading_std_radians, position_std_meters, correlation_seconds]
            .into_iter()
            .all(|value| value >= 0.0 && value.is_finite())
    }
}
