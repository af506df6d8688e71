//! A range-parameterised filter: Peach, IEE Proceedings - Control Theory and Applications 142(1), 1995, with
//! cubature filters in place of his extended Kalman filters.
//!
//! One bearing tells nothing of the range. So the ranges `R_min..R_max` are cut into N parts that each are as
//! long as they are far away (by the same factor `rho`), each with a filter of its own; what is seen later
//! weighs them.
//!
//! Limits: the range is found only as the camera moves across the bearing, and no filter can tell a thing
//! that moves along with it from one that is farther away. Estimates are as uncertain as they say while
//! things are passed at 10 m or more (`vehicle/tests/tracker/consistency.rs`); what is passed more closely,
//! at standard deviations of its place as large as its range, is in one run of some thousands believed to be
//! where it is not, until it is seen again from elsewhere.

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

use super::cubature::{Gaussian, Sight};
use super::settings::Settings;
use crate::plane::bearing_radians;

/// Below this weight a member is dropped.
const LEAST_WEIGHT: f64 = 1e-3;

/// Between which ranges something can be that was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Metres, above 0.
    pub nearest_meters: f64,
    /// Metres, above `nearest_meters`.
    pub farthest_meters: f64,
}

/// One part of the ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// Its probability; those of a mixture add up to 1.
    pub weight: f64,
    /// Where the thing is if it is in this part.
    pub state: Gaussian,
}

/// What is known of one thing: a weighted sum of normal distributions, never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    members: Vec<Member>,
}

impl Mixture {
    /// Of something that one bearing has shown, within reach of the camera. With
    /// `rho = (R_max / R_min)^(1/N)` member `i` of `1..=N` has the mean range
    /// `R_min (rho^i + rho^(i-1)) / 2` and the standard deviation of a uniform distribution over its part,
    /// which is that mean times `2 (rho - 1) / ((rho + 1) sqrt(12))`; all weights are equal.
    #[must_use]
    pub fn born(sight: &Sight, reach: Reach, settings: &Settings) -> Self {
        let weight = 1.0 / f64::from(settings.members);
        let rho = (reach.farthest_meters / reach.nearest_meters).powf(weight);
        let relative_deviation = 2.0 * (rho - 1.0) / ((rho + 1.0) * 12.0_f64.sqrt());
        let member = |part: i32| {
            let range_meters = reach.nearest_meters * (rho.powi(part) + rho.powi(part - 1)) / 2.0;
            Member {
                weight,
                state: at_range(sight, range_meters, relative_deviation, settings.velocity_deviation),
            }
        };
        Self { members: (1..=settings.members.cast_signed()).map(member).collect() }
    }

    /// Its members, the nearest part of the first sight first.
    #[must_use]
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Moves on, see [`Gaussian::predict`].
    pub fn predict(&mut self, elapsed_seconds: f64, acceleration_density: f64) {
        for member in &mut self.members {
            member.state.predict(elapsed_seconds, acceleration_density);
        }
    }

    /// The same after a bearing: `w_i <- w_i N(z; z_i, S_i)`, normalised; members that rounding has spoilt or
    /// that weigh less than 1e-3 are dropped. None if no member is left.
    #[must_use]
    pub fn updated(&self, sight: &Sight) -> Option<Self> {
        let mut members = self.members.clone();
        // Logarithms, so that a bearing far from all members still leaves the best of them.
        members.retain_mut(|member| match member.state.update(sight) {
            Some(log_density) => {
                member.weight = member.weight.ln() + log_density;
                true
            }
            None => false,
        });
        let most = members.iter().map(|member| member.weight).max_by(f64::total_cmp)?;
        for member in &mut members {
            member.weight = (member.weight - most).exp();
        }
        normalize(&mut members);
        members.retain(|member| member.weight >= LEAST_WEIGHT);
        normalize(&mut members);
        Some(Self { members })
    }

    /// Mean and covariance of the whole.
    #[must_use]
    pub fn estimate(&self) -> Gaussian {
        let mean: Vector4<f64> = self.members.iter().map(|member| member.state.mean * member.weight).sum();
        let spread = |member: &Member| {
            let offset = member.state.mean - mean;
            (member.state.covariance + offset * offset.transpose()) * member.weight
        };
        Gaussian { mean, covariance: self.members.iter().map(spread).sum() }
    }

    /// Where it should be seen from a place: radians on the map, the weighted circular mean of its members'
    /// bearings.
    #[must_use]
    pub fn bearing_radians(&self, from_meters: Vector2<f64>) -> f64 {
        let direction = |member: &Member| {
            let (sin, cos) = bearing_radians(from_meters, member.state.position_meters()).sin_cos();
            Vector2::new(cos, sin) * member.weight
        };
        bearing_radians(Vector2::zeros(), self.members.iter().map(direction).sum())
    }
}

/// Along the bearing as uncertain as its part is long, across it by the bearing's noise.
fn at_range(sight: &Sight, range_meters: f64, relative_deviation: f64, velocity_deviation: f64) -> Gaussian {
    let (sin, cos) = sight.bearing_radians.sin_cos();
    let position = sight.from_meters + Vector2::new(cos, sin) * range_meters;
    let turn = Matrix2::new(cos, -sin, sin, cos);
    let deviations = Vector2::new(relative_deviation, sight.deviation_radians) * range_meters;
    let place = turn * Matrix2::from_diagonal(&deviations.component_mul(&deviations)) * turn.transpose();
    let mut covariance = Matrix4::from_diagonal_element(velocity_deviation.powi(2));
    covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&((place + place.transpose()) / 2.0));
    Gaussian { mean: Vector4::new(position.x, position.y, 0.0, 0.0), covariance }
}

fn normalize(members: &mut [Member]) {
    let sum: f64 = members.iter().map(|member| member.weight).sum();
    for member in members {
        member.weight /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach { nearest_meters: 5.0, farthest_meters: 160.0 };

    fn sight(east: f64, bearing_radians: f64) -> Sight {
        Sight { from_meters: Vector2::new(east, 0.0), bearing_radians, deviation_radians: 0.005 }
    }

    fn born() -> Mixture {
        Mixture::born(&sight(0.0, 1.0), REACH, &Settings::default())
    }

    #[test]
    fn the_parts_grow_by_the_same_factor_and_touch() {
        let mixture = born();
        let rho = 32.0_f64.powf(1.0 / 6.0);
        let mut edge = 5.0;
        for member in mixture.members() {
            let range = member.state.position_meters().norm();
            let covariance = member.state.covariance.fixed_view::<2, 2>(0, 0).into_owned();
            let along = Vector2::new(1.0_f64.cos(), 1.0_f64.sin());
            let half = (along.dot(&(covariance * along)) * 3.0).sqrt();
            assert!((range - half - edge).abs() < 1e-9, "{range} {half} {edge}");
            edge *= rho;
            assert!((range + half - edge).abs() < 1e-9);
            assert!((member.weight - 1.0 / 6.0).abs() < 1e-15);
        }
        assert!((edge - 160.0).abs() < 1e-9);
    }

    #[test]
    fn two_bearings_from_two_places_leave_the_right_range() {
        let truth = Vector2::new(30.0, 40.0);
        let still = Settings { velocity_deviation: 0.05, ..Settings::default() };
        let mut mixture = Mixture::born(&sight(0.0, bearing_radians(Vector2::zeros(), truth)), REACH, &still);
        for step in 1..=20 {
            mixture.predict(0.5, 0.0);
            let seen = sight(f64::from(step), bearing_radians(Vector2::new(f64::from(step), 0.0), truth));
            mixture = mixture.updated(&seen).unwrap();
        }
        assert!(mixture.members().len() <= 3, "{}", mixture.members().len());
        let sum: f64 = mixture.members().iter().map(|member| member.weight).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let off = (mixture.estimate().position_meters() - truth).norm();
        assert!(off < 5.0, "{off}");
    }

    #[test]
    fn a_bearing_that_none_expects_leaves_the_best_member() {
        let mixture = born();
        let after = mixture.updated(&Sight { deviation_radians: 1e-6, ..sight(0.0, -2.0) });
        assert!(after.is_none_or(|mixture| mixture.members().iter().all(|member| member.state.is_sound())));
        let after = mixture.updated(&sight(0.0, 1.3)).unwrap();
        assert!(after.members().iter().all(|member| member.weight.is_finite()));
    }

    #[test]
    fn spoilt_members_are_dropped_and_the_last_one_ends_the_mixture() {
        let mut mixture = born();
        mixture.members[2].state.covariance[(0, 0)] = -1.0;
        mixture.members[4].state.mean[1] = f64::NAN;
        assert_eq!(mixture.updated(&sight(0.0, 1.0)).unwrap().members().len(), 4);
        mixture.members.iter_mut().for_each(|member| member.state.covariance[(1, 1)] = f64::NAN);
        assert_eq!(mixture.updated(&sight(0.0, 1.0)), None);
    }

    #[test]
    fn the_whole_has_the_moments_of_its_members() {
        let estimate = born().estimate();
        let ranges: Vec<f64> =
            born().members().iter().map(|member| member.state.position_meters().norm()).collect();
        let mean = ranges.iter().sum::<f64>() / 6.0;
        assert!((estimate.position_meters().norm() - mean).abs() < 1e-9);
        assert!((estimate.covariance[(2, 2)] - 0.25).abs() < 1e-12);
        assert!(estimate.is_sound());
    }
}
