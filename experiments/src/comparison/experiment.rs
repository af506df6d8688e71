//! Runs many episodes in parallel.

use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::comparison::bound;
use dragnet_sim::comparison::{self, Setting, Trial};
use dragnet_sim::simulation::End;

use super::design::Design;
use crate::ExperimentError;
use crate::jobs::{self, Done};
use crate::progress::Progress;
use crate::seeds::Seeds;
use crate::shard::Shard;

/// An experiment: every case with every seed.
pub struct Experiment {
    /// The cases, in the order of their rows.
    pub cases: Vec<Case>,
    /// The seeds of each case.
    pub seeds: Seeds,
}

/// One policy on one scenario.
pub struct Case {
    pub(crate) setting: Setting,
    pub(crate) scenario: Scenario,
}

impl Experiment {
    /// Its description without the scenarios.
    #[must_use]
    pub fn design(&self) -> Design {
        Design { settings: self.cases.iter().map(|case| case.setting.clone()).collect(), seeds: self.seeds }
    }

    /// Runs a shard's episodes on this many threads, by default one for each core. Trials do not depend on the number,
    /// except for their computing times.
    ///
    /// # Errors
    /// If an episode fails, or the system provides no threads.
    pub fn run(
        &self,
        shard: Shard,
        threads: Option<u16>,
        progress: &dyn Progress,
    ) -> Result<Done<Trial>, ExperimentError> {
        run_episodes(&self.share(shard), threads, progress)
    }

    /// The least path length to full recall that any policy needs in the mean, cells, by scenario.
    ///
    /// # Errors
    /// If there is no such bound for a scenario, or the system provides no threads.
    pub fn bounds(
        &self,
        threads: Option<u16>,
        progress: &dyn Progress,
    ) -> Result<Vec<(String, f64)>, ExperimentError> {
        // Cases of one scenario differ in their policies alone.
        let of_scenarios = self.cases.chunk_by(|a, b| a.setting.scenario == b.setting.scenario);
        let scenarios: Vec<&Scenario> = of_scenarios.map(|cases| &cases[0].scenario).collect();
        let refuse = |scenario: &Scenario, error| {
            ExperimentError::Input(format!("--bound: {}: {error}", scenario.name()))
        };
        // Some bounds take minutes: what has none is told before.
        for scenario in &scenarios {
            bound::check(scenario).map_err(|error| refuse(scenario, error))?;
        }
        let bounds = jobs::run(&scenarios, threads, "bounds", progress, |scenario| {
            let bound =
                bound::least_cells_to_full_recall(scenario).map_err(|error| refuse(scenario, error))?;
            Ok((scenario.name().to_owned(), bound))
        });
        Ok(bounds?.results)
    }

    fn share(&self, shard: Shard) -> Vec<(&Case, u64)> {
        self.design().share(shard).map(|(_, setting, seed)| (&self.cases[setting], seed)).collect()
    }
}

/// Runs episodes, each of a case with a seed, on this many threads, by default one for each core.
///
/// # Errors
/// If an episode fails, or the system provides no threads.
pub fn run_episodes(
    episodes: &[(&Case, u64)],
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Done<Trial>, ExperimentError> {
    UtilityTable::warm_up();
    jobs::run(episodes, threads, "episodes", progress, |(case, seed)| {
        case.run(*seed).map_err(ExperimentError::run)
    })
}

impl Case {
    /// A scenario whose robots use the policy of the label.
    #[must_use]
    pub fn new(scenario: Scenario, policy: &str) -> Self {
        Self { setting: Setting::new(&scenario, policy.to_owned()), scenario }
    }

    /// The same with another end of its episodes.
    #[must_use]
    pub fn until(mut self, end: End) -> Self {
        self.setting.end = end;
        self
    }

    fn run(&self, seed: u64) -> Result<Trial, ParticipantError> {
        comparison::run(&self.setting, &self.scenario, seed)
    }
}
