//! The contenders of the field test, and their trials.

use std::path::Path;
use std::time::Duration;

use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_scenario::Scenario;
use dragnet_scenario::shipped::FOLDER;
use dragnet_scenario::time::MissionTime;
use dragnet_search::policy::PolicyName as Exact;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::field::{self, DecisionTime, Trial};

use crate::progress::Progress;
use crate::seeds::Seeds;
use crate::{ExperimentError, jobs};

use super::super::published::FIELD_BUDGET_SECONDS;

/// The three named configurations, beyond the seeds of the others.
pub(super) const CONFIGURATIONS: [(&str, u64); 3] = [("A", 90_001), ("B", 90_002), ("C", 90_003)];

/// A policy with its decision time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contender {
    policy: PolicyName,
    robots: u32,
    /// Mission time of a decision.
    pub(super) thinking_seconds: u64,
}

/// The first is `nats` whose decisions take no time.
pub(super) const CONTENDERS: [Contender; 8] = [
    Contender::nats(0),
    Contender::nats(10),
    Contender::nats(30),
    Contender::alone(PolicyName::Learned(Shipped::GreedyIceCreamCone)),
    Contender::alone(PolicyName::Learned(Shipped::GreedyAllTraversable)),
    Contender::alone(PolicyName::Learned(Shipped::PathIceCreamCone)),
    Contender::alone(PolicyName::Exact(Exact::Path)),
    Contender { robots: 3, ..Contender::alone(PolicyName::Exact(Exact::Path)) },
];

impl Contender {
    const fn alone(policy: PolicyName) -> Self {
        Self { policy, robots: 1, thinking_seconds: 0 }
    }

    pub(super) const fn nats(thinking_seconds: u64) -> Self {
        Self { thinking_seconds, ..Self::alone(PolicyName::Exact(Exact::Nats)) }
    }

    pub(super) fn is_nats(&self) -> bool {
        self.policy == PolicyName::Exact(Exact::Nats)
    }

    /// Its row in the paper's table, if it has one: NATS, the clones of greedy (ICC, AT), that of path.
    pub(super) fn in_paper(&self) -> Option<usize> {
        match self.policy {
            PolicyName::Exact(Exact::Nats) => Some(0),
            PolicyName::Learned(Shipped::GreedyIceCreamCone) => Some(1),
            PolicyName::Learned(Shipped::GreedyAllTraversable) => Some(2),
            PolicyName::Learned(Shipped::PathIceCreamCone) => Some(3),
            _ => None,
        }
    }

    pub(super) fn title(&self) -> String {
        match *self {
            Self { policy, thinking_seconds: 0, robots: 1 } => format!("`{policy}`"),
            Self { policy, thinking_seconds: 0, robots } => format!("`{policy}`, {robots} robots"),
            Self { policy, thinking_seconds, .. } => format!("`{policy}`, {thinking_seconds} s a waypoint"),
        }
    }

    fn scenario(&self, field: &Scenario) -> Result<Scenario, ExperimentError> {
        let scenario = field.with_policy(self.policy).map_err(ExperimentError::run)?;
        scenario.with_robots(self.robots).map_err(ExperimentError::run)
    }
}

/// The trials of all contenders.
pub(super) struct Trials {
    /// Of the named configurations, then of the others by seed, shape `[configurations][contenders]`.
    trials: Vec<[Trial; CONTENDERS.len()]>,
    seeds: Vec<u64>,
}

/// A trial as a line of a table, in the order of [`TITLES`].
type Line = (&'static str, u64, &'static str, u32, u64, Option<f64>, f64, u32, f64, u64, usize, String);

/// Titles of the columns of the trials' table.
pub(super) const TITLES: [&str; 12] = [
    "configuration",
    "seed",
    "policy",
    "robots",
    "decision_seconds",
    "found_seconds",
    "ended_seconds",
    "false_finds",
    "driven_meters",
    "observations",
    "decisions",
    "evidence",
];

/// Runs the named configurations and those of all seeds.
pub(super) fn run(
    seeds: Seeds,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Trials, ExperimentError> {
    UtilityTable::warm_up();
    let field = Scenario::load(&Path::new(FOLDER).join("field.toml")).map_err(ExperimentError::run)?;
    let named = CONFIGURATIONS.iter().map(|&(_, seed)| seed);
    let seeds: Vec<u64> = named.chain((0..seeds.count()).map(|place| seeds.at(place))).collect();
    let scenarios = CONTENDERS.iter().map(|contender| Ok((contender, contender.scenario(&field)?)));
    let scenarios = scenarios.collect::<Result<Vec<_>, ExperimentError>>()?;
    let jobs: Vec<(u64, usize)> =
        seeds.iter().flat_map(|&seed| (0..CONTENDERS.len()).map(move |place| (seed, place))).collect();
    let done = jobs::run(&jobs, threads, "trials", progress, |&(seed, place)| {
        let (contender, scenario) = &scenarios[place];
        let thinking = DecisionTime { time: Duration::from_secs(contender.thinking_seconds) };
        field::run(scenario, seed, thinking).map_err(ExperimentError::run)
    })?;
    let mut results = done.results.into_iter();
    let mut trials = Vec::new();
    while let Some(first) = results.next() {
        let rest: Vec<Trial> = results.by_ref().take(CONTENDERS.len() - 1).collect();
        let all: Vec<Trial> = std::iter::once(first).chain(rest).collect();
        trials.extend(<[Trial; CONTENDERS.len()]>::try_from(all));
    }
    Ok(Trials { trials, seeds })
}

impl Trials {
    /// Random configurations.
    pub(super) fn count(&self) -> usize {
        self.trials.len() - CONFIGURATIONS.len()
    }

    fn of<'a>(&'a self, contender: &Contender) -> impl Iterator<Item = &'a Trial> {
        let place = CONTENDERS.iter().position(|one| one == contender).unwrap_or(0);
        self.trials.iter().map(move |trials| &trials[place])
    }

    fn random_of<'a>(&'a self, contender: &Contender) -> impl Iterator<Item = &'a Trial> {
        self.of(contender).skip(CONFIGURATIONS.len())
    }

    /// Seconds until all objects were found in the named configurations, at most those of the mission.
    pub(super) fn configurations(&self, contender: &Contender) -> Vec<f64> {
        self.of(contender).take(CONFIGURATIONS.len()).map(seconds).collect()
    }

    /// Likewise in the others.
    pub(super) fn random(&self, contender: &Contender) -> Vec<f64> {
        self.random_of(contender).map(seconds).collect()
    }

    /// Path length of the robot that drove farthest in the others, meters.
    pub(super) fn paths(&self, contender: &Contender) -> Vec<f64> {
        self.random_of(contender).map(max_range_meters).collect()
    }

    pub(super) fn mean_false_finds(&self, contender: &Contender) -> f64 {
        let all: u32 = self.random_of(contender).map(|trial| trial.score.false_positives).sum();
        f64::from(all) / self.count() as f64
    }

    pub(super) fn decisions(&self, contender: &Contender) -> Vec<Duration> {
        self.of(contender).flat_map(|trial| trial.decisions.iter().copied()).collect()
    }

    pub(super) fn lines(&self) -> impl Iterator<Item = Line> + '_ {
        let names = CONFIGURATIONS.iter().map(|&(name, _)| name).chain(std::iter::repeat("random"));
        self.trials.iter().zip(&self.seeds).zip(names).flat_map(|((trials, &seed), configuration)| {
            CONTENDERS
                .iter()
                .zip(trials)
                .map(move |(contender, trial)| line(configuration, seed, contender, trial))
        })
    }
}

fn line(configuration: &'static str, seed: u64, contender: &Contender, trial: &Trial) -> Line {
    (
        configuration,
        seed,
        contender.policy.as_str(),
        contender.robots,
        contender.thinking_seconds,
        trial.found.map(MissionTime::as_seconds),
        trial.ended.as_seconds(),
        trial.score.false_positives,
        max_range_meters(trial),
        trial.observations,
        trial.decisions.len(),
        format!("{:032x}", trial.digest.0),
    )
}

fn seconds(trial: &Trial) -> f64 {
    trial.found.map_or(FIELD_BUDGET_SECONDS, |time| time.as_seconds().min(FIELD_BUDGET_SECONDS))
}

fn max_range_meters(trial: &Trial) -> f64 {
    trial.driven_meters.iter().copied().fold(0.0, f64::max)
}
