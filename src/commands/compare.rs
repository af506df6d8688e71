//! `dragnet compare`: policies against each other, over scenarios and seeds.

use std::path::{Path, PathBuf};

use dragnet_experiments::comparison::part::{self, Part};
use dragnet_experiments::comparison::{Case, Experiment};
use dragnet_experiments::seeds::Seeds;
use dragnet_experiments::shard::Shard;
use dragnet_scenario::Scenario;
use dragnet_scenario::file::PolicyField;
use dragnet_sim::simulation::End;

use super::comparison::{Origin, Output};
use super::scenario::Policies;
use super::{Failure, scenario};
use crate::VERSION;
use crate::terminal::progress::Bars;
use crate::terminal::{self, counted};

/// Compare policies over scenarios and seeds.
///
/// With the same seed every policy has the same objects, start cells and noise. An episode ends when every object is
/// found, as in the paper's trials, or when all robots rest; F1 and recall keep their last values up to the budget. The
/// area under F1 and the average recall are means over path lengths from 0 to the budget. Full recall is the path
/// length of the farthest robot until every object is found. The tail is the time from the last find to the end.
/// Results do not depend on the number of threads or shards.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet compare scenarios/paper/figure_four.toml --policies greedy,path --seeds 10
  dragnet compare scenarios/paper/*.toml --policies 'path,path(path_length_weight=1),tour' --seeds 50
  dragnet compare scenarios/paper/open_asterisk.toml --policies path,tour --density 0.01 --bound
  dragnet compare scenarios/paper/*.toml --policies random,coverage,greedy,path --density 0.01 --out results
  dragnet compare scenarios/paper/*.toml --policies greedy,path --seeds 50 --shard 3/8 --out parts")]
pub(crate) struct Arguments {
    /// Scenario files (TOML), or names that `dragnet scenarios` lists
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Policies to compare, separated by commas. Parameters in parentheses are those of scenarios; all others have
    /// their defaults
    #[arg(long, value_name = "A,B(KEY=VALUE,..),..", value_parser = scenario::POLICIES)]
    policies: Policies,
    /// Weights file for the policy gnn, instead of the built-in weights
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Seeds: N for 0 to N - 1, or A..B for A to B - 1; at most 1000000 of them
    #[arg(long, value_name = "N | A..B", default_value = "10", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Number of robots, 1 to 1000, instead of the scenario's
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    robots: Option<u32>,
    /// Probability that a searched cell holds an object, above 0 and below 1, instead of the scenario's objects
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    density: Option<f64>,
    /// Path length that each robot may drive, cells, at least 1, instead of all budgets of the scenario
    #[arg(long, value_name = "CELLS", allow_negative_numbers = true)]
    budget: Option<u32>,
    /// When an episode ends: `all_found` when every object is found or all robots rest, `resting` only when all robots
    /// rest
    #[arg(long, value_name = "WHEN", default_value = "all_found", value_parser = parse_end)]
    end: End,
    /// Also print a lower bound on the mean path length to full recall, proven for every policy, and how far above it
    /// each policy is; takes about a minute for each scenario
    #[arg(long, conflicts_with = "shard")]
    bound: bool,
    /// Number of episodes to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Run only shard I of N, 1 to N, and write its part to the folder of --out; `dragnet merge` joins the parts
    #[arg(
        long,
        value_name = "I/N",
        requires = "out",
        conflicts_with = "json",
        allow_negative_numbers = true
    )]
    shard: Option<Shard>,
    #[command(flatten)]
    output: Output,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let experiment = Experiment { cases: cases(arguments)?, seeds: arguments.seeds };
    arguments.output.prepare(&experiment.design())?;
    if let (Some(shard), Some(folder)) = (arguments.shard, &arguments.output.out) {
        return run_shard(&experiment, shard, folder, arguments.threads);
    }
    let bounds = if arguments.bound { experiment.bounds(arguments.threads, &Bars)? } else { Vec::new() };
    let done = experiment.run(Shard::WHOLE, arguments.threads, &Bars)?;
    arguments.output.tell(&experiment.design(), done.results, &bounds, Origin::Here(done.effort))
}

/// Runs a shard that has not been run yet.
fn run_shard(
    experiment: &Experiment,
    shard: Shard,
    folder: &Path,
    threads: Option<u16>,
) -> Result<(), Failure> {
    let path = Part::path(folder, shard);
    let design = experiment.design();
    if part::is_done(&path, VERSION, &design, shard)? {
        return Ok(terminal::print(&format!("shard {shard}: done already: {}\n", path.display()))?);
    }
    let done = experiment.run(shard, threads, &Bars)?;
    let (episodes, effort) = (counted(done.results.len(), "episode"), terminal::effort(done.effort));
    Part::new(VERSION, design, shard, done.results).write(&path)?;
    Ok(terminal::print(&format!("shard {shard}: {episodes} {effort}\nwritten: {}\n", path.display()))?)
}

/// Every policy on every scenario, as changed by the options.
fn cases(arguments: &Arguments) -> Result<Vec<Case>, Failure> {
    let policies = &arguments.policies.0;
    scenario::check_weights(arguments.weights.as_deref(), "--policies", policies)?;
    let mut cases = Vec::new();
    for scenario in scenario::load_each(&arguments.scenarios, &[])? {
        for policy in policies {
            let case = Case::new(changed(&scenario, policy, arguments)?, &policy.to_string());
            cases.push(case.until(arguments.end));
        }
    }
    Ok(cases)
}

fn changed(scenario: &Scenario, policy: &PolicyField, arguments: &Arguments) -> Result<Scenario, Failure> {
    let scenario = scenario::with_policy(scenario, "--policies", policy, arguments.weights.as_deref())?;
    let scenario = scenario::with(scenario, "--robots", arguments.robots, Scenario::with_robots)?;
    let scenario = scenario::with(scenario, "--density", arguments.density, Scenario::with_density)?;
    scenario::with(scenario, "--budget", arguments.budget, Scenario::with_budget_cells)
}

fn parse_end(text: &str) -> Result<End, String> {
    match text {
        "all_found" => Ok(End::AllFound),
        "resting" => Ok(End::Resting),
        _ => Err("allowed are all_found and resting".to_owned()),
    }
}
