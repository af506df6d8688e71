//! The information in detections and misses: an object can be where the camera has a view, or where it has none.
//!
//! A bearing gives the direction. A detection alone says that the object was within the camera's view; no detection
//! while the vehicle passed says that it is behind by now, too near, or too far.
//!
//! A distribution across the edge of a view is not split, since repeated weighting by its share would count the same
//! information again and again.

use nalgebra::Vector2;

use super::cubature::Gaussian;
use super::mixture::Mixture;
use super::view_share::{MIDDLE, mean_over, seen_in, share_where};
use crate::camera::View;

impl Mixture {
    /// The mean of a function over the possible positions of the object.
    pub(super) fn mean_of(&self, value: &dyn Fn(Vector2<f64>) -> f64) -> f64 {
        self.members().iter().map(|member| member.weight * mean_over(&member.state, value)).sum()
    }

    /// The mixture after a detection in a view.
    #[must_use]
    pub(super) fn after_seen(&self, view: &View) -> Self {
        self.reweighted(|state| seen_in(state, view))
    }

    /// The mixture after a miss in a view, with this probability of missing an object there.
    #[must_use]
    pub(super) fn after_missed(&self, missed: &Missed<'_>, miss_probability: f64) -> Self {
        self.reweighted(|state| 1.0 - (1.0 - miss_probability) * must_be_in_view(state, missed))
    }
}

/// The view of a frame in which an object was missed.
pub(super) struct Missed<'a> {
    pub(super) view: View,
    /// Views of other cameras in which it was missed just before.
    pub(super) others: &'a [View],
    /// Uncertainty of the edge of views, as an angle.
    pub(super) edge_radians: f64,
    /// Whether a wall hides a position from the camera.
    pub(super) is_hidden: &'a dyn Fn(Vector2<f64>) -> bool,
}

impl Missed<'_> {
    /// Whether a point is well within the view, or on the seam with another one, so that one of both covers it.
    fn was_surely_in_view(&self, point: Vector2<f64>) -> bool {
        let is_in = |view: &View, beyond_radians: f64| view.widened(beyond_radians, 1.0).contains(point);
        if !is_in(&self.view, self.edge_radians) {
            return false;
        }
        let is_on_seam =
            |other: &View| is_in(other, self.edge_radians) && (is_in(other, 0.0) || is_in(&self.view, 0.0));
        (is_in(&self.view, -self.edge_radians) || self.others.iter().any(is_on_seam))
            && !(self.is_hidden)(point)
    }
}

/// 1 if all parts were in view, less if one was not.
fn must_be_in_view(state: &Gaussian, missed: &Missed<'_>) -> f64 {
    (1.0 - (1.0 - share_where(state, &|point| missed.was_surely_in_view(point))) / MIDDLE).max(0.0)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Vector4};

    use super::*;
    use crate::tracker::mixture::Member;
    use dragnet_lattice::plane::Pose;

    fn mixture(places: &[f64]) -> Mixture {
        let member = |&x: &f64| Member {
            weight: 1.0 / places.len() as f64,
            state: Gaussian { mean: Vector4::new(x, 0.0, 0.0, 0.0), covariance: Matrix4::identity() * 0.01 },
        };
        Mixture { members: places.iter().map(member).collect() }
    }

    /// Probability of being well within the view.
    fn within(mixture: &Mixture) -> f64 {
        mixture
            .members()
            .iter()
            .map(|member| member.weight * must_be_in_view(&member.state, &missed(view(), &[])))
            .sum()
    }

    fn missed(view: View, others: &[View]) -> Missed<'_> {
        Missed { view, others, edge_radians: 0.05, is_hidden: &|_| false }
    }

    fn view() -> View {
        View::new(Pose::new(0.0, 0.0, 0.0), 0.7, 2.0, 50.0).unwrap()
    }

    #[test]
    fn a_missed_object_is_behind_too_near_or_too_far() {
        let mut it = mixture(&[-5.0, 1.0, 10.0, 80.0]);
        assert!((within(&it) - 0.25).abs() < 1e-12);
        (0..6).for_each(|_| it = it.after_missed(&missed(view(), &[]), 0.2));
        assert!(within(&it) < 1e-3, "{}", within(&it));
        assert_eq!(it.members().len(), 3);
    }

    /// One of two cameras covers the seam between them, and it is unknown which; each alone may just not cover it.
    #[test]
    fn an_object_missed_by_both_cameras_of_a_seam_is_not_there() {
        let [left, right] =
            [0.7, -0.7].map(|yaw| View::new(Pose::new(0.0, 0.0, yaw), 0.7, 2.0, 50.0).unwrap());
        let ahead = |others: &[View]| {
            let mut it = mixture(&[1.0, 10.0]);
            (0..6).for_each(|_| it = it.after_missed(&missed(left, others), 0.2));
            let far = it.members().iter().filter(|member| member.state.mean[0] > 5.0);
            far.map(|member| member.weight).sum::<f64>()
        };
        assert!((ahead(&[]) - 0.5).abs() < 1e-12);
        assert!(ahead(&[right]) < 1e-3);
    }

    #[test]
    fn a_detected_object_is_in_view() {
        let mut it = mixture(&[-5.0, 1.0, 10.0, 80.0]);
        (0..3).for_each(|_| it = it.after_seen(&view()));
        assert!(within(&it) > 0.999);
    }

    #[test]
    fn a_distribution_across_the_edge_of_a_view_is_unchanged() {
        let mut it = mixture(&[10.0, 50.0]);
        for _ in 0..100 {
            it = it.after_seen(&view());
        }
        assert!(it.members().iter().all(|member| (member.weight - 0.5).abs() < 1e-9), "{it:?}");
    }
}
