//! The trajectories to record.

use std::sync::Arc;

use dragnet_learn::demonstration::Source;
use dragnet_learn::policy::PolicyName;
use dragnet_scenario::Scenario;
use dragnet_sim::{comparison, mixture};

use super::{Follow, Watch};
use crate::ExperimentError;
use crate::seeds::Seeds;

/// All trajectories of a command, those of other shards included.
pub struct Plan {
    pub(super) expert: PolicyName,
    pub(super) follow: Option<Follow>,
    pub(super) source: Source,
    pub(super) jobs: Vec<Job>,
}

/// One trajectory.
pub(super) struct Job {
    pub(super) name: String,
    pub(super) seed: u64,
    /// The search, if it is the same for every seed; `None` for one of a mixture, which is made when the job runs.
    given: Option<Arc<Search>>,
}

/// A scenario to search.
pub(super) struct Search {
    pub(super) scenario: Scenario,
    /// Digest of everything that determines the search except the seed and the expert.
    pub(super) digest: String,
}

/// Name of the searches of a mixture in file names.
pub const MIXTURE: &str = "mixture";

impl Plan {
    /// An empty plan of this version of the program.
    #[must_use]
    pub fn new(watch: Watch, program: &str) -> Self {
        let source = watch.source(program);
        Self { expert: watch.expert, follow: watch.follow, source, jobs: Vec::new() }
    }

    /// Adds a trajectory for each seed, each on its own generated scenario.
    ///
    /// # Errors
    /// If a seed is too large for a mixture.
    pub fn add_mixture(&mut self, seeds: Seeds) -> Result<(), ExperimentError> {
        seeds.of_mixture()?;
        self.add_jobs(MIXTURE, seeds, None);
        Ok(())
    }

    /// Adds a trajectory for each seed on a scenario. Its name must be unique and not [`MIXTURE`].
    ///
    /// # Errors
    /// If the expert cannot search it.
    pub fn add_scenario(&mut self, scenario: &Scenario, seeds: Seeds) -> Result<(), ExperimentError> {
        let search = Search::new(scenario.with_policy(self.expert).map_err(ExperimentError::input)?);
        self.add_jobs(scenario.name(), seeds, Some(&Arc::new(search)));
        Ok(())
    }

    fn add_jobs(&mut self, name: &str, seeds: Seeds, given: Option<&Arc<Search>>) {
        for place in 0..seeds.count() {
            self.jobs.push(Job { name: name.to_owned(), seed: seeds.at(place), given: given.cloned() });
        }
    }
}

impl Job {
    /// The search, with the expert's way to decide anew.
    pub(super) fn search(&self, expert: PolicyName) -> Result<Arc<Search>, ExperimentError> {
        if let Some(given) = &self.given {
            return Ok(Arc::clone(given));
        }
        let seed = u32::try_from(self.seed).unwrap_or(u32::MAX);
        let scenario = mixture::scenario(seed).map_err(ExperimentError::run)?;
        Ok(Arc::new(Search::new(scenario.with_policy(expert).map_err(ExperimentError::input)?)))
    }
}

impl Search {
    fn new(scenario: Scenario) -> Self {
        Self { digest: comparison::digest(&scenario).to_string(), scenario }
    }
}
