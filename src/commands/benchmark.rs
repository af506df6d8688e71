//! `dragnet benchmark`: policies on a frozen track, and verification of such results.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use dragnet_experiments::benchmark::verify::{self, Sample};
use dragnet_experiments::benchmark::{ALL_GROUPS, BenchmarkResult, Entry, Program, Summary, Track};
use dragnet_experiments::comparison::{Case, Trial, estimate, run_episodes};

use super::scenario::Policies;
use super::{Failure, complain, output, scenario};
use crate::terminal::progress::Bars;
use crate::terminal::table::Table;
use crate::terminal::{self, counted};

/// Measure policies on a frozen track, or verify such a result.
///
/// Without a track it lists the tracks. A track is a set of searches and seeds that never changes under one version. The
/// result file has every episode of every policy, a summary, and digests of the track, of the networks' weights and of
/// itself. --verify runs its episodes again and reports those that differ; then the exit code is 1. Rules, measures and a
/// table of results: docs/benchmark.md.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet benchmark
  dragnet benchmark smoke --policies path,tour --out result.json
  dragnet benchmark single --policies 'path(path_length_weight=1),tour(evaluations=100)' --out result.json
  dragnet benchmark --verify result.json
  dragnet benchmark --verify result.json --sample 50 --seed 7")]
pub(crate) struct Arguments {
    /// The track; without one the tracks are listed
    #[arg(value_name = "TRACK", requires = "policies")]
    track: Option<String>,
    /// Policies to measure, separated by commas. Parameters in parentheses are those of scenarios; all others have
    /// their defaults
    #[arg(long, value_name = "A,B(KEY=VALUE,..),..", value_parser = scenario::POLICIES, requires = "track")]
    policies: Option<Policies>,
    /// Write the result to this file (JSON), which must not exist
    #[arg(long, value_name = "FILE", requires = "track")]
    out: Option<PathBuf>,
    /// Run the episodes of this result again, and report those that differ
    #[arg(long, value_name = "FILE", conflicts_with = "track")]
    verify: Option<PathBuf>,
    /// Verify this number of its episodes, drawn from all of them, instead of all
    #[arg(long, value_name = "N", requires = "verify", allow_negative_numbers = true)]
    sample: Option<u64>,
    /// Seed that the sample is drawn with
    #[arg(long, value_name = "SEED", value_parser = scenario::parse_seed, default_value = "0", requires = "sample", allow_negative_numbers = true)]
    seed: u64,
    /// Weights file for the policy gnn, instead of the built-in weights
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Number of episodes to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match (&arguments.track, &arguments.policies, &arguments.verify) {
        (Some(track), Some(policies), _) => run(track, policies, arguments),
        (_, _, Some(file)) => verify(file, arguments),
        _ => list(),
    }
}

fn list() -> Result<(), Failure> {
    let mut table = Table::new(["track", "about", "version", "searches", "episodes"]);
    for name in Track::names() {
        let track = Track::named(name)?;
        let counts = [track.searches().len(), track.episodes().count()].map(|count| count.to_string());
        let [searches, episodes] = counts;
        let about = track.about().to_owned();
        table.push([name.to_owned(), about, track.version().to_string(), searches, episodes]);
    }
    Ok(terminal::print(&table.draw(2))?)
}

fn run(track: &str, policies: &Policies, arguments: &Arguments) -> Result<(), Failure> {
    let weights = arguments.weights.as_deref();
    let track = Track::named(track)?;
    scenario::check_weights(weights, "--policies", &policies.0)?;
    let out = arguments.out.as_deref().map(|path| output::free("--out", path, "no result is")).transpose()?;
    let (mut entries, mut cases) = (Vec::new(), Vec::new());
    for policy in &policies.0 {
        let entry = Entry::of_policy(policy.to_string(), policy, weights)?;
        cases.push(entry.cases(&track, weights)?);
        entries.push(entry);
    }
    let episodes: Vec<(&Case, u64)> = cases
        .iter()
        .flat_map(|cases| track.episodes().map(|(search, seed)| (&cases[search], seed)))
        .collect();
    let done = run_episodes(&episodes, arguments.threads, &Bars)?;
    let (count, effort) = (counted(done.results.len(), "episode"), terminal::effort(done.effort));
    let mut trials = done.results.into_iter();
    let trials_of = |entry: Entry| (entry, trials.by_ref().take(track.episodes().count()).collect());
    let results: Vec<(Entry, Vec<Trial>)> = entries.into_iter().map(trials_of).collect();
    let result = BenchmarkResult::new(&track, program(), results);
    let mut text =
        format!("{} version {}: {count} {effort}\n\n{}", track.name(), track.version(), tables(&result));
    if let Some(path) = out {
        result.write(&path)?;
        let _ = write!(text, "\nwritten: {}, digest {}\n", path.display(), result.digest());
    }
    Ok(terminal::print(&text)?)
}

/// A table for the whole track, then one for each group of searches.
fn tables(result: &BenchmarkResult) -> String {
    let groups = result.policies.first().map_or(&[][..], |policy| &policy.summary);
    let mut places: Vec<usize> = (0..groups.len()).collect();
    // The whole track, which is the last, goes first.
    places.rotate_right(1);
    let mut text = String::new();
    for place in places {
        let mut table =
            Table::new(["policy", "cells to full recall", "reached", "average recall", "decision ms"]);
        for policy in &result.policies {
            table.push(columns(&policy.name, &policy.summary[place]));
        }
        let name = if groups[place].group == ALL_GROUPS { "whole track" } else { &groups[place].group };
        let _ = writeln!(text, "{name}\n{}", table.draw(1));
    }
    text + NOTE
}

fn columns(policy: &str, summary: &Summary) -> [String; 5] {
    let (cells, recall) = (summary.cells_to_full_recall, summary.average_recall);
    [
        policy.to_owned(),
        estimate(Some(cells.mean), cells.sem, 1),
        format!("{} of {}", summary.reached, summary.episodes),
        estimate(Some(recall.mean), recall.sem, 3),
        estimate(summary.decision_ms_p50, None, 2),
    ]
}

const NOTE: &str = "\
Cells to full recall: path length of the farthest robot until every object is found; a restricted mean, in which a search
that does not find all counts as its budget. Means ± standard errors; of the whole track those of the groups' means.
";

fn verify(file: &Path, arguments: &Arguments) -> Result<(), Failure> {
    let program = program();
    let (result, track) = BenchmarkResult::read(file, &program)?;
    if result.program().commit != program.commit {
        let commit = |commit: &Option<String>| commit.clone().unwrap_or_else(|| "unknown".to_owned());
        let (theirs, ours) = (commit(&result.program().commit), commit(&program.commit));
        complain(
            "warning",
            &format!(
                "{}: of commit {theirs}; this is commit {ours}, which may decide otherwise",
                file.display()
            ),
        );
    }
    let sample = arguments.sample.map(|count| Sample { count, seed: arguments.seed });
    let places = verify::places(&result, sample)?;
    let weights = arguments.weights.as_deref();
    let done = verify::run(&result, &track, &places, weights, arguments.threads, &Bars)?;
    let count = counted(places.len(), "episode");
    let mut text = String::new();
    for different in &done.results {
        let _ = writeln!(text, "{different}");
    }
    let _ = writeln!(
        text,
        "{}: {} of {count} differ, run {}",
        file.display(),
        done.results.len(),
        terminal::effort(done.effort)
    );
    terminal::print(&text)?;
    if done.results.is_empty() {
        return Ok(());
    }
    Err(Failure::Run(format!("{}: {} of {count} differ", file.display(), done.results.len())))
}

fn program() -> Program {
    Program { version: env!("CARGO_PKG_VERSION").to_owned(), commit: Some(env!("DRAGNET_COMMIT").to_owned()) }
}
