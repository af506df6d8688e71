//! Figure 8: the beliefs and tracks of the greedy and the path-integral expert after two and nine decisions.

use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;
use dragnet_search::policy::PolicyName;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::world::World;

use super::map::{Map, Size};
use super::markup::{Markup, Table};
use super::measure;
use super::part::Part;
use super::picture::{self, Way};
use super::section::{Claim, File, Section, Verdict, below_zero};
use super::trace::{self, Trace};
use crate::ExperimentError;
use crate::comparison::{Estimate, estimate, files};
use crate::progress::Progress;
use crate::seeds::Seeds;

/// The two experts first.
const POLICIES: [PolicyName; 6] = [
    PolicyName::Greedy,
    PolicyName::Path,
    PolicyName::Nats,
    PolicyName::Guts,
    PolicyName::Coverage,
    PolicyName::Random,
];
const EXPERTS: usize = 2;
const EARLY: usize = 2;
const LATE: usize = 9;

/// The paper does not say which map it shows. On this one a search takes nine decisions and more; on ICC about six.
const MAP: Map = Map::OpenAsterisk;

/// One seed, in numbers.
struct Walk {
    seed: u64,
    /// By [`POLICIES`].
    numbers: [Numbers; POLICIES.len()],
    /// How many more cells `path` is certain of than `greedy` at the same path length: the shorter one at their
    /// [`LATE`] decisions.
    more_certain: f64,
    /// How many fewer cells it has entered again.
    fewer_again: f64,
}

/// One search, in numbers.
#[derive(Clone, Copy)]
struct Numbers {
    /// Number of its decisions, at most [`LATE`].
    decisions: usize,
    early: State,
    late: State,
}

/// Cells that were entered, that are certain, and that were entered again.
#[derive(Clone, Copy)]
struct State {
    entered: usize,
    certain: usize,
    again: usize,
}

pub(super) fn section(seeds: Seeds, progress: &dyn Progress) -> Result<Section, ExperimentError> {
    let scenarios = scenarios()?;
    let walks = watch_all(&scenarios, seeds, progress)?;
    let is_whole = |walk: &&Walk| walk.numbers[..EXPERTS].iter().all(|it| it.decisions == LATE);
    let shown = walks.iter().find(is_whole).unwrap_or(&walks[0]).seed;
    Ok(Section {
        part: Part::Figure8,
        title: "Beliefs and tracks of the two experts",
        body: pictures(&scenarios, shown)?.table(&table(&walks, seeds)),
        claims: vec![certainty(&walks), redundancy(&walks)],
        files: vec![File {
            name: "figure-8.csv".to_owned(),
            content: csv(&walks).map_err(ExperimentError::run)?,
        }],
    })
}

/// By [`POLICIES`].
fn scenarios() -> Result<Vec<Scenario>, ExperimentError> {
    let scenario = MAP.scenario(Size::Thirty)?;
    POLICIES.iter().map(|&policy| scenario.with_policy(policy).map_err(ExperimentError::run)).collect()
}

fn watch_all(
    scenarios: &[Scenario],
    seeds: Seeds,
    progress: &dyn Progress,
) -> Result<Vec<Walk>, ExperimentError> {
    UtilityTable::warm_up();
    let work = progress.begin(seeds.count(), "seeds watched");
    let walks = (0..seeds.count()).map(|place| {
        let walk = walk(scenarios, seeds.at(place));
        work.advance(1);
        walk
    });
    walks.collect()
}

fn walk(scenarios: &[Scenario], seed: u64) -> Result<Walk, ExperimentError> {
    let watch = |scenario| trace::watch(scenario, seed, LATE).map_err(ExperimentError::run);
    let traces = scenarios.iter().map(watch).collect::<Result<Vec<Trace>, _>>()?;
    let (greedy, path) = (&traces[0], &traces[1]);
    let way = greedy.at(LATE).entered.min(path.at(LATE).entered);
    Ok(Walk {
        seed,
        numbers: std::array::from_fn(|place| Numbers::of(&traces[place])),
        more_certain: path.certain[way] as f64 - greedy.certain[way] as f64,
        fewer_again: greedy.entered_again(way) as f64 - path.entered_again(way) as f64,
    })
}

impl Numbers {
    fn of(trace: &Trace) -> Self {
        let state = |decision| {
            let entered = trace.at(decision).entered;
            State { entered, certain: trace.certain[entered], again: trace.entered_again(entered) }
        };
        Self { decisions: trace.waypoints(), early: state(EARLY), late: state(LATE) }
    }
}

fn pictures(scenarios: &[Scenario], seed: u64) -> Result<Markup, ExperimentError> {
    let traces = scenarios
        .iter()
        .zip(POLICIES)
        .map(|(scenario, policy)| {
            Ok((policy, trace::watch(scenario, seed, LATE).map_err(ExperimentError::run)?))
        })
        .collect::<Result<Vec<_>, ExperimentError>>()?;
    let (experts, baselines) = traces.split_at(EXPERTS);
    let panel =
        |&(policy, ref trace): &(PolicyName, Trace), decision| belief(&scenarios[0], policy, trace, decision);
    let terrain = scenarios[0].terrain();
    let world = World::new(&scenarios[0], seed);
    let start = traces[0].1.track[0];
    let mut first = vec![picture::truth(
        terrain,
        world.truth(),
        start,
        "Truth: open cells white, objects blue, the start a circle",
    )];
    for decision in [EARLY, LATE] {
        first.extend(experts.iter().map(|expert| panel(expert, decision)));
    }
    let others = baselines.iter().flat_map(|it| [panel(it, EARLY), panel(it, LATE)]).collect::<Vec<_>>();
    Ok(Markup::new()
        .paragraph(
            "The paper: path-integral search favors long, unvisited paths early and near unexplored regions later, so that \
             its paths overlap little; the greedy expert may drive the same path again. After nine timesteps both have gone \
             about equally far, and path-integral search is certain of significantly more cells. It shows one search and \
             no numbers.",
        )
        .then(&picture::legend())
        .figure("panels", &caption(seed), &first)
        .figure("panels", "The baselines on the same truth.", &others))
}

fn caption(seed: u64) -> String {
    format!(
        "`greedy` and `path` at decisions {EARLY} and {LATE} on one truth: {}, 20 % of the cells hold an object, seed \
         {seed}. Colors are the probability of an object; the line is the way, from the circle through the numbered \
         waypoints.",
        MAP.title()
    )
}

fn belief(scenario: &Scenario, policy: PolicyName, trace: &Trace, decision: usize) -> Markup {
    let stop = trace.at(decision);
    let reached = decision.min(trace.waypoints());
    let waypoints: Vec<Cell> =
        trace.stops[1..=reached].iter().map(|stop| trace.track[stop.entered]).collect();
    let rested = if reached < decision { " (then it rested)" } else { "" };
    let caption = format!("{policy}, decision {reached}, {} cells{rested}", stop.entered);
    let way = Way { track: &trace.track[..=stop.entered], waypoints: &waypoints };
    picture::belief(scenario.terrain(), &stop.belief, way, &caption)
}

/// The mean of one number over all seeds.
fn mean(walks: &[Walk], policy: usize, number: impl Fn(Numbers) -> usize) -> Estimate {
    Estimate::of(walks.iter().map(|walk| number(walk.numbers[policy]) as f64))
}

fn table(walks: &[Walk], seeds: Seeds) -> Table {
    let caption = format!(
        "The same over {seeds}, mean and standard error: the way, the searched cells whose probability is at least tau or at \
         most 1 - tau (tau 0.95), and the cells that were entered again. A search that ended before its decision {LATE} \
         counts as it ended."
    );
    let titles = [
        "policy",
        "cells, decision 2",
        "certain",
        "cells, decision 9",
        "certain",
        "entered again",
        "came to decision 9",
    ];
    let mut table = Table::of_numbers(&caption, &titles);
    for (place, policy) in POLICIES.iter().enumerate() {
        let mean = |number: fn(Numbers) -> usize| {
            let it = self::mean(walks, place, number);
            estimate(Some(it.mean), it.sem, 1)
        };
        let came = walks.iter().filter(|walk| walk.numbers[place].decisions == LATE).count();
        table.row(vec![
            format!("`{policy}`"),
            mean(|it| it.early.entered),
            mean(|it| it.early.certain),
            mean(|it| it.late.entered),
            mean(|it| it.late.certain),
            mean(|it| it.late.again),
            format!("{came} of {}", walks.len()),
        ]);
    }
    table
}

fn certainty(walks: &[Walk]) -> Claim {
    let more = Estimate::of(walks.iter().map(|walk| walk.more_certain));
    let measured_texts = |number: fn(Numbers) -> usize| {
        let [greedy, path] = [0, 1].map(|expert| mean(walks, expert, number).mean);
        format!("{path:.0} and {greedy:.0}")
    };
    Claim {
        part: Part::Figure8,
        paper: "After nine decisions and about the same path length path-integral search is certain of significantly more cells than \
                greedy search.",
        here: format!(
            "Path and greedy after nine decisions: {} cells driven, {} cells certain. At the same path length (the shorter one) \
             path is certain of {} cells.",
            measured_texts(|it| it.late.entered),
            measured_texts(|it| it.late.certain),
            measure::signed(more, 1)
        ),
        verdict: Verdict::of(&[more]),
    }
}

fn redundancy(walks: &[Walk]) -> Claim {
    let [greedy, path] = [0, 1].map(|expert| mean(walks, expert, |it| it.late.again));
    let fewer = Estimate::of(walks.iter().map(|walk| walk.fewer_again));
    Claim {
        part: Part::Figure8,
        paper: "The paths of path-integral search overlap less than those of greedy search.",
        here: format!(
            "Cells entered again within nine decisions: path {}, greedy {}; at the same path length (the shorter one) path has \
             {}.",
            estimate(Some(path.mean), path.sem, 1),
            estimate(Some(greedy.mean), greedy.sem, 1),
            measure::signed(below_zero(fewer), 1)
        ),
        verdict: Verdict::of(&[fewer]),
    }
}

fn csv(walks: &[Walk]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "policy",
        "seed",
        "decisions",
        "cells_at_2",
        "certain_at_2",
        "entered_again_at_2",
        "cells_at_9",
        "certain_at_9",
        "entered_again_at_9",
    ];
    files::table(titles, |writer| {
        for (place, policy) in POLICIES.iter().enumerate() {
            for walk in walks {
                let Numbers { decisions, early, late } = walk.numbers[place];
                let early = (early.entered, early.certain, early.again);
                let late = (late.entered, late.certain, late.again);
                writer.serialize((policy.as_str(), walk.seed, decisions, early, late))?;
            }
        }
        Ok(())
    })
}
