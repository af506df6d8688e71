//! Splits members that are too wide for the camera's distance, and merges members that are nearly equal.
//!
//! Peach's members have a width proportional to their range from the first camera position. As the camera approaches,
//! that share grows, and the bearing becomes a nonlinear function of the position: the filter would become
//! overconfident. So a member is split into three along its longest axis while it is wider than [`WIDEST`] of its range
//! (as in adaptive Gaussian mixtures: `DeMars`, Bishop and Jah, Journal of Guidance, Control, and Dynamics 36(4),
//! 2013), preserving mean and covariance of the whole.

use nalgebra::{Vector2, Vector4};

use super::cubature::Gaussian;
use super::mixture::{Member, Mixture};
use crate::camera::View;

/// Ratio of its largest standard deviation to its range above which a member is split.
const WIDEST: f64 = 0.25;
/// Ranges below this count as this, meters: only the cell matters.
const NEAREST_METERS: f64 = 1.0;
/// A member with a smaller standard deviation is not split at a wall.
const NARROW_METERS: f64 = 0.1;
/// The maximum number of members of a mixture.
const MOST_MEMBERS: usize = 64;
/// Weight below which a member is not split.
const LEAST_WEIGHT: f64 = 4e-3;
/// The middle part has this weight, both others share the rest,
const MIDDLE_WEIGHT: f64 = 0.5;
/// lie this many standard deviations beside it,
const OFFSET: f64 = 1.05;
/// and all are narrower: the variance is 1 without that of the means.
const PART_VARIANCE: f64 = 1.0 - (1.0 - MIDDLE_WEIGHT) * OFFSET * OFFSET;
/// Members are merged if their squared distance, in variances of the heavier, is less.
const SAME: f64 = 0.25;
/// Fewer members are not merged.
const FEW_MEMBERS: usize = 8;

impl Mixture {
    /// Splits members that are too wide for a camera at a position.
    pub fn refine(&mut self, from_meters: Vector2<f64>) {
        self.split_along(|state| direction(state, from_meters));
    }

    /// Splits members in view that are partly hidden, until each part is hidden or is not, or is narrow: a detection or a
    /// miss then weighs each as a whole.
    pub(super) fn split_at_walls(&mut self, view: &View, is_hidden: &dyn Fn(Vector2<f64>) -> bool) {
        self.split_along(|state| {
            view.contains(state.position_meters()).then(|| across_a_wall(state, is_hidden)).flatten()
        });
    }

    /// Splits members along an axis, as long as they have one and there is room.
    fn split_along(&mut self, axis: impl Fn(&Gaussian) -> Option<Vector4<f64>>) {
        let mut index = 0;
        while index < self.members.len() {
            let member = self.members[index];
            let has_room = self.members.len() + 2 <= MOST_MEMBERS && member.weight >= LEAST_WEIGHT;
            match has_room.then(|| axis(&member.state)).flatten() {
                Some(axis) => {
                    self.members.splice(index..=index, parts(&member, axis));
                }
                None => index += 1,
            }
        }
    }

    /// Merges members that are nearly equal.
    pub fn condense(&mut self) {
        if self.members.len() <= FEW_MEMBERS {
            return;
        }
        let mut rest = std::mem::take(&mut self.members);
        rest.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        while !rest.is_empty() {
            let heaviest = rest.remove(0);
            let Some(root) = heaviest.state.place_covariance().cholesky() else { continue };
            let is_same = |other: &Member| {
                let offset = other.state.position_meters() - heaviest.state.position_meters();
                let is_alike =
                    other.state.place_covariance().trace() < 2.0 * heaviest.state.place_covariance().trace();
                is_alike && offset.dot(&root.solve(&offset)) < SAME
            };
            let (same, others): (Vec<Member>, Vec<Member>) = rest.into_iter().partition(is_same);
            rest = others;
            self.members.push(joined(heaviest, same));
        }
    }
}

/// The longest axis of a distribution's position, if it is too long.
fn direction(state: &Gaussian, from_meters: Vector2<f64>) -> Option<Vector4<f64>> {
    let range_meters = (state.position_meters() - from_meters).norm().max(NEAREST_METERS);
    let place = state.place_covariance();
    // The larger eigenvalue is at most the trace, and at least half of it.
    if place.trace() <= (WIDEST * range_meters).powi(2) {
        return None;
    }
    let eigen = place.symmetric_eigen();
    let longest = eigen.eigenvalues.imax();
    let variance = eigen.eigenvalues[longest];
    let is_wide = variance > (WIDEST * range_meters).powi(2) && variance.is_finite();
    let axis = eigen.eigenvectors.column(longest);
    is_wide.then(|| Vector4::new(axis[0], axis[1], 0.0, 0.0))
}

/// The axis of a distribution's position along which it is hidden in part.
fn across_a_wall(state: &Gaussian, is_hidden: &dyn Fn(Vector2<f64>) -> bool) -> Option<Vector4<f64>> {
    let eigen = state.place_covariance().symmetric_eigen();
    let middle = state.position_meters();
    let is_middle_hidden = is_hidden(middle);
    let differs = |&axis: &usize| {
        let std_meters = eigen.eigenvalues[axis].max(0.0).sqrt();
        let side = eigen.eigenvectors.column(axis) * (std_meters * 3.0_f64.sqrt());
        std_meters > NARROW_METERS
            && [middle + side, middle - side].into_iter().any(|it| is_hidden(it) != is_middle_hidden)
    };
    let longest = eigen.eigenvalues.imax();
    let axis = [longest, 1 - longest].into_iter().find(differs)?;
    let axis = eigen.eigenvectors.column(axis);
    Some(Vector4::new(axis[0], axis[1], 0.0, 0.0))
}

/// Three members for one: along `P e / sqrt(e' P e)`, so that velocities correlated with the position are split too.
fn parts(member: &Member, axis: Vector4<f64>) -> [Member; 3] {
    let along = member.state.covariance * axis;
    let along = along / axis.dot(&along).sqrt();
    let covariance = member.state.covariance - along * along.transpose() * (1.0 - PART_VARIANCE);
    let covariance = (covariance + covariance.transpose()) / 2.0;
    let part = |offset: f64, weight: f64| Member {
        weight: member.weight * weight,
        state: Gaussian { mean: member.state.mean + along * offset, covariance },
    };
    let beside = (1.0 - MIDDLE_WEIGHT) / 2.0;
    [part(-OFFSET, beside), part(0.0, MIDDLE_WEIGHT), part(OFFSET, beside)]
}

fn joined(heaviest: Member, same: Vec<Member>) -> Member {
    if same.is_empty() {
        return heaviest;
    }
    let weight = heaviest.weight + same.iter().map(|member| member.weight).sum::<f64>();
    let all = std::iter::once(heaviest)
        .chain(same)
        .map(|member| Member { weight: member.weight / weight, ..member });
    let state = Mixture { members: all.collect() }.estimate();
    Member { weight, state }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix4;

    use super::*;

    fn wide() -> Mixture {
        let covariance = Matrix4::new(
            25.0, 3.0, 0.2, 0.0, //
            3.0, 1.0, 0.0, 0.1, //
            0.2, 0.0, 0.04, 0.0, //
            0.0, 0.1, 0.0, 0.04,
        );
        let state = Gaussian { mean: Vector4::new(10.0, 0.0, 0.1, -0.1), covariance };
        Mixture { members: vec![Member { weight: 1.0, state }] }
    }

    #[test]
    fn the_whole_stays_as_it_was_however_it_is_cut() {
        let before = wide().estimate();
        let mut mixture = wide();
        mixture.refine(Vector2::new(0.0, 0.0));
        assert!(mixture.members().len() > 3, "{}", mixture.members().len());
        let after = mixture.estimate();
        assert!((after.mean - before.mean).norm() < 1e-9);
        assert!((after.covariance - before.covariance).norm() < 1e-9);
        assert!(mixture.members().iter().all(|member| member.state.is_sound()));
        mixture.condense();
        assert!((mixture.estimate().covariance - before.covariance).norm() < 1e-9);
    }

    #[test]
    fn distant_members_are_not_split() {
        let mut mixture = wide();
        mixture.refine(Vector2::new(-90.0, 0.0));
        assert_eq!(mixture, wide());
    }

    #[test]
    fn nearly_equal_members_are_merged() {
        let member = wide().members()[0];
        let mut mixture = Mixture { members: vec![Member { weight: 0.1, ..member }; 10] };
        mixture.condense();
        assert_eq!(mixture.members().len(), 1);
        assert!((mixture.estimate().covariance - member.state.covariance).norm() < 1e-9);
    }
}
