//! The greatest distance between tracks at which one pass over all of them confirms the objects between them.

use crate::route::ShortestPathTree;
use crate::sensor::Sensor;
use crate::situation::Situation;
use crate::utility::{found, log_odds_nats};

/// Probability with which an object must be found by one pass, wherever it lies between two tracks.
const CONFIDENCE: f64 = 0.9;

/// The greatest spacing at which two straight tracks find an object anywhere between them with probability
/// [`CONFIDENCE`], cells: `min_a F(L, k(a) + k(W - a))`, where `k(d)` is the precision that a track adds at a distance of
/// `d`, `F` the probability that it raises the mean belief in reach to the detection threshold. At least 1.
pub(super) fn confirming(situation: &Situation<'_>, routes: &ShortestPathTree) -> u32 {
    let searched = routes.reached().iter().filter(|&&cell| situation.terrain.is_searched(cell));
    let (count, sum) = searched
        .fold((0.0, 0.0), |(count, sum), &cell| (count + 1.0, sum + situation.belief.probability(cell)));
    if !(sum > 0.0 && sum < count) {
        return 1;
    }
    let mean_nats = log_odds_nats(sum / count);
    let found_nats = log_odds_nats(situation.detection_threshold);
    let track = track_precision(situation.sensor);
    let at = |distance: u32| track.get(distance as usize).copied().unwrap_or(0.0);
    let confirms = |spacing: u32| {
        (0..=spacing / 2)
            .all(|near| found(mean_nats, at(near) + at(spacing - near), found_nats) >= CONFIDENCE)
    };
    let widest = 2 * situation.sensor.radius() + 1;
    (1..=widest).rev().find(|&spacing| confirms(spacing)).unwrap_or(1)
}

/// Precision that an endless straight track adds to a cell, by its distance from the track.
fn track_precision(sensor: &Sensor) -> Vec<f64> {
    let mut precision = vec![0.0; sensor.radius() as usize + 1];
    for seen in sensor.footprint() {
        if let Ok(distance) = usize::try_from(seen.offset.north) {
            precision[distance] += 1.0 / f64::from(seen.variance);
        }
    }
    precision
}

/// Numbers of `count` tracks over `extent` rows or columns, evenly: each is at most half a spacing from what it serves.
pub(super) fn tracks(extent: u32, spacing: u32) -> impl Iterator<Item = u32> {
    let count = extent.div_ceil(spacing.max(1));
    (0..count).map(move |track| {
        let place = (2 * u64::from(track) + 1) * u64::from(extent) / (2 * u64::from(count));
        u32::try_from(place).unwrap_or(u32::MAX)
    })
}
