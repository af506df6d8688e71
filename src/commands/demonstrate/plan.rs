//! Which trajectories there are to be.

use std::collections::BTreeSet;
use std::sync::Arc;

use dragnet_learn::demonstration::Source;
use dragnet_learn::policy::PolicyName;
use dragnet_scenario::Scenario;
use dragnet_sim::mixture;

use super::{Arguments, source};
use crate::commands::{Failure, comparison, complain, scenario};

/// All trajectories of a command, those of other shards included.
pub(in crate::commands) struct Plan {
    pub(super) expert: PolicyName,
    pub(super) source: Source,
    pub(super) jobs: Vec<Job>,
}

/// One trajectory.
pub(super) struct Job {
    pub(super) name: String,
    pub(super) seed: u64,
    /// The same for every seed; none where it is one of a mixture, which is made when its turn comes.
    given: Option<Arc<Search>>,
}

/// What is searched.
pub(super) struct Search {
    pub(super) scenario: Scenario,
    /// Of all that decides the search but the seed and the expert.
    pub(super) digest: String,
}

/// What searches of a mixture are called.
const MIXTURE: &str = "mixture";

impl Plan {
    pub(super) fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let mut jobs = Vec::new();
        let mut add = |name: &str, given: Option<&Arc<Search>>| {
            for place in 0..arguments.seeds.count() {
                let seed = arguments.seeds.at(place);
                jobs.push(Job { name: name.to_owned(), seed, given: given.cloned() });
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
            add(MIXTURE, None);
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
            add(&name, Some(&Arc::new(Search::new(scenario))));
        }
        Ok(Self { expert: arguments.expert, source: source(arguments), jobs })
    }
}

impl Job {
    pub(super) fn search(&self) -> Result<Arc<Search>, Failure> {
        if let Some(given) = &self.given {
            return Ok(Arc::clone(given));
        }
        let seed = u32::try_from(self.seed).unwrap_or(u32::MAX);
        Ok(Arc::new(Search::new(mixture::scenario(seed).map_err(Failure::run)?)))
    }
}

impl Search {
    fn new(scenario: Scenario) -> Self {
        Self { digest: comparison::digest(&scenario).to_string(), scenario }
    }
}

fn under(scenario: &Scenario, expert: PolicyName) -> Result<Scenario, Failure> {
    scenario.with_policy(expert).map_err(Failure::input)
}
