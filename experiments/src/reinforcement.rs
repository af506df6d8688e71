//! Searches of a network to learn from, on the mixture that demonstrations are recorded on.
//!
//! Only searches of one robot are taken: in a team the search of each depends on what all decide.

use std::sync::Arc;

use dragnet_agent::agent::Agent;
use dragnet_learn::network::Network;
use dragnet_learn::policy::{Gnn, PolicyName, Shipped};
use dragnet_learn::reinforcement::Visit;
use dragnet_scenario::Scenario;
use dragnet_sim::comparison::restricted;
use dragnet_sim::simulation::End;
use dragnet_sim::{episode, mixture, reinforcement};

use crate::ExperimentError;
use crate::jobs;
use crate::progress::Progress;
use crate::seeds::Seeds;

/// Searches of the seeds of a mixture that have one robot.
pub struct Searches {
    searches: Vec<(u64, Scenario)>,
    threads: Option<u16>,
}

impl Searches {
    /// The searches of these seeds, on this many threads, by default one for each core.
    ///
    /// # Errors
    /// If a seed is too large for a mixture.
    pub fn new(seeds: Seeds, threads: Option<u16>) -> Result<Self, ExperimentError> {
        let mut searches = Vec::new();
        for seed in seeds.of_mixture()? {
            let scenario = mixture::scenario(seed).map_err(ExperimentError::run)?;
            if scenario.robots().len() == 1 {
                // It decides at its waypoints, as networks do.
                let name = PolicyName::Learned(Shipped::Tour);
                searches.push((seed.into(), scenario.with_policy(name).map_err(ExperimentError::input)?));
            }
        }
        Ok(Self { searches, threads })
    }

    /// Explores each of them with a network, at a temperature.
    ///
    /// # Errors
    /// If a search fails or the work is cancelled.
    pub fn explore(
        &self,
        network: &Arc<Network>,
        temperature: f64,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Visit>>, ExperimentError> {
        let explore = |(seed, scenario): &(u64, Scenario)| {
            reinforcement::explore(scenario, *seed, network, temperature).map_err(ExperimentError::run)
        };
        Ok(jobs::run(&self.searches, self.threads, "searches", progress, explore)?.results)
    }

    /// Mean length of the searches until all objects are found, cells, if robots decide with a network; a search that
    /// misses any counts as its budget.
    ///
    /// # Errors
    /// If a search fails or the work is cancelled.
    pub fn mean_cells(
        &self,
        network: &Arc<Network>,
        progress: &dyn Progress,
    ) -> Result<f64, ExperimentError> {
        let measure = |(seed, scenario): &(u64, Scenario)| {
            let mut robots = episode::team(scenario, *seed, |config| {
                Agent::with_policy(config, Box::new(Gnn::new(Arc::clone(network))))
            });
            let ended = episode::run_robots(scenario, *seed, End::AllFound, &mut robots);
            let cells = ended.map_err(ExperimentError::run)?.outcome.cells_to_full_recall;
            Ok(restricted(cells, scenario.budget_cells()))
        };
        let cells = jobs::run(&self.searches, self.threads, "searches", progress, measure)?.results;
        Ok(cells.iter().sum::<f64>() / cells.len() as f64)
    }

    /// Number of searches.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.searches.len()
    }

    /// Whether no seed has one robot.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.searches.is_empty()
    }
}
