//! Settings of the tracker.

use std::f64::consts::PI;

/// Settings of a tracker.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Range hypotheses of a new track, `1..=64`.
    pub range_hypotheses: u32,
    /// Standard deviation of each component of a new track's velocity, m/s, above 0. Its mean is 0.
    pub velocity_std: f64,
    /// Spectral density of the white acceleration, m^2/s^3, at least 0: its root is the standard deviation of a
    /// velocity's change in a second.
    pub acceleration_density: f64,
    /// Largest difference between a bearing and its track, radians, above 0 and at most pi; the uncertainty of the
    /// track is added.
    pub gate_radians: f64,
    /// A track is confirmed by this many detections in its first [`Settings::initial_frames`], at least 1.
    pub confirm_hits: u32,
    /// At least [`Settings::confirm_hits`]. The frame that begins a track is the first.
    pub initial_frames: u32,
    /// Misses in a row that end a confirmed track, at least 1.
    pub max_misses: u32,
    /// Time without a detection that ends any track, in view or not, seconds, above 0.
    pub track_timeout_seconds: f64,
    /// Probability that an object in view is missed in a frame, 0 to 0.95.
    pub miss_probability: f64,
    /// False detections per frame, above 0 and at most 100.
    pub false_alarms_per_frame: f64,
    /// Time over which pose errors persist, seconds, 0 to 3600: bearings within that time share them.
    pub pose_correlation_seconds: f64,
}

impl Default for Settings {
    /// For static objects that are detected some times per second.
    fn default() -> Self {
        Self {
            range_hypotheses: 6,
            velocity_std: 0.001,
            acceleration_density: 1e-8,
            gate_radians: 0.05,
            confirm_hits: 3,
            initial_frames: 5,
            max_misses: 10,
            track_timeout_seconds: 60.0,
            miss_probability: 0.2,
            false_alarms_per_frame: 0.05,
            pose_correlation_seconds: 1.0,
        }
    }
}

/// Why settings are invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The number of range hypotheses is not within `1..=64`.
    #[error("{0} range hypotheses of a track: allowed are 1 to 64")]
    RangeHypotheses(u32),
    /// A value out of its range.
    #[error("{name} = {value}: needed is {needed}")]
    Quantity {
        /// Name of the setting.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed values.
        needed: &'static str,
    },
    /// Tracks would never be confirmed, or lost at once.
    #[error(
        "{confirm_hits} of {initial_frames} frames confirm, {max_misses} misses lose: \
         needed is 1 <= hits <= frames, and at least one miss"
    )]
    Counts {
        /// The given value.
        confirm_hits: u32,
        /// The given value.
        initial_frames: u32,
        /// The given value.
        max_misses: u32,
    },
}

impl Settings {
    /// # Errors
    /// If a setting is out of its range.
    pub(crate) fn check(&self) -> Result<(), SettingsError> {
        if !(1..=64).contains(&self.range_hypotheses) {
            return Err(SettingsError::RangeHypotheses(self.range_hypotheses));
        }
        let quantity = |name, value: f64, is_good: bool, needed| {
            let is_good = is_good && value.is_finite();
            is_good.then_some(()).ok_or(SettingsError::Quantity { name, value, needed })
        };
        let (velocity, density) = (self.velocity_std, self.acceleration_density);
        let (gate, forgetting) = (self.gate_radians, self.track_timeout_seconds);
        quantity("velocity_std", velocity, velocity > 0.0 && velocity <= 1e3, "above 0 m/s, at most 1000")?;
        quantity("acceleration_density", density, (0.0..=1e6).contains(&density), "0 to 10^6 m^2/s^3")?;
        quantity("gate_radians", gate, gate > 0.0 && gate <= PI, "above 0, at most pi")?;
        quantity("track_timeout_seconds", forgetting, forgetting > 0.0, "above 0 seconds")?;
        let (miss, correlation) = (self.miss_probability, self.pose_correlation_seconds);
        quantity("miss_probability", miss, (0.0..=0.95).contains(&miss), "0 to 0.95")?;
        let alarms = self.false_alarms_per_frame;
        quantity("false_alarms_per_frame", alarms, alarms > 0.0 && alarms <= 100.0, "above 0, at most 100")?;
        let is_good = (0.0..=3600.0).contains(&correlation);
        quantity("pose_correlation_seconds", correlation, is_good, "0 to 3600 seconds")?;
        let Self { confirm_hits, initial_frames, max_misses, .. } = *self;
        if confirm_hits == 0 || confirm_hits > initial_frames || max_misses == 0 {
            return Err(SettingsError::Counts { confirm_hits, initial_frames, max_misses });
        }
        Ok(())
    }
}
