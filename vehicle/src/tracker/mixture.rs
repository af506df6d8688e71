//! A range-parameterized filter: Peach, IEE Proceedings - Control Theory and Applications 142(1), 1995, with cubature
//! filters in place of his extended Kalman filters.
//!
//! One bearing does not give the range. So the ranges `R_min..R_max` are divided into N parts in geometric progression
//! (by the factor `rho`), each with its own filter; later bearings weight them.
//!
//! Where we go beyond it: near the camera a member's distribution is as wide as its range, and one normal distribution
//! cannot represent a bearing. So members are split as the camera approaches (`refinement`), and weigh less where the
//! object would have been missed, or could not have been detected (`visibility`).
//!
//! Limits: the range is observable only if the camera moves across the bearing, and an object that moves along with it
//! cannot be distinguished from one that is farther away.

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

use super::cubature::{BearingMeasurement, Gaussian};
use super::pose_error::PoseError;
use super::settings::Settings;
use super::view_share::seen_in;
use crate::camera::View;
use dragnet_lattice::plane::{bearing_radians, wrapped_radians};

/// Below this weight a member is dropped.
const LEAST_WEIGHT: f64 = 1e-3;

/// The possible ranges of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Meters, above 0.
    pub min_range_meters: f64,
    /// Meters, above `min_range_meters`.
    pub max_range_meters: f64,
}

/// One part of the ranges (a range hypothesis).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// Its probability; those of a mixture add up to 1.
    pub weight: f64,
    /// The object's state if it is in this part.
    pub state: Gaussian,
}

/// The distribution of one object: a weighted sum of normal distributions, never empty.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    pub(super) members: Vec<Member>,
}

impl Mixture {
    /// The distribution after one bearing, within the range of the camera. With `rho = (R_max / R_min)^(1/N)` member
    /// `i` of `1..=N` has the mean range `R_min (rho^i + rho^(i-1)) / 2` and the standard deviation of a uniform
    /// distribution over its part, which is that mean times `2 (rho - 1) / ((rho + 1) sqrt(12))`; all weights are
    /// equal.
    #[must_use]
    pub fn born(
        measurement: &BearingMeasurement,
        pose_error: &PoseError,
        reach: Reach,
        settings: &Settings,
    ) -> Self {
        let weight = 1.0 / f64::from(settings.range_hypotheses);
        let rho = (reach.max_range_meters / reach.min_range_meters).powf(weight);
        let relative_deviation = 2.0 * (rho - 1.0) / ((rho + 1.0) * 12.0_f64.sqrt());
        let member = |part: i32| {
            let range_meters = reach.min_range_meters * (rho.powi(part) + rho.powi(part - 1)) / 2.0;
            Member {
                weight,
                state: at_range(measurement, pose_error, range_meters, relative_deviation, settings),
            }
        };
        Self { members: (1..=settings.range_hypotheses.cast_signed()).map(member).collect() }
    }

    /// Its members, the part nearest to the first camera position first.
    #[must_use]
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Predicts all members by [`Gaussian::predict`].
    pub fn predict(&mut self, elapsed_seconds: f64, acceleration_density: f64) {
        for member in &mut self.members {
            member.state.predict(elapsed_seconds, acceleration_density);
        }
    }

    /// The mixture after a bearing: `w_i <- w_i N(z; z_i, S_i) sqrt(S_i / S'_i)`, normalized, with `S'_i` as the predicted
    /// variance `S_i` without the error of the vehicle's position; members that rounding has made invalid or that weigh less
    /// than 1e-3 are dropped. `None` if no member is left.
    ///
    /// The root departs from Peach. It is 1 without that error, which is worth a larger angle the nearer an object is, and
    /// which bearings of one time share: as noise of each bearing it would make near members less likely with each one, so that
    /// a vehicle that stands, or turns on the spot, took every object for a far one.
    #[must_use]
    pub fn updated(&self, measurement: &BearingMeasurement, pose_error: &PoseError) -> Option<Self> {
        self.explained(measurement, pose_error).map(|(mixture, _)| mixture)
    }

    /// The same, and the logarithm of the bearing's predicted density, 1/radians.
    pub(super) fn explained(
        &self,
        measurement: &BearingMeasurement,
        pose_error: &PoseError,
    ) -> Option<(Self, f64)> {
        let mut members = self.members.clone();
        let mut log_densities = Vec::with_capacity(members.len());
        // Logarithms, so that a bearing far from all members still leaves the best of them.
        members.retain_mut(|member| {
            let vague = vaguer(measurement, pose_error, &member.state);
            let lever_nats = lever_nats(measurement, pose_error, &vague, &member.state);
            let Some(log_density) = member.state.update(&vague) else { return false };
            let log_density = member.weight.ln() + log_density;
            log_densities.push(log_density);
            member.weight = log_density + lever_nats;
            true
        });
        let most = members.iter().map(|member| member.weight).max_by(f64::total_cmp)?;
        for member in &mut members {
            member.weight = (member.weight - most).exp();
        }
        let most = log_densities.iter().copied().max_by(f64::total_cmp)?;
        let log_density = most + log_densities.iter().map(|it| (it - most).exp()).sum::<f64>().ln();
        Some((Self::pruned(members), log_density))
    }

    /// The mixture with each member's weight multiplied by a likelihood; unchanged if the likelihood is negligible for
    /// all.
    #[must_use]
    pub fn reweighted(&self, likelihood: impl Fn(&Gaussian) -> f64) -> Self {
        let mut members = self.members.clone();
        for member in &mut members {
            member.weight *= likelihood(&member.state);
        }
        let sum: f64 = members.iter().map(|member| member.weight).sum();
        if sum > 1e-12 { Self::pruned(members) } else { self.clone() }
    }

    /// This mixture, or the other one with a probability.
    #[must_use]
    pub(super) fn or(&self, other: &Self, probability: f64) -> Self {
        let weighed = |mixture: &Self, times: f64| {
            let members = mixture.members.iter();
            members.map(|&member| Member { weight: member.weight * times, ..member }).collect::<Vec<_>>()
        };
        let mut members = weighed(self, 1.0 - probability);
        members.extend(weighed(other, probability));
        Self::pruned(members)
    }

    /// Normalized weights; negligible members are dropped.
    fn pruned(mut members: Vec<Member>) -> Self {
        normalize(&mut members);
        members.retain(|member| member.weight >= LEAST_WEIGHT);
        normalize(&mut members);
        Self { members }
    }

    /// Mean and covariance of the mixture.
    #[must_use]
    pub fn estimate(&self) -> Gaussian {
        let mean: Vector4<f64> = self.members.iter().map(|member| member.state.mean * member.weight).sum();
        let spread = |member: &Member| {
            let offset = member.state.mean - mean;
            (member.state.covariance + offset * offset.transpose()) * member.weight
        };
        Gaussian { mean, covariance: self.members.iter().map(spread).sum() }
    }

    /// The surprise of a bearing, nats, at least 0: the negative logarithm of the density, over that of a bearing that
    /// is expected within a third of the gate and hits. Infinite beyond the gate, and three standard deviations, of all
    /// members; those that could not be in view count little.
    #[must_use]
    pub(super) fn surprise_nats(
        &self,
        measurement: &BearingMeasurement,
        pose_error: &PoseError,
        gate_radians: f64,
        view: &View,
    ) -> f64 {
        let slack = gate_radians / 3.0;
        let likelihood = |member: &Member| {
            let place = member.state.position_meters();
            let off = wrapped_radians(
                measurement.bearing_radians - bearing_radians(measurement.from_meters, place),
            )
            .abs();
            let noise = vaguer(measurement, pose_error, &member.state).deviation_radians;
            let std_radians = bearing_std_radians(&member.state, measurement.from_meters).hypot(noise);
            if off > gate_radians + 3.0 * std_radians {
                return 0.0;
            }
            let total = std_radians.hypot(slack);
            let seen = seen_in(&member.state, view);
            seen * member.weight * slack / total * (-0.5 * (off / total).powi(2)).exp()
        };
        let sum: f64 = self.members.iter().map(likelihood).sum();
        if sum > 0.0 { (-sum.ln()).max(0.0) } else { f64::INFINITY }
    }
}

/// Standard deviation of a distribution's bearing, radians, at most a right angle.
fn bearing_std_radians(state: &Gaussian, from_meters: Vector2<f64>) -> f64 {
    let offset = state.position_meters() - from_meters;
    let range_squared = offset.norm_squared().max(1e-6);
    let across = Vector2::new(-offset.y, offset.x);
    let variance = across.dot(&(state.place_covariance() * across)) / range_squared.powi(2);
    variance.max(0.0).sqrt().min(std::f64::consts::FRAC_PI_2)
}

/// The bearing with the uncertainty of its camera's pose added, for an object that may be there.
fn vaguer(measurement: &BearingMeasurement, pose_error: &PoseError, state: &Gaussian) -> BearingMeasurement {
    // Nearer than its own size an object has no single bearing.
    let range_meters = (state.position_meters() - measurement.from_meters).norm().max(0.5);
    let variance = measurement.deviation_radians.powi(2) + pose_error.bearing_variance(range_meters);
    BearingMeasurement { deviation_radians: variance.sqrt(), ..*measurement }
}

/// `ln sqrt(S / S')`: by how much the error of the vehicle's position widens a predicted bearing.
fn lever_nats(
    measurement: &BearingMeasurement,
    pose_error: &PoseError,
    vague: &BearingMeasurement,
    state: &Gaussian,
) -> f64 {
    let spread = bearing_std_radians(state, measurement.from_meters);
    let without = measurement.deviation_radians.hypot(pose_error.heading_std_radians);
    let lever = (vague.deviation_radians.powi(2) - without.powi(2)).max(0.0);
    let own = (spread.powi(2) - lever).max(0.0).sqrt();
    (vague.deviation_radians.hypot(spread) / without.hypot(own)).ln()
}

/// Along the bearing with the uncertainty of its part, across it with the bearing's noise.
fn at_range(
    measurement: &BearingMeasurement,
    pose_error: &PoseError,
    range_meters: f64,
    relative_deviation: f64,
    settings: &Settings,
) -> Gaussian {
    let (sin, cos) = measurement.bearing_radians.sin_cos();
    let position = measurement.from_meters + Vector2::new(cos, sin) * range_meters;
    let turn = Matrix2::new(cos, -sin, sin, cos);
    let across = measurement.deviation_radians.powi(2) + pose_error.bearing_variance(range_meters);
    let deviations = Vector2::new(relative_deviation, across.sqrt()) * range_meters;
    let place = turn * Matrix2::from_diagonal(&deviations.component_mul(&deviations)) * turn.transpose();
    let mut covariance = Matrix4::from_diagonal_element(settings.velocity_std.powi(2));
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

    const EXACT: PoseError =
        PoseError { heading_std_radians: 0.0, position_std_meters: 0.0, correlation_seconds: 0.0 };
    const REACH: Reach = Reach { min_range_meters: 5.0, max_range_meters: 160.0 };

    fn measurement(east: f64, bearing_radians: f64) -> BearingMeasurement {
        BearingMeasurement { from_meters: Vector2::new(east, 0.0), bearing_radians, deviation_radians: 0.005 }
    }

    fn born() -> Mixture {
        Mixture::born(&measurement(0.0, 1.0), &EXACT, REACH, &Settings::default())
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
        let still = Settings { velocity_std: 0.05, ..Settings::default() };
        let mut mixture =
            Mixture::born(&measurement(0.0, bearing_radians(Vector2::zeros(), truth)), &EXACT, REACH, &still);
        for step in 1..=20 {
            mixture.predict(0.5, 0.0);
            let seen =
                measurement(f64::from(step), bearing_radians(Vector2::new(f64::from(step), 0.0), truth));
            mixture = mixture.updated(&seen, &EXACT).unwrap();
        }
        assert!(mixture.members().len() <= 3, "{}", mixture.members().len());
        let sum: f64 = mixture.members().iter().map(|member| member.weight).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let off = (mixture.estimate().position_meters() - truth).norm();
        assert!(off < 5.0, "{off}");
    }

    #[test]
    fn a_vehicle_that_stands_learns_no_range() {
        let error =
            PoseError { heading_std_radians: 0.01, position_std_meters: 0.5, correlation_seconds: 1.0 };
        let mean_meters = |mixture: &Mixture| mixture.estimate().position_meters().norm();
        let born = Mixture::born(&measurement(0.0, 1.0), &error, REACH, &Settings::default());
        let mut mixture = born.clone();
        for _ in 0..30 {
            mixture = mixture.updated(&measurement(0.0, 1.0), &error.after(0.1)).unwrap();
        }
        let grown = mean_meters(&mixture) / mean_meters(&born);
        assert!((0.8..1.2).contains(&grown), "{grown}");
        assert_eq!(mixture.members().len(), 6);
    }

    #[test]
    fn a_bearing_that_none_expects_leaves_the_best_member() {
        let mixture = born();
        let after = mixture
            .updated(&BearingMeasurement { deviation_radians: 1e-6, ..measurement(0.0, -2.0) }, &EXACT);
        assert!(after.is_none_or(|mixture| mixture.members().iter().all(|member| member.state.is_sound())));
        let after = mixture.updated(&measurement(0.0, 1.3), &EXACT).unwrap();
        assert!(after.members().iter().all(|member| member.weight.is_finite()));
    }

    #[test]
    fn spoiled_members_are_dropped_and_the_last_one_ends_the_mixture() {
        let mut mixture = born();
        mixture.members[2].state.covariance[(0, 0)] = -1.0;
        mixture.members[4].state.mean[1] = f64::NAN;
        assert_eq!(mixture.updated(&measurement(0.0, 1.0), &EXACT).unwrap().members().len(), 4);
        mixture.members.iter_mut().for_each(|member| member.state.covariance[(1, 1)] = f64::NAN);
        assert_eq!(mixture.updated(&measurement(0.0, 1.0), &EXACT), None);
    }

    #[test]
    fn the_whole_has_the_moments_of_its_members() {
        let estimate = born().estimate();
        let ranges: Vec<f64> =
            born().members().iter().map(|member| member.state.position_meters().norm()).collect();
        let mean = ranges.iter().sum::<f64>() / 6.0;
        assert!((estimate.position_meters().norm() - mean).abs() < 1e-9);
        assert!((estimate.covariance[(2, 2)] - Settings::default().velocity_std.powi(2)).abs() < 1e-12);
        assert!(estimate.is_sound());
    }
}
