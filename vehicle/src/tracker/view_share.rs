//! The share of a normal distribution within a view.

use nalgebra::Vector2;

use super::cubature::Gaussian;
use crate::camera::View;

/// Probability of a detection outside the view.
pub(super) const SEEN_OUTSIDE: f64 = 1e-3;
/// The share is computed from points of the distribution: its center, and one standard deviation (times the root of 3)
/// along each axis, with Gauss-Hermite weights.
pub(super) const MIDDLE: f64 = 1.0 / 3.0;
const SIDE: f64 = 1.0 / 6.0;

/// The relative probability that an object there is detected in a view.
pub(super) fn seen_in(state: &Gaussian, view: &View) -> f64 {
    may_be_in_view(state, view).max(SEEN_OUTSIDE)
}

/// 1 if its center is in view, less if only a part is.
fn may_be_in_view(state: &Gaussian, view: &View) -> f64 {
    (share_where(state, &|point| view.contains(point)) / MIDDLE).min(1.0)
}

pub(super) fn share_where(state: &Gaussian, is_so: &dyn Fn(Vector2<f64>) -> bool) -> f64 {
    mean_over(state, &|point| f64::from(u8::from(is_so(point))))
}

/// The mean of a function over the possible positions of an object.
pub(super) fn mean_over(state: &Gaussian, value: &dyn Fn(Vector2<f64>) -> f64) -> f64 {
    let middle = state.position_meters();
    let Some(root) = state.place_covariance().cholesky().map(|root| root.l() * 3.0_f64.sqrt()) else {
        return value(middle);
    };
    let sides = root.column_iter().flat_map(|axis| [middle + axis, middle - axis]);
    MIDDLE * value(middle) + sides.map(|point| SIDE * value(point)).sum::<f64>()
}
