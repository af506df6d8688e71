//! `dragnet compare`: policies against each other, over scenarios and seeds.

mod experiment;
mod files;
mod report;
mod row;
mod seeds;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Instant;

use dragnet_proto::scenario::Scenario;
use dragnet_search::policy::PolicyName;
use rayon::ThreadPoolBuilder;

use super::{Failure, complain, latency, scenario};
use crate::terminal::{self, progress};
use experiment::{Case, Experiment};
use report::Report;
use seeds::Seeds;

/// Compare policies over scenarios and seeds.
///
/// With the same seed every policy meets the same objects, starts and noise. An episode ends when every object is found,
/// as the paper's trials do, or when the budget is spent; F1 keeps its last value up to the budget. The area under it is
/// its mean over the way from 0 to the budget, full recall the way of the farthest robot until every object
/// was found. Results do not depend on the number of threads.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet compare scenarios/paper/figure_four.toml --policies greedy,path --seeds 10
  dragnet compare scenarios/paper/*.toml --policies random,coverage,greedy,path --density 0.01 --out results")]
pub(crate) struct Arguments {
    /// Scenario files (TOML)
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Policies, separated by commas, each as it is without parameters
    #[arg(long, required = true, value_delimiter = ',', value_name = "A,B,..", value_parser = scenario::policy_names())]
    policies: Vec<PolicyName>,
    /// Seeds: N for 0 to N - 1, or A..B for A to B - 1
    #[arg(long, value_name = "N | A..B", default_value = "10", allow_negative_numbers = true)]
    seeds: Seeds,
    /// So many robots
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    robots: Option<u32>,
    /// Each searched cell holds an object with this probability
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    density: Option<f64>,
    /// Way that each robot may cover, instead of all budgets of the scenario
    #[arg(long, value_name = "CELLS", allow_negative_numbers = true)]
    budget: Option<u32>,
    /// Episodes that run at a time [default: as many as there are cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Write tables (CSV) and the curves of each scenario (SVG) to this folder, over older ones
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let experiment = Experiment { cases: cases(arguments)?, seeds: arguments.seeds };
    if let Some(folder) = &arguments.out {
        files::prepare(folder)?;
    }
    latency::warm_up();
    let threads = usize::from(arguments.threads.unwrap_or(0));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(Failure::run)?;
    let bar = progress::alone(experiment.episode_count(), "episodes");
    let start = Instant::now();
    let results = pool.install(|| experiment.run(&bar)).map_err(Failure::run)?;
    let report = Report { results: &results, seeds: arguments.seeds, threads: pool.current_num_threads() };
    bar.finish_and_clear();
    let written = match &arguments.out {
        Some(folder) => files::write(folder, &results, arguments.seeds)?,
        None => Vec::new(),
    };
    if arguments.json {
        return Ok(terminal::print_json(&report.json())?);
    }
    Ok(terminal::print(&report.text(start.elapsed(), &written))?)
}

/// Every policy on every scenario, as the options change it.
fn cases(arguments: &Arguments) -> Result<Vec<Case>, Failure> {
    let mut policies = BTreeSet::new();
    if let Some(twice) = arguments.policies.iter().find(|&&policy| !policies.insert(policy)) {
        return Err(Failure::Input(format!("--policies: {twice} is there twice")));
    }
    let mut names = BTreeSet::new();
    let mut cases = Vec::new();
    for path in &arguments.scenarios {
        let scenario = scenario::load(path)?;
        if !names.insert(scenario.name().to_owned()) {
            let name = scenario.name();
            return Err(Failure::Input(format!(
                "{}: a scenario before it is also named {name:?}",
                path.display()
            )));
        }
        for warning in scenario.warnings() {
            complain("warning", &format!("{}: {warning}", path.display()));
        }
        for &policy in &arguments.policies {
            cases.push(Case::new(changed(&scenario, policy, arguments)?, policy));
        }
    }
    Ok(cases)
}

fn changed(scenario: &Scenario, policy: PolicyName, arguments: &Arguments) -> Result<Scenario, Failure> {
    let scenario = scenario::with(scenario.clone(), "--policies", Some(policy), Scenario::with_policy)?;
    let scenario = scenario::with(scenario, "--robots", arguments.robots, Scenario::with_robots)?;
    let scenario = scenario::with(scenario, "--density", arguments.density, Scenario::with_density)?;
    scenario::with(scenario, "--budget", arguments.budget, Scenario::with_budget_cells)
}
