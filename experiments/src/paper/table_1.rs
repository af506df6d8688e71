//! Table I: computing time of a decision.

use std::time::Duration;

use dragnet_agent::agent::Agent;
use dragnet_learn::policy::{self, PolicyName, Shipped};
use dragnet_scenario::Scenario;
use dragnet_search::policy::{Parameters, PathIntegralReference, Policy, PolicyName as Exact};
use dragnet_search::utility::UtilityTable;
use dragnet_sim::comparison::Latencies;
use dragnet_sim::episode;
use dragnet_sim::simulation::End;

use super::map::{Map, Size};
use super::markup::{Markup, Table};
use super::part::Part;
use super::published::{CLONE_SECONDS, GREEDY_SECONDS, PATH_SECONDS, SPEEDUP_OVER_GREEDY, SPEEDUP_OVER_PATH};
use super::section::{Claim, File, Section, Verdict, certain};
use crate::ExperimentError;
use crate::comparison::files;
use crate::progress::{Progress, Work};
use crate::seeds::Seeds;

/// The number that the paper averages over.
const DECISIONS: usize = 100;

/// A policy whose decisions are timed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decider {
    Named(PolicyName),
    PathIntegralReference,
}

const GREEDY: Decider = Decider::Named(PolicyName::Exact(Exact::Greedy));
const PATH: Decider = Decider::Named(PolicyName::Exact(Exact::Path));
const GREEDY_CLONE: Decider = Decider::Named(PolicyName::Learned(Shipped::GreedyIceCreamCone));
const PATH_CLONE: Decider = Decider::Named(PolicyName::Learned(Shipped::PathIceCreamCone));

/// Each with the paper's seconds, if given.
const DECIDERS: [(Decider, Option<f64>); 11] = [
    (GREEDY, Some(GREEDY_SECONDS)),
    (PATH, Some(PATH_SECONDS)),
    (Decider::PathIntegralReference, Some(PATH_SECONDS)),
    (Decider::Named(PolicyName::Exact(Exact::PathAdditive)), None),
    (GREEDY_CLONE, Some(CLONE_SECONDS)),
    (PATH_CLONE, Some(CLONE_SECONDS)),
    (Decider::Named(PolicyName::Learned(Shipped::General)), Some(CLONE_SECONDS)),
    (Decider::Named(PolicyName::Exact(Exact::Nats)), None),
    (Decider::Named(PolicyName::Exact(Exact::Guts)), None),
    (Decider::Named(PolicyName::Exact(Exact::Coverage)), None),
    (Decider::Named(PolicyName::Exact(Exact::Random)), None),
];

/// The measurements of a decider.
struct Timing {
    decider: Decider,
    paper_seconds: Option<f64>,
    median_ms: f64,
    mean_ms: f64,
}

impl Decider {
    fn name(self) -> &'static str {
        match self {
            Self::Named(policy) => policy.as_str(),
            Self::PathIntegralReference => "path, by its definition",
        }
    }

    fn policy(self) -> Box<dyn Policy + Send> {
        match self {
            Self::Named(name) => policy::build(name, Parameters::default(), None),
            Self::PathIntegralReference => {
                Box::new(PathIntegralReference::new(Parameters::default().path_length_weight))
            }
        }
    }
}

pub(super) fn section(seeds: Seeds, progress: &dyn Progress) -> Result<Section, ExperimentError> {
    let timings = measure(seeds, progress)?;
    Ok(Section {
        part: Part::Table1,
        title: "Time of a decision",
        body: Markup::new()
            .paragraph(
                "The paper: a decision of the clone takes 0.48 s, one of the greedy expert 5.30 s (11 times as long), one of the \
                 path-integral expert 122.00 s (254 times as long), averaged over 100 timesteps.",
            )
            .table(&times(&timings))
            .table(&ratios(&timings))
            .paragraph(&who_is_faster(&timings))
            .paragraph(
                "What a clone is good for: its cost for each cell is the same however expensive its expert is, so that it can \
                 stand in for experts without a closed form or with a deeper lookahead; it is differentiable; and it can \
                 learn from any expert, a person's choices included.",
            ),
        claims: vec![faster_than_greedy(&timings), faster_than_path(&timings), costly_path(&timings)],
        files: vec![File { name: "table-1.csv".to_owned(), content: csv(&timings).map_err(ExperimentError::run)? }],
    })
}

/// Decisions run one after the other, on one thread.
fn measure(seeds: Seeds, progress: &dyn Progress) -> Result<Vec<Timing>, ExperimentError> {
    UtilityTable::warm_up();
    let scenario = Map::IceCreamCone.scenario(Size::Thirty)?;
    let work = progress.begin((DECIDERS.len() * DECISIONS) as u64, "decisions");
    let timings = DECIDERS.iter().map(|&(decider, paper_seconds)| {
        let times = decisions(&scenario, decider, seeds, &*work)?;
        let mean_ms = times.iter().map(Duration::as_secs_f64).sum::<f64>() * 1e3 / times.len() as f64;
        let median_ms = Latencies::new(times).percentile_ms(50).unwrap_or(f64::NAN);
        Ok(Timing { decider, paper_seconds, median_ms, mean_ms })
    });
    timings.collect()
}

/// The first decisions of whole episodes, repeating the seeds while there are too few.
fn decisions(
    scenario: &Scenario,
    decider: Decider,
    seeds: Seeds,
    work: &dyn Work,
) -> Result<Vec<Duration>, ExperimentError> {
    // Its network is read and its code is cached before the first measured decision.
    let _ = episode_decisions(scenario, decider, seeds.at(0))?;
    let mut times = Vec::with_capacity(DECISIONS);
    for place in (0..seeds.count()).cycle().take(DECISIONS) {
        let new = episode_decisions(scenario, decider, seeds.at(place))?;
        times.extend(new.into_iter().take(DECISIONS - times.len()));
        if times.len() == DECISIONS {
            break;
        }
    }
    work.advance(DECISIONS as u64);
    Ok(times)
}

fn episode_decisions(
    scenario: &Scenario,
    decider: Decider,
    seed: u64,
) -> Result<Vec<Duration>, ExperimentError> {
    let mut robots =
        episode::team(scenario, seed, |agent_config| Agent::with_policy(agent_config, decider.policy()));
    let episode =
        episode::run_robots(scenario, seed, End::AllFound, &mut robots).map_err(ExperimentError::run)?;
    Ok(episode.outcome.decisions)
}

fn median_ms(timings: &[Timing], decider: Decider) -> f64 {
    timings.iter().find(|timing| timing.decider == decider).map_or(f64::NAN, |timing| timing.median_ms)
}

fn times(timings: &[Timing]) -> Table {
    let caption = format!(
        "Time of a decision on the ice cream cone of 30 x 30 cells, over {DECISIONS} decisions of whole episodes on one \
         thread, 20 % of the cells hold an object. `path, by its definition` has the same scores and walks every \
         candidate's path anew, as the paper's may."
    );
    let titles = ["policy", "median, ms", "mean, ms", "paper, s", "paper's row"];
    let mut table = Table::of_numbers(&caption, &titles);
    for timing in timings {
        table.row(vec![
            format!("`{}`", timing.decider.name()),
            format!("{:.3}", timing.median_ms),
            format!("{:.3}", timing.mean_ms),
            timing.paper_seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{seconds:.2}")),
            row_in_paper(timing).to_owned(),
        ]);
    }
    table
}

fn row_in_paper(timing: &Timing) -> &'static str {
    match (timing.decider, timing.paper_seconds) {
        (GREEDY, _) => "Greedy-EIG",
        (PATH | Decider::PathIntegralReference, _) => "Path-Integral EIG",
        (_, Some(_)) => "GNN-based Policy",
        (_, None) => "-",
    }
}

fn ratios(timings: &[Timing]) -> Table {
    let mut table = Table::of_numbers(
        "How many times as long the first takes as the second: here of the medians, in the paper of its seconds.",
        &["first", "second", "here", "paper"],
    );
    for (first, second, paper) in [
        (GREEDY, GREEDY_CLONE, Some(GREEDY_SECONDS / CLONE_SECONDS)),
        (PATH, PATH_CLONE, Some(PATH_SECONDS / CLONE_SECONDS)),
        (Decider::PathIntegralReference, PATH_CLONE, Some(PATH_SECONDS / CLONE_SECONDS)),
        (PATH, GREEDY, Some(PATH_SECONDS / GREEDY_SECONDS)),
        (Decider::PathIntegralReference, GREEDY, Some(PATH_SECONDS / GREEDY_SECONDS)),
        (Decider::PathIntegralReference, PATH, None),
    ] {
        table.row(vec![
            format!("`{}`", first.name()),
            format!("`{}`", second.name()),
            times_as(median_ms(timings, first) / median_ms(timings, second)),
            paper.map_or_else(|| "-".to_owned(), times_as),
        ]);
    }
    table
}

/// A ratio with about three significant digits.
fn times_as(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.2}") } else { format!("{ratio:.0}") }
}

fn who_is_faster(timings: &[Timing]) -> String {
    let ratio = |first, second| median_ms(timings, first) / median_ms(timings, second);
    let compared = |expert: Decider, clone: Decider| {
        let (ratio, name, clone) = (ratio(clone, expert), expert.name(), clone.name());
        if ratio > 1.0 {
            format!("`{name}` is {} times as fast as its clone `{clone}`", times_as(ratio))
        } else {
            format!("the clone `{clone}` is {} times as fast as `{name}`", times_as(1.0 / ratio))
        }
    };
    let conclusion = if ratio(PATH_CLONE, PATH) > 1.0 {
        " At this size a clone saves no time: a speedup over the expert is one over its implementation."
    } else {
        ""
    };
    format!(
        "Here {}, and {}. Both experts are exact; all candidates of the path-integral one are weighed in a single walk over \
         the tree of shortest paths, which is {} times as fast as walking each path anew. Compared with that, {}.{conclusion}",
        compared(GREEDY, GREEDY_CLONE),
        compared(PATH, PATH_CLONE),
        times_as(ratio(Decider::PathIntegralReference, PATH)),
        compared(Decider::PathIntegralReference, PATH_CLONE),
    )
}

fn faster_than_greedy(timings: &[Timing]) -> Claim {
    let ratio = median_ms(timings, GREEDY) / median_ms(timings, GREEDY_CLONE);
    Claim {
        part: Part::Table1,
        paper: "The clone decides 11 times as fast as the greedy expert.",
        here: format!("{} times as fast.", times_as(ratio)),
        verdict: Verdict::of(&[certain(ratio - SPEEDUP_OVER_GREEDY)]),
    }
}

fn faster_than_path(timings: &[Timing]) -> Claim {
    let ratio = |expert| median_ms(timings, expert) / median_ms(timings, PATH_CLONE);
    Claim {
        part: Part::Table1,
        paper: "The clone decides 254 times as fast as the path-integral expert.",
        here: format!(
            "{} times as fast; {} times as fast as that expert by its definition.",
            times_as(ratio(PATH)),
            times_as(ratio(Decider::PathIntegralReference))
        ),
        verdict: Verdict::of(&[certain(ratio(PATH) - SPEEDUP_OVER_PATH)]),
    }
}

fn costly_path(timings: &[Timing]) -> Claim {
    let ratio = |expert| median_ms(timings, expert) / median_ms(timings, GREEDY);
    let of_paper = PATH_SECONDS / GREEDY_SECONDS;
    Claim {
        part: Part::Table1,
        paper: "The path-integral expert takes 23 times as long as the greedy one.",
        here: format!(
            "{} times as long; {} times by its definition. A lower cost than the paper's counts as not holding.",
            times_as(ratio(PATH)),
            times_as(ratio(Decider::PathIntegralReference))
        ),
        verdict: Verdict::of(&[certain(ratio(PATH) - of_paper)]),
    }
}

fn csv(timings: &[Timing]) -> Result<Vec<u8>, csv::Error> {
    files::table(["policy", "decisions", "median_ms", "mean_ms", "paper_seconds"], |writer| {
        timings.iter().try_for_each(|timing| {
            let Timing { decider, paper_seconds, median_ms, mean_ms } = timing;
            writer.serialize((decider.name(), DECISIONS, median_ms, mean_ms, paper_seconds))
        })
    })
}
