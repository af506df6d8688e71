//! `dragnet demonstrate`: records an expert's decisions for training.

use std::path::PathBuf;

use dragnet_experiments::demonstrations::{self, Follow, MIXTURE, Part, Plan, Watch};
use dragnet_experiments::output;
use dragnet_experiments::seeds::Seeds;
use dragnet_experiments::shard::Shard;
use dragnet_learn::policy::PolicyName;
use dragnet_scenario::Scenario;

use super::{Failure, scenario};
use crate::VERSION;
use crate::terminal::progress::Bars;
use crate::terminal::{self, counted};

/// Record the decisions of an expert policy, to train a network.
///
/// Writes one safetensors file for each trajectory: beliefs, chosen cells, and the expert's scores. Files that exist
/// are kept, so a command that was interrupted can be repeated and continues. Do not compare policies on seeds that a
/// network was trained on.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet demonstrate scenarios/paper/ice_cream_cone.toml --expert path --seeds 100000..101600 --out demonstrations
  dragnet demonstrate --mixture --expert path --seeds 2000 --out mixture --shard 1/4")]
pub(crate) struct Arguments {
    /// Scenario files (TOML), or names that `dragnet scenarios` lists
    #[arg(required_unless_present = "mixture", conflicts_with = "mixture", value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Generate a different scenario for each seed, with random map, density, sensor and team, instead of reading
    /// scenarios
    #[arg(long)]
    mixture: bool,
    /// The policy to record
    #[arg(long, value_parser = scenario::policy_names())]
    expert: PolicyName,
    /// Seeds, each for one trajectory on each scenario: N for 0 to N - 1, or A..B for A to B - 1; at most 1000000 of
    /// them
    #[arg(long, value_name = "N | A..B", default_value = "100000..100150", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Maximum number of decisions in a trajectory, of all robots together, at least 1
    #[arg(long, value_name = "N", default_value_t = 75, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    max_decisions: u32,
    /// Share of decisions, 0 to 1, after which a robot goes to a random cell instead of the expert's. The expert's
    /// decision is recorded in any case, so the network also learns from situations that the expert would not reach
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = parse_share, allow_negative_numbers = true)]
    explore: f64,
    /// Weights file of a network that the robots follow instead of the expert. The expert's decisions are recorded in any
    /// case, so the network learns from the situations that it leads to itself
    #[arg(long, value_name = "FILE")]
    follow: Option<PathBuf>,
    /// Probability that a searched cell holds an object, above 0 and below 1, instead of the scenario's objects
    #[arg(long, value_name = "D", conflicts_with = "mixture", allow_negative_numbers = true)]
    density: Option<f64>,
    /// Number of searches to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Run only shard I of N, 1 to N; `dragnet merge` checks that all shards are complete, and joins those in several
    /// folders
    #[arg(long, value_name = "I/N", allow_negative_numbers = true)]
    shard: Option<Shard>,
    /// Write the trajectories to this folder; existing trajectories are kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let plan = plan(arguments)?;
    let folder = &arguments.out;
    output::make_folder(folder)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let recorded = demonstrations::record(&plan, shard, arguments.threads, folder, &Bars)?;
    if arguments.shard.is_some() {
        Part::new(&plan, shard, recorded.decisions).write(folder)?;
    }
    let there = recorded.were_there;
    let text = format!(
        "{}, {} of {} {}{}\nwritten: {}\n",
        counted(recorded.trajectories, "trajectory"),
        counted(usize::try_from(recorded.decisions).unwrap_or(usize::MAX), "decision"),
        arguments.expert,
        terminal::effort(recorded.effort),
        if there > 0 { format!("; {there} were there already") } else { String::new() },
        folder.display(),
    );
    Ok(terminal::print(&text)?)
}

/// The trajectories of all shards.
fn plan(arguments: &Arguments) -> Result<Plan, Failure> {
    let Arguments { expert, max_decisions, explore, seeds, .. } = *arguments;
    let follow = arguments.follow.as_deref().map(Follow::load).transpose()?;
    let mut plan = Plan::new(Watch { expert, max_decisions, explore, follow }, VERSION);
    if arguments.mixture {
        plan.add_mixture(seeds).map_err(|error| Failure::Input(format!("--seeds: {error}")))?;
    }
    for scenario in scenario::load_each(&arguments.scenarios, &[MIXTURE])? {
        let scenario = scenario::with(scenario, "--density", arguments.density, Scenario::with_density)?;
        if scenario.only_class().is_none_or(|class| class.flies) {
            let of_one =
                "demonstrations have one map and one sensor; allowed are robots of one class, on the ground";
            return Err(Failure::Input(format!("{}: {of_one}", scenario.name())));
        }
        if scenario.mission().return_reserve.is_some() {
            let without = "demonstrations know no base; allowed is mission.return_to_base = false";
            return Err(Failure::Input(format!("{}: {without}", scenario.name())));
        }
        plan.add_scenario(&scenario, seeds)?;
    }
    Ok(plan)
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err("allowed is a share from 0 to 1".to_owned()) }
}
