//! The error of a vehicle's pose, which its bearings share.

/// The error of a vehicle's pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseError {
    /// Standard deviation of the heading, radians, at least 0.
    pub heading_std_radians: f64,
    /// Standard deviation of the position, meters, at least 0.
    pub position_std_meters: f64,
    /// Time within which poses share their error, seconds, at least 0.
    pub correlation_seconds: f64,
}

impl PoseError {
    /// The error that a bearing adds this long after another one of the same object. Errors that last `t` seconds are
    /// modeled as white ones of equal power: each of `n` bearings in that time has `n` times the variance of the pose,
    /// so that together they carry the information of one pose.
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

    /// Variance of the bearing to an object at a range, radians squared, including that of the position.
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
