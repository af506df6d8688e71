//! `dragnet demonstrate`: an expert at work, as files that a network learns from.

pub(super) mod part;
mod plan;

use std::path::{Path, PathBuf};

use dragnet_learn::demonstration::{self, Source, Trajectory};
use dragnet_learn::policy::{self, PolicyName};
use dragnet_search::policy::Parameters;
use dragnet_sim::demonstration::watch;

use super::comparison::Seeds;
use super::shard::Shard;
use super::{Failure, jobs, output, scenario};
use crate::VERSION;
use crate::terminal::{self, counted};
use part::Part;
use plan::{Job, Plan, Search};

/// Record the decisions of an expert policy, to train a network on.
///
/// One file a trajectory, safetensors, which Python reads as well: beliefs, the cell that was chosen, and the expert's
/// scores. Files that are there already are kept, so a command that was stopped goes on where it was. Seeds that a
/// network has learned from say little about it: compare policies with others.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet demonstrate scenarios/paper/ice_cream_cone.toml --expert path --seeds 100000..101600 --out demonstrations
  dragnet demonstrate --mixture --expert path --seeds 2000 --out mixture --shard 1/4")]
pub(crate) struct Arguments {
    /// Scenario files (TOML)
    #[arg(required_unless_present = "mixture", conflicts_with = "mixture", value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Instead of scenarios: generated ones, another for each seed, of many sizes, densities, sensors and teams
    #[arg(long)]
    mixture: bool,
    /// Who is watched
    #[arg(long, value_parser = scenario::policy_names())]
    expert: PolicyName,
    /// A trajectory for each of these seeds, on each scenario: N for 0 to N - 1, or A..B for A to B - 1
    #[arg(long, value_name = "N | A..B", default_value = "100000..100150", allow_negative_numbers = true)]
    seeds: Seeds,
    /// A trajectory has at most so many decisions, those of all robots together
    #[arg(long, value_name = "N", default_value_t = 75, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    max_decisions: u32,
    /// After this share of the decisions robots go to a random cell instead of the expert's, which is written down all
    /// the same: what is learned then covers more than the expert's own ways
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = parse_share, allow_negative_numbers = true)]
    explore: f64,
    /// Each searched cell holds an object with this probability
    #[arg(long, value_name = "D", conflicts_with = "mixture", allow_negative_numbers = true)]
    density: Option<f64>,
    /// Searches that run at a time [default: as many as there are cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Run shard I of N only; `dragnet merge` checks that all are there, and joins them if they are in several folders
    #[arg(long, value_name = "I/N", allow_negative_numbers = true)]
    shard: Option<Shard>,
    /// Write the trajectories to this folder
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// A trajectory that is there.
struct Done {
    decisions: u64,
    was_there: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let plan = Plan::new(arguments)?;
    let folder = &arguments.out;
    output::make_folder(folder)?;
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let mine: Vec<&Job> =
        (0..).zip(&plan.jobs).filter(|(place, _)| shard.holds(*place)).map(|(_, job)| job).collect();
    let done = jobs::run(&mine, arguments.threads, "trajectories", |job| watch_one(job, &plan, folder))?;
    let (trajectories, effort) = (done.results, done.effort);
    let decisions = trajectories.iter().map(|trajectory| trajectory.decisions).sum();
    if arguments.shard.is_some() {
        Part::new(&plan, shard, decisions).write(folder)?;
    }
    let there = trajectories.iter().filter(|trajectory| trajectory.was_there).count();
    let text = format!(
        "{}, {} of {} {effort}{}\nwritten: {}\n",
        counted(trajectories.len(), "trajectory"),
        counted(usize::try_from(decisions).unwrap_or(usize::MAX), "decision"),
        plan.expert,
        if there > 0 { format!("; {there} were there already") } else { String::new() },
        folder.display(),
    );
    Ok(terminal::print(&text)?)
}

fn watch_one(job: &Job, plan: &Plan, folder: &Path) -> Result<Done, Failure> {
    let path = folder.join(demonstration::file_name(&job.name, job.seed));
    let search = job.search()?;
    let Search { scenario, digest } = &*search;
    if path.exists() {
        let known = demonstration::read(&path).map_err(Failure::input)?;
        check_is_same(&known, &plan.source, digest, &path)?;
        return Ok(Done { decisions: known.decisions.len() as u64, was_there: true });
    }
    let expert = || policy::build(plan.expert, Parameters::default(), None);
    let (source, digest) = (plan.source.clone(), digest.clone());
    let trajectory = watch(scenario, job.seed, source, digest, expert).map_err(Failure::run)?;
    demonstration::write(&path, &trajectory).map_err(Failure::run)?;
    Ok(Done { decisions: trajectory.decisions.len() as u64, was_there: false })
}

/// What is there may only be kept if it is what would be written now.
fn check_is_same(known: &Trajectory, source: &Source, digest: &str, path: &Path) -> Result<(), Failure> {
    if known.source == *source && known.scenario_digest == digest {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "{}: there already, and made otherwise: {}; now it would be {}. Choose another --out, or remove it",
        path.display(),
        describe(&known.source, &known.scenario_digest),
        describe(source, digest),
    )))
}

fn describe(source: &Source, digest: &str) -> String {
    let Source { expert, max_decisions, explore, program, .. } = source;
    format!(
        "{expert}, {max_decisions} decisions at most, exploring {explore}, scenario {digest}, by {program}"
    )
}

fn source(arguments: &Arguments) -> Source {
    Source {
        expert: arguments.expert.to_string(),
        path_length_weight: Parameters::default().path_length_weight,
        max_decisions: arguments.max_decisions,
        explore: arguments.explore,
        program: VERSION.to_owned(),
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err("allowed is a share from 0 to 1".to_owned()) }
}
