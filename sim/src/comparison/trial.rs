//! The results of an episode.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::Setting;
use crate::episode::Episode;

/// Shares of the objects whose path length is reported beside that of all.
pub const PARTIAL_RECALLS: [f64; 3] = [0.5, 0.8, 0.95];

/// The results of an episode from which tables and curves are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Of the episode.
    pub seed: u64,
    /// Mean of F1 over path lengths up to the budget.
    pub auc_f1: f64,
    /// Mean of recall over path lengths up to the budget.
    pub average_recall: f64,
    /// Path length of the farthest robot until every object was found, cells; `None` if that was never.
    pub cells_to_full_recall: Option<f64>,
    /// The same until these shares of them were found, [`PARTIAL_RECALLS`].
    pub cells_to_recall: [Option<f64>; PARTIAL_RECALLS.len()],
    /// F1 at the end.
    pub f1: f64,
    /// Recall at the end.
    pub recall: f64,
    /// Objects in reach; without one the episode says nothing about its policy.
    pub objects_in_reach: u32,
    /// Path length of the farthest robot at the end, cells.
    pub farthest_cells: f64,
    /// Objects in reach that were not found at the end.
    pub remaining: u32,
    /// Expected number of remaining objects by the merged belief.
    pub expected_remaining: f64,
    /// From the last find to the end, seconds of mission time.
    pub tail_seconds: f64,
    /// F1 at each of the setting's lengths.
    pub curve: Vec<f64>,
    /// Computing time of each decision.
    #[serde(rename = "decision_ns", with = "nanoseconds")]
    pub decisions: Vec<Duration>,
}

impl Trial {
    /// The results of an episode of a setting.
    #[must_use]
    pub fn new(setting: &Setting, seed: u64, episode: Episode) -> Self {
        let Episode { score, expected_remaining, path_cells, outcome, .. } = episode;
        Self {
            seed,
            auc_f1: outcome.f1.mean_until(setting.budget_cells),
            average_recall: outcome.recall.mean_until(setting.budget_cells),
            cells_to_full_recall: outcome.cells_to_full_recall,
            cells_to_recall: PARTIAL_RECALLS.map(|share| outcome.recall.first_at_least(share)),
            f1: score.f1(),
            recall: score.recall(),
            objects_in_reach: score.object_count(),
            farthest_cells: path_cells.into_iter().fold(0.0, f64::max),
            remaining: score.false_negatives,
            expected_remaining,
            tail_seconds: outcome.tail().as_secs_f64(),
            curve: setting.lengths().into_iter().map(|length| outcome.f1.at(length)).collect(),
            decisions: outcome.decisions,
        }
    }
}

/// A path length (cells) restricted to the budget: one that was not reached counts as the budget.
#[must_use]
pub fn restricted(cells: Option<f64>, budget_cells: f64) -> f64 {
    cells.map_or(budget_cells, |cells| cells.min(budget_cells))
}

/// Durations as whole nanoseconds, below 2^64 (five hundred years).
mod nanoseconds {
    use std::time::Duration;

    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(times: &[Duration], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(times.iter().map(Duration::as_nanos))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Duration>, D::Error> {
        let times: Vec<u64> = Deserialize::deserialize(deserializer)?;
        Ok(times.into_iter().map(Duration::from_nanos).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares of every size, as curves hold them.
    fn shares() -> Vec<f64> {
        (1..200_u32)
            .flat_map(|whole| (0..whole).map(move |part| f64::from(part) / f64::from(whole)))
            .collect()
    }

    #[test]
    fn numbers_survive_a_file_to_the_bit() {
        let trial = Trial {
            seed: u64::MAX,
            auc_f1: 0.1 + 0.2,
            average_recall: 1.0 / 3.0,
            cells_to_full_recall: Some(f64::MIN_POSITIVE),
            cells_to_recall: [Some(0.1), Some(1.0 / 3.0), None],
            f1: 1.0 - f64::EPSILON,
            recall: 0.0,
            objects_in_reach: 7,
            farthest_cells: 1e9 / 7.0,
            remaining: 3,
            expected_remaining: 0.1 / 3.0,
            tail_seconds: 1e3 / 7.0,
            curve: shares(),
            decisions: vec![Duration::from_nanos(1), Duration::from_nanos(u64::MAX)],
        };
        let json = serde_json::to_string(&trial).unwrap();
        assert_eq!(serde_json::from_str::<Trial>(&json).unwrap(), trial);
    }
}
