//! Episodes, many at a time.

use std::time::{Duration, Instant};

use dragnet_proto::participant::MindError;
use dragnet_proto::scenario::Scenario;
use dragnet_sim::episode;
use dragnet_sim::simulation::End;
use indicatif::ProgressBar;
use rayon::ThreadPoolBuilder;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::design::{Design, Setting};
use super::seeds::Seeds;
use super::trial::Trial;
use crate::commands::shard::Shard;
use crate::commands::{Failure, latency};
use crate::terminal::progress;

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

/// Episodes that were run.
pub(crate) struct Run {
    /// In the order of [`Design::share`].
    pub(crate) trials: Vec<Trial>,
    pub(crate) elapsed: Duration,
    pub(crate) threads: usize,
}

impl Experiment {
    /// What it is, apart from the means to run it.
    pub(crate) fn design(&self) -> Design {
        Design { settings: self.cases.iter().map(|case| case.setting.clone()).collect(), seeds: self.seeds }
    }

    /// Runs a shard's episodes, so many at a time; without a number, as many as there are cores. Trials do not depend on
    /// it, but for their computing times.
    pub(crate) fn run(&self, shard: Shard, threads: Option<u16>) -> Result<Run, Failure> {
        latency::warm_up();
        let threads = usize::from(threads.unwrap_or(0));
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(Failure::run)?;
        let episodes = self.share(shard);
        let bar = progress::alone(episodes.len() as u64, "episodes");
        let start = Instant::now();
        let trials = pool.install(|| run_all(&episodes, &bar)).map_err(Failure::run)?;
        bar.finish_and_clear();
        Ok(Run { trials, elapsed: start.elapsed(), threads: pool.current_num_threads() })
    }

    fn share(&self, shard: Shard) -> Vec<(&Case, u64)> {
        self.design().share(shard).map(|(_, setting, seed)| (&self.cases[setting], seed)).collect()
    }
}

fn run_all(episodes: &[(&Case, u64)], bar: &ProgressBar) -> Result<Vec<Trial>, MindError> {
    // One by one, since some take a thousand times as long as others.
    let trials = episodes.par_iter().with_max_len(1).map(|&(case, seed)| {
        let trial = case.run(seed);
        bar.inc(1);
        trial
    });
    trials.collect()
}

impl Case {
    /// A scenario whose robots decide as the label says.
    pub(crate) fn new(scenario: Scenario, policy: &str) -> Self {
        Self { setting: Setting::new(&scenario, policy.to_owned()), scenario }
    }

    fn run(&self, seed: u64) -> Result<Trial, MindError> {
        let episode = episode::run(&self.scenario, seed, End::AllFound)?;
        Ok(Trial::new(&self.setting, seed, episode))
    }
}
