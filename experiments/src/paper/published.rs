//! Figures as the paper prints them.

use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_search::policy::PolicyName as Exact;

use super::map::Map;

/// Time of a decision, seconds (Table I).
pub(super) const GREEDY_SECONDS: f64 = 5.30;
/// Likewise.
pub(super) const PATH_SECONDS: f64 = 122.00;
/// Likewise, of any clone.
pub(super) const CLONE_SECONDS: f64 = 0.48;

/// The paper's speed-up of a clone's decision over its expert's (section VI-A).
pub(super) const SPEEDUP_OVER_GREEDY: f64 = 11.0;
/// Likewise.
pub(super) const SPEEDUP_OVER_PATH: f64 = 254.0;

/// The paper's bound on the difference between the F1 of a clone and that of its expert, percentage points (section
/// VI-A). The paper says percent without a base; its differences of Table II, in the same words, are points.
pub(super) const TRACKING_POINTS: f64 = 1.5;

/// The F1 up to which the paper finds random and greedy search equally fast (section VI-A).
pub(super) const PARTING_F1: f64 = 0.6;

/// The paper's bound on the difference between the mean area of the clone of the all-traversable map and that of the
/// expert, percentage points (section VI-B).
pub(super) const BEST_DROP_POINTS: f64 = 1.0;

/// Areas under F1 at 1 % (Table II).
pub(super) struct Areas {
    pub(super) policy: PolicyName,
    /// In the order of [`Map::ALL`].
    pub(super) maps: [f64; 4],
    pub(super) mean: f64,
}

/// Table II, the expert first.
pub(super) const TABLE_2: [Areas; 5] = [
    Areas { policy: PolicyName::Exact(Exact::Greedy), maps: [0.7960, 0.7634, 0.7579, 0.7212], mean: 0.7596 },
    clone(Map::IceCreamCone.greedy_clone(), [0.8056, 0.7425, 0.7262, 0.6790], 0.7383),
    clone(Map::OpenAsterisk.greedy_clone(), [0.7612, 0.7446, 0.7333, 0.7186], 0.7394),
    clone(Map::FigureFour.greedy_clone(), [0.7334, 0.7655, 0.7292, 0.6831], 0.7278),
    clone(Map::AllTraversable.greedy_clone(), [0.7794, 0.7635, 0.7356, 0.7366], 0.7538),
];

/// Time of a mission of the field test, seconds (section VII).
pub(super) const FIELD_BUDGET_SECONDS: f64 = 900.0;

/// Time to find all five (Table III).
pub(super) struct FieldTimes {
    /// In the configurations A, B and C; that of the mission if not all were found.
    pub(super) seconds: [f64; 3],
    /// Speed-ups over NATS, as printed.
    pub(super) speedups: [f64; 3],
}

/// Table III: NATS, the clones of greedy search (ICC, AT), that of path-integral search (ICC).
pub(super) const TABLE_3: [FieldTimes; 4] = [
    FieldTimes { seconds: [FIELD_BUDGET_SECONDS, 663.0, 425.0], speedups: [1.00, 1.00, 1.00] },
    FieldTimes { seconds: [315.0, 350.0, 330.0], speedups: [2.86, 1.89, 1.29] },
    FieldTimes { seconds: [460.0, 495.0, 385.0], speedups: [1.96, 1.34, 1.10] },
    FieldTimes { seconds: [340.0, 275.0, 260.0], speedups: [2.64, 2.41, 1.63] },
];

const fn clone(shipped: Shipped, maps: [f64; 4], mean: f64) -> Areas {
    Areas { policy: PolicyName::Learned(shipped), maps, mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_means_are_those_of_their_rows() {
        for row in TABLE_2 {
            assert!((row.maps.iter().sum::<f64>() / 4.0 - row.mean).abs() < 1e-4, "{}", row.policy);
        }
    }

    #[test]
    fn the_field_tests_speedups_are_those_of_its_times() {
        for row in TABLE_3 {
            for place in 0..3 {
                let speedup = TABLE_3[0].seconds[place] / row.seconds[place];
                assert!((speedup - row.speedups[place]).abs() < 0.015, "{speedup}");
            }
        }
    }

    #[test]
    fn the_speedups_are_those_of_the_times() {
        assert!((GREEDY_SECONDS / CLONE_SECONDS - SPEEDUP_OVER_GREEDY).abs() < 0.5);
        assert!((PATH_SECONDS / CLONE_SECONDS - SPEEDUP_OVER_PATH).abs() < 0.5);
    }
}
