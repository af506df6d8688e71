//! Which trajectories there are to be.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_learn::demonstration::Source;
use dragnet_learn::policy::PolicyName;
use dragnet_proto::scenario::Scenario;
use dragnet_sim::mixture;

use super::{Arguments, source};
use crate::commands::{Failure, comparison, complain, scenario};

/// All trajectories of a command, those of other shards included.
pub(in crate::commands) struct Plan {
    pub(super) source: Source,
    pub(super) jobs: Vec<Job>,
}

/// One trajectory.
pub(super) struct Job {
    pub(super) name: String,
    pub(super) seed: u64,
    search: Search,
}

enum Search {
    /// The same for every seed, and its digest.
    Given(Arc<(Scenario, String)>),
    Mixture,
}

/// What searches of a mixture are called.
const MIXTURE: &str = "mixture";

impl Plan {
    pub(super) fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let mut jobs = Vec::new();
        let mut add = |name: &str, search: &dyn Fn() -> Search| {
            for place in 0..arguments.seeds.count() {
                jobs.push(Job { name: name.to_owned(), seed: arguments.seeds.at(place), search: search() });
            }
        };
        if arguments.mixture {
            let last = arguments.seeds.at(arguments.seeds.count() - 1);
            if u32::try_from(last).is_err() {
                let most = u32::MAX;
                return Err(Failure::Input(format!(
                    "--seeds: seed {last}: a mixture has seeds up to {most}"
                )));
            }
            add(MIXTURE, &|| Search::Mixture);
        }
        let mut names = BTreeSet::from([MIXTURE.to_owned()]);
        for path in &arguments.scenarios {
            let scenario = scenario::load(path)?;
            let name = scenario.name().to_owned();
            if !names.insert(name.clone()) {
                let path = path.display();
                return Err(Failure::Input(format!(
                    "{path}: the name {name:?} is taken: files are named by it"
                )));
            }
            for warning in scenario.warnings() {
                complain("warning", &format!("{}: {warning}", path.display()));
            }
            let scenario = scenario::with(scenario, "--density", arguments.density, Scenario::with_density)?;
            let scenario = under(&scenario, arguments.expert)?;
            let digest = comparison::digest(&scenario).to_string();
            let given = Arc::new((scenario, digest));
            add(&name, &|| Search::Given(Arc::clone(&given)));
        }
        Ok(Self { source: source(arguments), jobs })
    }
}

impl Job {
    pub(super) fn scenario(&self) -> Result<Scenario, Failure> {
        match &self.search {
            Search::Given(given) => Ok(given.0.clone()),
            Search::Mixture => {
                let seed = u32::try_from(self.seed).unwrap_or(u32::MAX);
                mixture::scenario(seed).map_err(Failure::run)
            }
        }
    }

    /// Of all that decides the search but the seed and the expert.
    pub(super) fn digest(&self) -> Result<String, Failure> {
        match &self.search {
            Search::Given(given) => Ok(given.1.clone()),
            Search::Mixture => Ok(comparison::digest(&self.scenario()?).to_string()),
        }
    }
}

fn under(scenario: &Scenario, expert: PolicyName) -> Result<Scenario, Failure> {
    scenario.with_policy(expert).map_err(Failure::input)
}
