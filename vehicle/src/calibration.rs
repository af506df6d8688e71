//! Fits the sensor's model to looks of which one knows what was there.
//!
//! The model is that of [`dragnet_search::sensor::Sensor`]: a reading of a cell at distance `d` (cells) is
//! `theta + N(0, v(d))`, with `v(d) = noise_variance d^2` from distance 1 on, and a constant `v(0)` for the own cell.
//! So every `u = ((value - theta) / d)^2` has the mean `noise_variance`, and their average is its estimate of maximum
//! likelihood.
//!
//! Its standard error is that of an average, from the scatter of the `u` themselves: of normal errors that is
//! `noise_variance sqrt(2 / n)`, and of errors with heavier tails it is honestly more. Looks are taken to be
//! independent: frames of the same thing from the same place are not, and make the error seem smaller than it
//! is.

use std::collections::BTreeMap;

use dragnet_search::evidence::MAX_VALUE;
use dragnet_search::sensor::Sensor;

/// So many looks from distance 1 on does a fit need, and as many at distance 0 for the own cell.
pub const FEWEST_LOOKS: usize = 30;
/// At so many distances from 1 on must they be: at one alone, nothing would tell of the law.
pub const FEWEST_DISTANCES: usize = 2;

/// What a detector said of a cell, and what was there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabeledLook {
    /// Manhattan distance of the cell, cells, at most [`Sensor::MAX_RADIUS`].
    pub distance: u32,
    /// Whether an object was in it.
    pub is_object: bool,
    /// What the detector said: 1 is an object, 0 an empty cell; at most [`MAX_VALUE`] to both sides.
    pub value: f32,
}

/// A number and how far off it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// What looks at one distance say by themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtDistance {
    /// Cells.
    pub distance: u32,
    /// Looks at that distance.
    pub looks: usize,
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
    /// Variance of a reading of the own cell; none with fewer than [`FEWEST_LOOKS`] of it. The sensor has
    /// `noise_variance / 5`.
    pub own_cell_variance: Option<Estimate>,
    /// Nearest first: whether the model holds is seen here.
    pub by_distance: Vec<AtDistance>,
}

/// Looks that tell nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// No value.
    #[error("look {index}: a value of {value}: allowed are {} to {MAX_VALUE}", -MAX_VALUE)]
    Value {
        /// Its place in the list.
        index: usize,
        /// As given.
        value: f32,
    },
    /// Farther than a sensor sees.
    #[error("look {index}: {distance} cells away: at most {max} are allowed", max = Sensor::MAX_RADIUS)]
    Distance {
        /// Its place in the list.
        index: usize,
        /// As given.
        distance: u32,
    },
    /// Too few.
    #[error("{0} looks from distance 1 on: a fit needs at least {FEWEST_LOOKS}")]
    TooFewLooks(usize),
    /// All from the same distances.
    #[error("looks at {0} distance from 1 on: a fit needs at least {FEWEST_DISTANCES}")]
    TooFewDistances(usize),
    /// All of objects, or all of empty cells: half of what the detector does was not tried.
    #[error("all looks are at {0}: a fit needs objects and empty cells")]
    OneKind(&'static str),
    /// Values that are labels and no measurements.
    #[error("all values are exactly 0 or 1 as labeled: there is no noise to fit")]
    NoNoise,
}

/// Fits the model.
///
/// # Errors
/// If a look cannot be, or there are too few, at too few distances, of one kind only, or without any error.
pub fn calibrate(looks: &[LabeledLook]) -> Result<Calibration, CalibrationError> {
    check(looks)?;
    let mut errors: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for look in looks {
        errors.entry(look.distance).or_default().push(error(look));
    }
    let scaled = errors.range(1..).flat_map(|(&distance, errors)| {
        errors.iter().map(move |error| (error / f64::from(distance)).powi(2))
    });
    let noise_variance = mean(&scaled.collect::<Vec<_>>());
    if noise_variance.value <= 0.0 {
        return Err(CalibrationError::NoNoise);
    }
    let own = errors.get(&0).filter(|errors| errors.len() >= FEWEST_LOOKS);
    let at_distance = |(&distance, errors): (&u32, &Vec<f64>)| AtDistance {
        distance,
        looks: errors.len(),
        bias: mean(errors),
        variance: mean_square(errors),
    };
    Ok(Calibration {
        noise_variance,
        own_cell_variance: own.map(|errors| mean_square(errors)),
        by_distance: errors.iter().map(at_distance).collect(),
    })
}

fn check(looks: &[LabeledLook]) -> Result<(), CalibrationError> {
    for (index, &LabeledLook { distance, value, .. }) in looks.iter().enumerate() {
        if !(-MAX_VALUE..=MAX_VALUE).contains(&value) {
            return Err(CalibrationError::Value { index, value });
        }
        if distance > Sensor::MAX_RADIUS {
            return Err(CalibrationError::Distance { index, distance });
        }
    }
    let around: Vec<_> = looks.iter().filter(|look| look.distance > 0).collect();
    if around.len() < FEWEST_LOOKS {
        return Err(CalibrationError::TooFewLooks(around.len()));
    }
    let mut distances: Vec<u32> = around.iter().map(|look| look.distance).collect();
    distances.sort_unstable();
    distances.dedup();
    if distances.len() < FEWEST_DISTANCES {
        return Err(CalibrationError::TooFewDistances(distances.len()));
    }
    match around.iter().filter(|look| look.is_object).count() {
        0 => Err(CalibrationError::OneKind("empty cells")),
        objects if objects == around.len() => Err(CalibrationError::OneKind("objects")),
        _ => Ok(()),
    }
}

fn error(look: &LabeledLook) -> f64 {
    f64::from(look.value) - f64::from(u8::from(look.is_object))
}

fn mean_square(values: &[f64]) -> Estimate {
    mean(&values.iter().map(|value| value.powi(2)).collect::<Vec<_>>())
}

/// Of one value alone the error is infinite.
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

    /// As the simulator draws them: so many at each distance, every fourth of an object.
    fn looks(noise_variance: f64, each: usize, noise: Noise, seed: u64) -> Vec<LabeledLook> {
        let sensor = Sensor::new(10, noise_variance, noise).unwrap();
        let mut random = stream(seed, Purpose::Noise, 0);
        let mut looks = Vec::new();
        for distance in 0..=10 {
            let place = sensor.footprint().iter().find(|place| place.offset.manhattan() == distance).unwrap();
            for number in 0..each {
                let is_object = number % 4 == 0;
                looks.push(LabeledLook {
                    distance,
                    is_object,
                    value: sensor.draw(is_object, place, &mut random),
                });
            }
        }
        looks
    }

    #[test]
    fn the_models_own_looks_give_its_numbers_back() {
        let noise_variance = 0.02;
        let (mut within, mut own_within) = (0, 0);
        for seed in 0..100 {
            let calibration = calibrate(&looks(noise_variance, 200, Noise::Gaussian, seed)).unwrap();
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
        let good = calibrate(&looks(0.005, 2000, Noise::Gaussian, 1)).unwrap();
        let off = |calibration: &Calibration, index: usize| {
            let AtDistance { distance, variance, .. } = calibration.by_distance[index];
            (variance.value - calibration.noise_variance.value * f64::from(distance).powi(2))
                / variance.standard_error
        };
        assert!((1..=10).all(|index| off(&good, index).abs() < 4.0));
        assert!(good.by_distance.iter().all(|row| row.bias.value.abs() < 4.0 * row.bias.standard_error));
        // Clipped readings lean toward the object, and do not grow beyond 1.
        let clipped = calibrate(&looks(0.05, 2000, Noise::Clipped, 1)).unwrap();
        assert!(off(&clipped, 10) < -10.0, "{}", off(&clipped, 10));
        assert!(clipped.by_distance[10].bias.value > 0.1);
    }

    #[test]
    fn without_looks_at_the_own_cell_it_stays_open() {
        let around: Vec<_> =
            looks(0.005, 40, Noise::Gaussian, 1).into_iter().filter(|look| look.distance > 0).collect();
        assert_eq!(calibrate(&around).unwrap().own_cell_variance, None);
    }

    #[test]
    fn looks_that_tell_nothing_say_why() {
        let good = looks(0.005, 40, Noise::Gaussian, 1);
        let check = |looks: &[LabeledLook], message: &str| {
            let error = calibrate(looks).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        let changed = |change: fn(&mut LabeledLook)| {
            let mut looks = good.clone();
            looks.iter_mut().for_each(change);
            looks
        };
        check(&[], "0 looks");
        check(&good[..60], "20 looks");
        check(&changed(|look| look.value = f32::NAN), "look 0: a value of NaN: allowed are -1000 to 1000");
        check(&changed(|look| look.distance = 101), "look 0: 101 cells away: at most 100");
        check(&changed(|look| look.distance = 3), "looks at 1 distance");
        check(&changed(|look| look.is_object = true), "all looks are at objects");
        check(&changed(|look| look.is_object = false), "all looks are at empty cells");
        check(&changed(|look| look.value = f32::from(u8::from(look.is_object))), "no noise");
    }
}
