//! Episodes, many at a time.

use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::Scenario;
use dragnet_sim::comparison::{self, Setting, Trial};
use dragnet_sim::simulation::End;

use super::design::Design;
use super::seeds::Seeds;
use crate::commands::jobs::{self, Done};
use crate::commands::shard::Shard;
use crate::commands::{Failure, latency};

/// What is run: every case with every seed.
pub(crate) struct Experiment {
    pub(crate) cases: Vec<Case>,
    pub(crate) seeds: Seeds,
}

/// One policy on one scenario.
pub(crate) struct Case {
    pub(crate) setting: Setting,
    pub(crate) scenario: Scenario,
}

impl Experiment {
    /// What it is, apart from the means to run it.
    pub(crate) fn design(&self) -> Design {
        Design { settings: self.cases.iter().map(|case| case.setting.clone()).collect(), seeds: self.seeds }
    }

    /// Runs a shard's episodes, so many at a time; without a number, as many as there are cores. Trials do not depend on
    /// it, but for their computing times.
    pub(crate) fn run(&self, shard: Shard, threads: Option<u16>) -> Result<Done<Trial>, Failure> {
        latency::warm_up();
        jobs::run(&self.share(shard), threads, "episodes", |(case, seed)| {
            case.run(*seed).map_err(Failure::run)
        })
    }

    fn share(&self, shard: Shard) -> Vec<(&Case, u64)> {
        self.design().share(shard).map(|(_, setting, seed)| (&self.cases[setting], seed)).collect()
    }
}

impl Case {
    /// A scenario whose robots decide as the label says.
    pub(crate) fn new(scenario: Scenario, policy: &str) -> Self {
        Self { setting: Setting::new(&scenario, policy.to_owned()), scenario }
    }

    /// The same to another end of its episodes.
    pub(crate) fn until(mut self, end: End) -> Self {
        self.setting.end = end;
        self
    }

    fn run(&self, seed: u64) -> Result<Trial, ParticipantError> {
        comparison::run(&self.setting, &self.scenario, seed)
    }
}
