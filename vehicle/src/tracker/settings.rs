//! How a tracker behaves.

use std::f64::consts::PI;

/// Settings of a tracker.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Members of a new track, each with its own part of the ranges, `1..=64`.
    pub range_hypotheses: u32,
    /// Standard deviation of each component of a new track's velocity, m/s, above 0. Its mean is 0.
    pub velocity_std: f64,
    /// Spectral density of the white acceleration, m^2/s^3, at least 0: in a second a velocity wanders by its
    /// root.
    pub acceleration_density: f64,
    /// A bearing may be so far from where its track is expected, radians, above 0 and at most pi; and as much
    /// farther as it is not known where that is.
    pub gate_radians: f64,
    /// A track is confirmed once it is seen in so many of its first [`Settings::initial_frames`], at least 1.
    pub confirm_hits: u32,
    /// See there; at least [`Settings::confirm_hits`]. The frame that begins a track is the first.
    pub initial_frames: u32,
    /// A confirmed track is lost after so many misses in a row, at least 1.
    pub max_misses: u32,
    /// Any track is lost when it was not seen for so long, in view or not, seconds, above 0.
    pub track_timeout_seconds: f64,
    /// In a frame a thing in view is missed with this probability, 0 to 0.95.
    pub miss_probability: f64,
    /// So many detections of a frame are of nothing, above 0 and at most 100.
    pub false_alarms_per_frame: f64,
    /// Errors of poses last so long, seconds, 0 to 3600: bearings within that time share them.
    pub pose_correlation_seconds: f64,
}

impl Default for Settings {
    /// For things that lie where they are, seen some times a second.
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

/// Settings that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// None, or so many that an equal share is next to nothing.
    #[error("{0} range hypotheses of a track: allowed are 1 to 64")]
    RangeHypotheses(u32),
    /// A quantity out of its range.
    #[error("{name} = {value}: needed is {needed}")]
    Quantity {
        /// Of the setting.
        name: &'static str,
        /// As given.
        value: f64,
        /// What is allowed.
        needed: &'static str,
    },
    /// Never confirmed, or at once lost.
    #[error(
        "{confirm_hits} of {initial_frames} looks confirm, {max_misses} misses lose: \
         needed is 1 <= hits <= looks, and at least one miss"
    )]
    Counts {
        /// As given.
        confirm_hits: u32,
        /// As given.
        initial_frames: u32,
        /// As given.
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
