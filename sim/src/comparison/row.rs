//! The summary of all episodes of one policy on one scenario.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::trial::restricted;
use super::{Latencies, PARTIAL_RECALLS, Setting, Trial};

/// One policy on one scenario, over all seeds. Names are those of the JSON object.
#[derive(Serialize)]
pub struct Row {
    /// Name of the scenario.
    pub scenario: String,
    /// The built-in shape, or the map's file without folder and extension.
    pub map: String,
    /// Label of the robots' policy.
    pub policy: String,
    /// Robots in the team.
    pub robots: usize,
    /// Number of seeds.
    pub seeds: usize,
    /// Path length that each robot may drive.
    pub budget_cells: f64,
    /// Mean of F1 over path lengths up to the budget, `0..=1`.
    pub auc_f1: Estimate,
    /// Mean of recall over path lengths up to the budget, `0..=1`.
    pub average_recall: Estimate,
    /// Path length of the farthest robot until every object was found, cells.
    pub cells_to_full_recall: CellsToRecall,
    /// The same until 50, 80 and 95 % of them were found.
    pub cells_to_recall: Vec<CellsToRecall>,
    /// Objects in reach that were not found at the end of an episode.
    pub remaining: Estimate,
    /// Expected number of remaining objects by the belief at that time. If episodes end by it, the two have the same
    /// mean.
    pub expected_remaining: Estimate,
    /// Episodes that ended with an object not found.
    pub seeds_with_remaining: usize,
    /// Episodes without an object in reach: they say nothing about a policy, and count in all means, as if every object had
    /// been found at once. All policies have the same.
    pub seeds_without_object: usize,
    /// From the last find to the end of an episode, seconds of mission time.
    pub tail_s: Estimate,
    /// Computing time of a decision.
    pub decision_ms: DecisionTimes,
    /// F1 by path length.
    pub curve: MeanCurve,
    /// The objects, in words.
    #[serde(skip)]
    pub objects: String,
    #[serde(skip)]
    /// The episodes, by seed; without computing times.
    pub trials: Vec<Trial>,
}

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// Mean of the values.
    pub mean: f64,
    /// Unknown from one value.
    pub sem: Option<f64>,
}

/// Path length of the farthest robot until a share of the objects was found, cells.
#[derive(Serialize)]
pub struct CellsToRecall {
    /// The share, `0..=1`.
    pub recall: f64,
    /// Restricted mean over all seeds: one that did not reach the share within the budget counts as the budget.
    pub restricted_mean: f64,
    /// Its standard error; unknown from one value.
    pub restricted_sem: Option<f64>,
    /// Seeds that reached the share.
    pub reached: usize,
    /// Mean over those only; unknown if there is none.
    pub mean: Option<f64>,
    /// Its standard error; unknown from one value.
    pub sem: Option<f64>,
}

/// Milliseconds, over all decisions; `None` without one.
#[derive(Serialize)]
pub struct DecisionTimes {
    /// Half of them took no longer.
    pub p50: Option<f64>,
    /// 99 % of them took no longer.
    pub p99: Option<f64>,
}

/// F1 by path length, shape `[lengths]` each.
#[derive(Serialize)]
pub struct MeanCurve {
    /// Path length of the farthest robot.
    pub cells: Vec<f64>,
    /// Mean F1.
    pub mean: Vec<f64>,
    /// Its standard error.
    pub sem: Vec<Option<f64>>,
}

impl Row {
    /// The summary of a setting's trials, by seed; at least one.
    #[must_use]
    pub fn new(setting: &Setting, mut trials: Vec<Trial>) -> Self {
        let decisions: Vec<Duration> =
            trials.iter_mut().flat_map(|trial| std::mem::take(&mut trial.decisions)).collect();
        Self {
            scenario: setting.scenario.clone(),
            map: setting.map.clone(),
            policy: setting.policy.clone(),
            robots: setting.robots,
            seeds: trials.len(),
            budget_cells: setting.budget_cells,
            auc_f1: Estimate::of(trials.iter().map(|trial| trial.auc_f1)),
            average_recall: Estimate::of(trials.iter().map(|trial| trial.average_recall)),
            cells_to_full_recall: CellsToRecall::of(
                1.0,
                setting,
                trials.iter().map(|it| it.cells_to_full_recall),
            ),
            cells_to_recall: (0..PARTIAL_RECALLS.len())
                .map(|place| {
                    let cells = trials.iter().map(|trial| trial.cells_to_recall[place]);
                    CellsToRecall::of(PARTIAL_RECALLS[place], setting, cells)
                })
                .collect(),
            remaining: Estimate::of(trials.iter().map(|trial| f64::from(trial.remaining))),
            expected_remaining: Estimate::of(trials.iter().map(|trial| trial.expected_remaining)),
            seeds_with_remaining: trials.iter().filter(|trial| trial.remaining > 0).count(),
            seeds_without_object: trials.iter().filter(|trial| trial.objects_in_reach == 0).count(),
            tail_s: Estimate::of(trials.iter().map(|trial| trial.tail_seconds)),
            decision_ms: DecisionTimes::of(decisions),
            curve: MeanCurve::of(setting.lengths(), &trials),
            objects: setting.objects.clone(),
            trials,
        }
    }
}

impl Estimate {
    /// Estimate of at least one value; the standard error is that of a sample, `sqrt(sum (x - mean)^2 / (n - 1) / n)`.
    #[must_use]
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
        Self { mean, sem: (count > 1.0).then(|| (squares / (count - 1.0) / count).sqrt()) }
    }
}

impl CellsToRecall {
    fn of(recall: f64, setting: &Setting, cells: impl Iterator<Item = Option<f64>> + Clone) -> Self {
        let restricted = Estimate::of(cells.clone().map(|cells| restricted(cells, setting.budget_cells)));
        let reached = cells.clone().flatten().count();
        let estimate = (reached > 0).then(|| Estimate::of(cells.flatten()));
        Self {
            recall,
            restricted_mean: restricted.mean,
            restricted_sem: restricted.sem,
            reached,
            mean: estimate.map(|it| it.mean),
            sem: estimate.and_then(|it| it.sem),
        }
    }
}

impl DecisionTimes {
    fn of(decisions: Vec<Duration>) -> Self {
        let latencies = Latencies::new(decisions);
        Self { p50: latencies.percentile_ms(50), p99: latencies.percentile_ms(99) }
    }
}

impl MeanCurve {
    fn of(lengths: Vec<f64>, trials: &[Trial]) -> Self {
        let at = |place: usize| Estimate::of(trials.iter().map(move |trial| trial.curve[place]));
        let (mean, sem) = (0..lengths.len()).map(at).map(|it| (it.mean, it.sem)).unzip();
        Self { cells: lengths, mean, sem }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_error_is_that_of_a_sample() {
        let estimate = Estimate::of([1.0, 2.0, 3.0, 4.0].into_iter());
        assert!((estimate.mean - 2.5).abs() < 1e-12);
        // Sample variance 5/3, over 4 values.
        assert!((estimate.sem.unwrap() - (5.0_f64 / 12.0).sqrt()).abs() < 1e-12);
        assert_eq!(Estimate::of([7.0].into_iter()), Estimate { mean: 7.0, sem: None });
    }
}
