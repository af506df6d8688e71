//! The sensor: which cells an observation covers, how noisy it is there, and how readings are drawn.
//!
//! One type draws readings in the simulator and explains them in the belief. It is radially symmetric: the variance of a reading
//! depends on the Manhattan distance of its cell alone.

use rand_distr::{Distribution, StandardNormal};

use crate::cell::Offset;
use crate::evidence::{MAX_VARIANCE, MIN_VARIANCE, precision_units};
use crate::seed::Stream;

/// Distribution of a reading given the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// `y = theta + N(0, v)`: the model that the belief assumes.
    Gaussian,
    /// `y = min(|N(0, v)|, 1)` of an empty cell, `max(1 - |N(0, v)|, 0)` of an object: as the released code of
    /// NATS (Ghods, Durkin and Schneider, ICRA 2021) draws them. The belief still assumes the Gaussian.
    Clipped,
}

/// An omnidirectional sensor that sees all cells within a Manhattan radius.
///
/// The variance of a reading at distance `d` (cells) is `v(d) = noise_variance d^2`, and `v(0) = noise_variance / 5`: the rings of
/// GUTS (Bakshi et al., ICRA 2023), continued beyond its third.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    radius: u32,
    noise_variance: f64,
    noise: Noise,
    footprint: Vec<FootprintCell>,
}

/// One cell of the sensor's footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootprintCell {
    /// From the robot's cell to the observed cell.
    pub offset: Offset,
    /// Variance of a reading there.
    pub variance: f32,
    /// Precision that a reading there adds to its cell, units of 1/65,536.
    pub precision: i64,
}

/// Why a sensor is invalid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// The radius is 0 or above [`Sensor::MAX_RADIUS`].
    #[error("sensor radius {0} cells: allowed are 1 to {max}", max = Sensor::MAX_RADIUS)]
    Radius(u32),
    /// A variance is outside the range of [`crate::evidence`].
    #[error(
        "sensor variance noise_variance = {noise_variance}: variances over the radius go from {nearest} to {farthest}, allowed are {MIN_VARIANCE} to {MAX_VARIANCE}"
    )]
    Variance {
        /// The given value.
        noise_variance: f64,
        /// At distance 0.
        nearest: f64,
        /// At the radius.
        farthest: f64,
    },
}

impl Sensor {
    /// The widest sensor, cells.
    pub const MAX_RADIUS: u32 = 100;
    /// `noise_variance` of NATS and GUTS.
    pub const DEFAULT_NOISE_VARIANCE: f64 = 0.005;
    /// Radius of the paper's robot as we assume it, cells: the paper gives none.
    pub const DEFAULT_RADIUS: u32 = 5;

    /// A sensor of a radius (cells) and of the variance `noise_variance` at distance 1.
    ///
    /// # Errors
    /// If the radius is 0 or above [`Sensor::MAX_RADIUS`], or a variance leaves the range of [`crate::evidence`].
    pub fn new(radius: u32, noise_variance: f64, noise: Noise) -> Result<Self, SensorError> {
        if !(1..=Self::MAX_RADIUS).contains(&radius) {
            return Err(SensorError::Radius(radius));
        }
        let (nearest, farthest) =
            (noise_variance / 5.0, noise_variance * f64::from(radius * radius).max(1.0));
        // Written so that NaN fails as well.
        if !(nearest >= f64::from(MIN_VARIANCE) && farthest <= f64::from(MAX_VARIANCE)) {
            return Err(SensorError::Variance { noise_variance, nearest, farthest });
        }
        Ok(Self { radius, noise_variance, noise, footprint: footprint(radius, noise_variance) })
    }

    /// Manhattan radius, cells.
    #[must_use]
    pub const fn radius(&self) -> u32 {
        self.radius
    }

    /// Variance of a reading at distance 1.
    #[must_use]
    pub const fn noise_variance(&self) -> f64 {
        self.noise_variance
    }

    /// How a reading scatters around the truth.
    #[must_use]
    pub const fn noise(&self) -> Noise {
        self.noise
    }

    /// Variance of a reading at a distance in cells.
    #[must_use]
    pub fn variance(&self, distance: u32) -> f32 {
        variance(self.noise_variance, distance)
    }

    /// All cells of an observation, south to north, then west to east.
    #[must_use]
    pub fn footprint(&self) -> &[FootprintCell] {
        &self.footprint
    }

    /// The footprint in rings of equal distance, from 0 on, whose cells have equal precision.
    pub(crate) fn rings(&self) -> impl Iterator<Item = Vec<FootprintCell>> {
        (0..=self.radius).map(|distance| {
            self.footprint
                .iter()
                .filter(|observation| observation.offset.manhattan() == distance)
                .copied()
                .collect()
        })
    }

    /// Draws the value of a reading of this footprint cell.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "readings travel as f32")]
    #[inline]
    pub fn draw(&self, is_object: bool, observation: &FootprintCell, random: &mut Stream) -> f32 {
        let normal: f64 = StandardNormal.sample(random);
        let error = normal * f64::from(observation.variance).sqrt();
        let value = match (self.noise, is_object) {
            (Noise::Gaussian, _) => f64::from(u8::from(is_object)) + error,
            (Noise::Clipped, false) => error.abs().min(1.0),
            (Noise::Clipped, true) => (1.0 - error.abs()).max(0.0),
        };
        value as f32
    }
}

impl Default for Sensor {
    fn default() -> Self {
        let (radius, noise_variance) = (Self::DEFAULT_RADIUS, Self::DEFAULT_NOISE_VARIANCE);
        Self { radius, noise_variance, noise: Noise::Gaussian, footprint: footprint(radius, noise_variance) }
    }
}

/// The sensor model: the variance of a reading at a distance (cells), for a sensor with this `noise_variance`.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "variances travel as f32")]
pub fn variance(noise_variance: f64, distance: u32) -> f32 {
    match distance {
        0 => (noise_variance / 5.0) as f32,
        _ => (noise_variance * f64::from(distance * distance)) as f32,
    }
}

fn footprint(radius: u32, noise_variance: f64) -> Vec<FootprintCell> {
    let observed = |offset: Offset| {
        let variance = variance(noise_variance, offset.manhattan());
        FootprintCell { offset, variance, precision: precision_units(variance) }
    };
    Offset::within(radius).map(observed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::{Purpose, stream};

    #[test]
    fn the_footprint_is_a_diamond_with_the_published_variances() {
        let sensor = Sensor::default();
        assert_eq!(sensor.footprint().len(), 61);
        assert!((sensor.variance(0) - 0.001).abs() < 1e-9);
        assert!((sensor.variance(3) - 0.045).abs() < 1e-9);
        assert!(sensor.footprint().iter().all(|observation| observation.offset.manhattan() <= 5));
    }

    #[test]
    fn readings_scatter_as_in_the_model() {
        let sensor = Sensor::default();
        let observation = sensor.footprint()[0];
        let mut random = stream(3, Purpose::Noise, 0);
        let count = 20_000;
        let draws: Vec<f64> =
            (0..count).map(|_| f64::from(sensor.draw(true, &observation, &mut random))).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(count);
        let variance = draws.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / f64::from(count);
        assert!((mean - 1.0).abs() < 0.01, "{mean}");
        assert!((variance - 0.125).abs() < 0.005, "{variance}");
    }

    #[test]
    fn clipped_readings_stay_between_empty_and_object() {
        let sensor = Sensor::new(20, 0.005, Noise::Clipped).unwrap();
        let observation = sensor.footprint()[0];
        let mut random = stream(3, Purpose::Noise, 0);
        for is_object in [false, true] {
            for _ in 0..1000 {
                let value = sensor.draw(is_object, &observation, &mut random);
                assert!((0.0..=1.0).contains(&value));
            }
        }
    }

    #[test]
    fn impossible_sensors_are_rejected() {
        assert_eq!(Sensor::new(0, 0.005, Noise::Gaussian), Err(SensorError::Radius(0)));
        assert!(Sensor::new(5, f64::NAN, Noise::Gaussian).is_err());
        assert!(Sensor::new(5, 1e-9, Noise::Gaussian).is_err());
    }
}
