//! One cubature Kalman filter of bearings: Arasaratnam and Haykin, IEEE Transactions on Automatic Control
//! 54(6), 2009.
//!
//! State `[x, y, vx, vy]`, meters east and north and meters per second, of constant velocity with white
//! acceleration.
//!
//! Where we depart from the paper, and why:
//! - the motion is linear, where the rule is exact: the prediction is `F m` and `F P F' + Q`, without points;
//! - the points' bearings are averaged as deviations from the bearing of the mean, wrapped, and so is the
//!   innovation: a bearing has no order across `pi`;
//! - the covariance is summed up anew as `sum (dx - K dz)(dx - K dz)' / 2n + K R K'`, which equals the
//!   paper's `P - K S K'` and is symmetric and not negative whatever is rounded.

use nalgebra::{Matrix2, Matrix4, RowVector4, SVector, Vector2, Vector4};

use dragnet_lattice::plane::{bearing_radians, wrapped_radians};

/// Dimensions of the state.
const DIMENSIONS: usize = 4;
const POINTS: usize = 2 * DIMENSIONS;

/// A bearing, and the position that it was measured from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BearingMeasurement {
    /// The camera's position: meters east and north.
    pub from_meters: Vector2<f64>,
    /// Radians on the map, counter-clockwise from east.
    pub bearing_radians: f64,
    /// Its standard deviation, radians, above 0.
    pub deviation_radians: f64,
}

/// A normal distribution over states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    /// `[x, y, vx, vy]`, meters east and north, m/s.
    pub mean: Vector4<f64>,
    /// Its covariance; positive definite.
    pub covariance: Matrix4<f64>,
}

impl Gaussian {
    /// Expected position, meters east and north.
    #[must_use]
    pub fn position_meters(&self) -> Vector2<f64> {
        Vector2::new(self.mean[0], self.mean[1])
    }

    /// Covariance of the position, square meters.
    #[must_use]
    pub fn place_covariance(&self) -> Matrix2<f64> {
        self.covariance.fixed_view::<2, 2>(0, 0).into_owned()
    }

    /// Whether all numbers are finite and the covariance is positive definite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.mean.iter().all(|value| value.is_finite()) && self.covariance.cholesky().is_some()
    }

    /// Predicts the state after some seconds. White acceleration of spectral density `q` (m^2/s^3) adds, for each
    /// coordinate, `q [[t^3/3, t^2/2], [t^2/2, t]]`: one step gives the same result as many short ones.
    pub fn predict(&mut self, elapsed_seconds: f64, acceleration_density: f64) {
        let (t, q) = (elapsed_seconds, acceleration_density);
        let mut motion = Matrix4::identity();
        let mut noise = Matrix4::zeros();
        for (place, velocity) in [(0, 2), (1, 3)] {
            motion[(place, velocity)] = t;
            noise[(place, place)] = q * t.powi(3) / 3.0;
            noise[(place, velocity)] = q * t.powi(2) / 2.0;
            noise[(velocity, place)] = noise[(place, velocity)];
            noise[(velocity, velocity)] = q * t;
        }
        self.mean = motion * self.mean;
        let covariance = motion * self.covariance * motion.transpose() + noise;
        self.covariance = (covariance + covariance.transpose()) / 2.0;
    }

    /// Updates the state by a bearing. Returns the natural logarithm of its predicted density, `ln N(z; z', S)`; `None`
    /// if rounding has made the distribution invalid, and it must not be used any more.
    #[must_use]
    pub fn update(&mut self, measurement: &BearingMeasurement) -> Option<f64> {
        let offsets = self.point_offsets()?;
        let center = bearing_radians(measurement.from_meters, self.position_meters());
        let from_center = |offset: &Vector4<f64>| {
            let point = self.position_meters() + offset.xy();
            wrapped_radians(bearing_radians(measurement.from_meters, point) - center)
        };
        let bearings = SVector::<f64, POINTS>::from_iterator(offsets.iter().map(from_center));
        let expected = bearings.mean();
        let deviations = bearings.add_scalar(-expected);

        let noise = measurement.deviation_radians.powi(2);
        let variance = deviations.norm_squared() / POINTS as f64 + noise;
        let shared: Vector4<f64> =
            offsets.iter().zip(deviations.iter()).map(|(offset, deviation)| offset * *deviation).sum();
        let gain = shared / (POINTS as f64 * variance);
        let innovation = wrapped_radians(measurement.bearing_radians - center - expected);

        self.mean += gain * innovation;
        let unexplained = offsets.iter().zip(deviations.iter()).map(|(offset, deviation)| {
            let rest = offset - gain * *deviation;
            rest * rest.transpose()
        });
        let gain_row: RowVector4<f64> = gain.transpose();
        self.covariance = unexplained.sum::<Matrix4<f64>>() / POINTS as f64 + gain * gain_row * noise;
        let log_density = -0.5 * (innovation.powi(2) / variance + (std::f64::consts::TAU * variance).ln());
        (log_density.is_finite() && self.is_sound()).then_some(log_density)
    }

    /// `+- sqrt(n) S e_j` with `P = S S'`; `None` if P is not positive definite.
    fn point_offsets(&self) -> Option<[Vector4<f64>; POINTS]> {
        let root = self.covariance.cholesky()?.l() * (DIMENSIONS as f64).sqrt();
        Some(std::array::from_fn(|point| {
            let column: Vector4<f64> = root.column(point % DIMENSIONS).into_owned();
            if point < DIMENSIONS { column } else { -column }
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn at(east: f64, north: f64) -> Gaussian {
        let covariance = Matrix4::from_diagonal(&Vector4::new(4.0, 4.0, 0.25, 0.25));
        Gaussian { mean: Vector4::new(east, north, 0.0, 0.0), covariance }
    }

    fn measurement(bearing_radians: f64) -> BearingMeasurement {
        BearingMeasurement { from_meters: Vector2::zeros(), bearing_radians, deviation_radians: 0.01 }
    }

    #[test]
    fn many_short_steps_are_one_long_one() {
        let (mut once, mut often) = (at(10.0, 5.0), at(10.0, 5.0));
        once.mean[2] = 1.0;
        often.mean[2] = 1.0;
        once.predict(2.0, 0.3);
        (0..100).for_each(|_| often.predict(0.02, 0.3));
        assert!((once.mean - often.mean).norm() < 1e-12);
        assert!((once.covariance - often.covariance).norm() < 1e-12);
        assert!((once.mean[0] - 12.0).abs() < 1e-12);
    }

    #[test]
    fn a_bearing_measures_the_position_across_it_and_not_along_it() {
        let mut member = at(100.0, 0.0);
        assert!(member.update(&measurement(0.0)).is_some());
        let (along, across) = (member.covariance[(0, 0)], member.covariance[(1, 1)]);
        // Across: 1 / (1/4 + 1/1), of 100 m times 0.01 radians.
        assert!((along - 4.0).abs() < 0.01 && (across - 0.8).abs() < 0.01, "{along} {across}");
    }

    #[test]
    fn a_bearing_across_pi_pulls_the_shorter_way() {
        let mut member = at(-100.0, 0.5);
        assert!(member.update(&measurement(0.01 - PI)).is_some());
        assert!(member.mean[1] < 0.0 && member.mean[1] > -1.0, "{}", member.mean);
    }

    #[test]
    fn a_place_at_the_camera_itself_is_no_panic() {
        let mut member = at(0.0, 0.0);
        for bearing in [0.0, 3.0, -2.0] {
            if member.update(&measurement(bearing)).is_none() {
                return;
            }
            assert!(member.is_sound());
        }
    }

    #[test]
    fn an_invalid_distribution_is_reported() {
        let mut negative = at(10.0, 0.0);
        negative.covariance[(0, 0)] = -1.0;
        assert!(negative.update(&measurement(0.0)).is_none());
        let mut missing = at(f64::NAN, 0.0);
        assert!(missing.update(&measurement(0.0)).is_none());
    }
}
