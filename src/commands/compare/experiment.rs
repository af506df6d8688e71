//! Episodes, many at a time.

use std::time::Duration;

use dragnet_proto::participant::MindError;
use dragnet_proto::scenario::Scenario;
use dragnet_search::policy::PolicyName;
use dragnet_sim::episode::{self, Episode};
use dragnet_sim::simulation::End;
use indicatif::ProgressBar;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::row::Row;
use super::seeds::Seeds;
use crate::commands::scenario::budget_cells;

/// A curve has about so many points at most.
const MAX_POINTS: f64 = 1000.0;

/// What is run: every case with every seed.
pub(super) struct Experiment {
    pub(super) cases: Vec<Case>,
    pub(super) seeds: Seeds,
}

/// One policy on one scenario.
pub(super) struct Case {
    pub(super) scenario: Scenario,
    pub(super) policy: PolicyName,
    /// Way that each robot may cover.
    pub(super) budget_cells: f64,
    /// Ways (cells) at which curves are read: from 0 on, the budget last.
    pub(super) lengths: Vec<f64>,
}

/// What is kept of an episode.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trial {
    pub(super) seed: u64,
    /// Mean of F1 over the way up to the budget.
    pub(super) auc_f1: f64,
    pub(super) cells_to_full_recall: Option<f64>,
    /// F1 and recall at the end.
    pub(super) f1: f64,
    pub(super) recall: f64,
    /// Way of the farthest robot at the end.
    pub(super) farthest_cells: f64,
    /// F1 at each of the case's lengths.
    pub(super) curve: Vec<f64>,
    pub(super) decisions: Vec<Duration>,
}

impl Experiment {
    pub(super) fn episode_count(&self) -> u64 {
        self.cases.len() as u64 * self.seeds.count()
    }

    /// Runs all episodes, as many at a time as the pool of this thread has threads. A row a case, in their order.
    pub(super) fn run(&self, bar: &ProgressBar) -> Result<Vec<Row>, MindError> {
        let jobs: Vec<(&Case, u64)> = self
            .cases
            .iter()
            .flat_map(|case| (0..self.seeds.count()).map(move |place| (case, self.seeds.at(place))))
            .collect();
        // One by one, since some take a thousand times as long as others.
        let trials = jobs.par_iter().with_max_len(1).map(|&(case, seed)| {
            let trial = case.run(seed);
            bar.inc(1);
            trial
        });
        let mut trials = trials.collect::<Result<Vec<Trial>, MindError>>()?;
        let count = usize::try_from(self.seeds.count()).unwrap_or(usize::MAX);
        Ok(self.cases.iter().map(|case| Row::new(case, trials.drain(..count).collect())).collect())
    }
}

impl Case {
    pub(super) fn new(scenario: Scenario, policy: PolicyName) -> Self {
        let budget_cells = budget_cells(&scenario);
        Self { lengths: lengths(budget_cells), scenario, policy, budget_cells }
    }

    fn run(&self, seed: u64) -> Result<Trial, MindError> {
        let Episode { score, path_cells, outcome, .. } = episode::run(&self.scenario, seed, End::AllFound)?;
        Ok(Trial {
            seed,
            auc_f1: outcome.f1.mean_until(self.budget_cells),
            cells_to_full_recall: outcome.cells_to_full_recall,
            f1: score.f1(),
            recall: score.recall(),
            farthest_cells: path_cells.into_iter().fold(0.0, f64::max),
            curve: self.lengths.iter().map(|&length| outcome.f1.at(length)).collect(),
            decisions: outcome.decisions,
        })
    }
}

/// Every cell of the budget, or every so many of a large one.
fn lengths(budget_cells: f64) -> Vec<f64> {
    let step = (budget_cells / MAX_POINTS).ceil().max(1.0);
    let steps = std::iter::successors(Some(0.0), |length| Some(length + step));
    steps.take_while(|&length| length < budget_cells).chain([budget_cells]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_read_at_every_cell_and_at_the_budget() {
        assert_eq!(lengths(2.5), [0.0, 1.0, 2.0, 2.5]);
        assert_eq!(lengths(2.0), [0.0, 1.0, 2.0]);
        assert_eq!(lengths(0.4), [0.0, 0.4]);
        let large = lengths(12_345.0);
        assert_eq!((large[1], large.len()), (13.0, 951));
    }
}
