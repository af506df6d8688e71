//! Fits the sensor model to readings with known truth.
//!
//! The model is that of [`dragnet_search::sensor::Sensor`]: a reading of a cell at distance `d` (cells) is
//! `theta + N(0, v(d))`, with `v(d) = noise_variance d^2` from distance 1 on, and a constant `v(0)` for the own cell.
//! So every `u = ((value - theta) / d)^2` has the mean `noise_variance`, and their average is its maximum-likelihood
//! estimate.
//!
//! Its standard error is that of an average, from the spread of the `u` themselves: for normal errors that is
//! `noise_variance sqrt(2 / n)`, and for errors with heavier tails it is correctly larger. Readings are assumed to be
//! independent: frames of the same object from the same place are not, and make the error seem smaller than it is.

use std::collections::BTreeMap;

use dragnet_search::evidence::MAX_VALUE;
use dragnet_search::sensor::Sensor;

/// The minimum number of readings from distance 1 on, and of those at distance 0 for the own cell.
pub const MIN_READINGS: usize = 30;
/// The minimum number of distances from 1 on: one alone cannot test the model.
pub const MIN_DISTANCES: usize = 2;

/// A detector's reading of a cell, with the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabeledReading {
    /// Manhattan distance of the cell, cells, at most [`Sensor::MAX_RADIUS`].
    pub distance: u32,
    /// Whether an object was in it.
    pub is_object: bool,
    /// The detector's value: 1 is an object, 0 an empty cell; its absolute value is at most [`MAX_VALUE`].
    pub value: f32,
}

/// A number and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Statistics of the readings at one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtDistance {
    /// Cells.
    pub distance: u32,
    /// Number of readings at that distance.
    pub readings: usize,
    /// Mean of `value - theta`: the model has 0.
    pub bias: Estimate,
    /// Mean of `(value - theta)^2`: the model has `noise_variance d^2`.
    pub variance: Estimate,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Variance of a reading at distance 1.
    pub noise_variance: Estimate,
    /// Variance of a reading of the own cell; `None` with fewer than [`MIN_READINGS`] of it. The sensor has
    /// `noise_variance / 5`.
    pub own_cell_variance: Option<Estimate>,
    /// Nearest first: they show whether the model holds.
    pub by_distance: Vec<AtDistance>,
}

/// Why readings cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// An invalid value.
    #[error("reading {index}: a value of {value}: allowed are {} to {MAX_VALUE}", -MAX_VALUE)]
    Value {
        /// Its index in the list.
        index: usize,
        /// The given value.
        value: f32,
    },
    /// A distance beyond the maximum sensor radius.
    #[error("reading {index}: {distance} cells away: at most {max} are allowed", max = Sensor::MAX_RADIUS)]
    Distance {
        /// Its index in the list.
        index: usize,
        /// The given value.
        distance: u32,
    },
    /// Too few readings.
    #[error("{0} readings from distance 1 on: a fit needs at least {MIN_READINGS}")]
    TooFewReadings(usize),
    /// Too few distances.
    #[error("readings at {0} distance from 1 on: a fit needs at least {MIN_DISTANCES}")]
    TooFewDistances(usize),
    /// All readings are of objects, or all of empty cells: half of the detector's behavior is untested.
    #[error("all readings are at {0}: a fit needs objects and empty cells")]
    OneKind(&'static str),
    /// Values that are labels rather than measurements.
    #[error("all values are exactly 0 or 1 as labeled: there is no noise to fit")]
    NoNoise,
}

/// Fits the model.
///
/// # Errors
/// If a reading is invalid, or there are too few, at too few distances, of one kind only, or without any error.
pub fn calibrate(readings: &[LabeledReading]) -> Result<Calibration, CalibrationError> {
    check(readings)?;
    let mut errors: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for reading in readings {
        errors.entry(reading.distance).or_default().push(error(reading));
    }
    let scaled = errors.range(1..).flat_map(|(&distance, errors)| {
        errors.iter().map(move |error| (error / f64::from(distance)).powi(2))
    });
    let noise_variance = mean(&scaled.collect::<Vec<_>>());
    if noise_variance.value <= 0.0 {
        return Err(CalibrationError::NoNoise);
    }
    let own = errors.get(&0).filter(|errors| errors.len() >= MIN_READINGS);
    let at_distance = |(&distance, errors): (&u32, &Vec<f64>)| AtDistance {
        distance,
        readings: errors.len(),
        bias: mean(errors),
        variance: mean_square(errors),
    };
    Ok(Calibration {
        noise_variance,
        own_cell_variance: own.map(|errors| mean_square(errors)),
        by_distance: errors.iter().map(at_distance).collect(),
    })
}

fn check(readings: &[LabeledReading]) -> Result<(), CalibrationError> {
    for (index, &LabeledReading { distance, value, .. }) in readings.iter().enumerate() {
        if !(-MAX_VALUE..=MAX_VALUE).contains(&value) {
            return Err(CalibrationError::Value { index, value });
        }
        if distance > Sensor::MAX_RADIUS {
            return Err(CalibrationError::Distance { index, distance });
        }
    }
    let around: Vec<_> = readings.iter().filter(|reading| reading.distance > 0).collect();
    if around.len() < MIN_READINGS {
        return Err(CalibrationError::TooFewReadings(around.len()));
    }
    let mut distances: Vec<u32> = around.iter().map(|reading| reading.distance).collect();
    distances.sort_unstable();
    distances.dedup();
    if distances.len() < MIN_DISTANCES {
        return Err(CalibrationError::TooFewDistances(distances.len()));
    }
    match around.iter().filter(|reading| reading.is_object).count() {
        0 => Err(CalibrationError::OneKind("empty cells")),
        objects if objects == around.len() => Err(CalibrationError::OneKind("objects")),
        _ => Ok(()),
    }
}

fn error(reading: &LabeledReading) -> f64 {
    f64::from(reading.value) - f64::from(u8::from(reading.is_object))
}

fn mean_square(values: &[f64]) -> Estimate {
    mean(&values.iter().map(|value| value.powi(2)).collect::<Vec<_>>())
}

/// The error of a single value is infinite.
fn mean(values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let value = values.iter().sum::<f64>() / count;
    let scatter = values.iter().map(|other| (other - value).powi(2)).sum::<f64>();
    let standard_error =
        if values.len() > 1 { (scatter / (count - 1.0) / count).sqrt() } else { f64::INFINITY };
    Estimate { value, standard_error }
}

#[cfg(test)]
mod tests {
    use dragnet_search::seed::{Purpose, stream};
    use dragnet_search::sensor::Noise;

    use super::*;
    use crate::mentions::assert_mentions;

    /// As drawn by the simulator: this many at each distance, every fourth of an object.
    fn readings(noise_variance: f64, each: usize, noise: Noise, seed: u64) -> Vec<LabeledReading> {
        let sensor = Sensor::new(10, noise_variance, noise).unwrap();
        let mut random = stream(seed, Purpose::Noise, 0);
        let mut readings = Vec::new();
        for distance in 0..=10 {
            let place = sensor.footprint().iter().find(|place| place.offset.manhattan() == distance).unwrap();
            for number in 0..each {
                let is_object = number % 4 == 0;
                readings.push(LabeledReading {
                    distance,
                    is_object,
                    value: sensor.draw(is_object, place, &mut random),
                });
            }
        }
        readings
    }

    #[test]
    fn readings_drawn_from_the_model_give_its_parameters() {
        let noise_variance = 0.02;
        let (mut within, mut own_within) = (0, 0);
        for seed in 0..100 {
            let calibration = calibrate(&readings(noise_variance, 200, Noise::Gaussian, seed)).unwrap();
            let Estimate { value, standard_error } = calibration.noise_variance;
            assert!(
                (value - noise_variance).abs() < 4.0 * standard_error,
                "seed {seed}: {value} {standard_error}"
            );
            let expected = noise_variance * (2.0_f64 / 2000.0).sqrt();
            assert!(
                (standard_error / expected - 1.0).abs() < 0.2,
                "seed {seed}: {standard_error} {expected}"
            );
            within += u32::from((value - noise_variance).abs() < standard_error);
            let own = calibration.own_cell_variance.unwrap();
            own_within += u32::from((own.value - noise_variance / 5.0).abs() < own.standard_error);
        }
        // 68 of 100 are expected within one standard error, give or take 4.7.
        assert!((54..=82).contains(&within), "{within}");
        assert!((54..=82).contains(&own_within), "{own_within}");
    }

    #[test]
    fn the_table_shows_where_the_model_does_not_hold() {
        let good = calibrate(&readings(0.005, 2000, Noise::Gaussian, 1)).unwrap();
        let off = |calibration: &Calibration, index: usize| {
            let AtDistance { distance, variance, .. } = calibration.by_distance[index];
            (variance.value - calibration.noise_variance.value * f64::from(distance).powi(2))
                / variance.standard_error
        };
        assert!((1..=10).all(|index| off(&good, index).abs() < 4.0));
        assert!(good.by_distance.iter().all(|row| row.bias.value.abs() < 4.0 * row.bias.standard_error));
        // Clipped readings are biased toward the object, and do not grow beyond 1.
        let clipped = calibrate(&readings(0.05, 2000, Noise::Clipped, 1)).unwrap();
        assert!(off(&clipped, 10) < -10.0, "{}", off(&clipped, 10));
        assert!(clipped.by_distance[10].bias.value > 0.1);
    }

    #[test]
    fn without_readings_of_the_own_cell_its_variance_is_unknown() {
        let around: Vec<_> = readings(0.005, 40, Noise::Gaussian, 1)
            .into_iter()
            .filter(|reading| reading.distance > 0)
            .collect();
        assert_eq!(calibrate(&around).unwrap().own_cell_variance, None);
    }

    #[test]
    fn unusable_readings_give_the_reason() {
        let good = readings(0.005, 40, Noise::Gaussian, 1);
        let check = |readings: &[LabeledReading], message: &str| {
            let error = calibrate(readings).unwrap_err().to_string();
            assert_mentions(&error, message);
        };
        let changed = |change: fn(&mut LabeledReading)| {
            let mut readings = good.clone();
            readings.iter_mut().for_each(change);
            readings
        };
        check(&[], "0 readings");
        check(&good[..60], "20 readings");
        check(&changed(|reading| reading.value = f32::NAN), "reading 0 .. NaN .. -1000 to 1000");
        check(&changed(|reading| reading.distance = 101), "reading 0 .. 101 cells .. 100");
        check(&changed(|reading| reading.distance = 3), "readings at 1 distance");
        check(&changed(|reading| reading.is_object = true), "all .. objects");
        check(&changed(|reading| reading.is_object = false), "all .. empty cells");
        check(&changed(|reading| reading.value = f32::from(u8::from(reading.is_object))), "no noise");
    }
}
