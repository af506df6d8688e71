//! Non-maximum suppression: of boxes that overlap strongly, the most confident stays.

use crate::output::Candidate;
use crate::settings::{Settings, Suppression};
use dragnet_vehicle::camera::DetectionBox;

/// The candidates that are kept, most confident first; of equals the first. `None` if there are more than `most` of
/// them.
///
/// The usual greedy algorithm: in this order a candidate is kept unless one that is already kept overlaps it by more
/// than [`Settings::iou`]. Each is compared only with those that are kept, so that the work is at most `most` times the
/// number of candidates.
#[must_use]
pub fn suppress(mut candidates: Vec<Candidate>, settings: &Settings, most: usize) -> Option<Vec<Candidate>> {
    // Stable, so that equals keep their order.
    candidates.sort_by(|one, other| other.confidence.total_cmp(&one.confidence));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        let is_same = |stays: &Candidate| {
            (settings.suppression == Suppression::Agnostic || stays.class == candidate.class)
                && iou(&stays.bounds, &candidate.bounds) > f64::from(settings.iou)
        };
        if kept.iter().any(is_same) {
            continue;
        }
        if kept.len() == most {
            return None;
        }
        kept.push(candidate);
    }
    Some(kept)
}

/// Intersection over union of two boxes: 0 to 1.
fn iou(one: &DetectionBox, other: &DetectionBox) -> f64 {
    let common = |low: fn(&DetectionBox) -> f64, high: fn(&DetectionBox) -> f64| {
        (high(one).min(high(other)) - low(one).max(low(other))).max(0.0)
    };
    let common = common(|a| a.left, |a| a.right) * common(|a| a.top, |a| a.bottom);
    let area = |a: &DetectionBox| (a.right - a.left) * (a.bottom - a.top);
    common / (area(one) + area(other) - common)
}
