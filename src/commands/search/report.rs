//! The report of a search: one JSON object, or text with a map.

use std::collections::BTreeMap;

use dragnet_coordinator::finds::{self, FindCounts, of_subject};
use dragnet_proto::message::Detection;
use dragnet_proto::zones::Zone;
use dragnet_runtime::team::Medium;
use dragnet_scenario::Scenario;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::subjects::Standing;
use dragnet_sim::comparison::Latencies;
use dragnet_sim::episode::Episode;
use serde::Serialize;

use super::Ended;
use super::narrator::{Find, Watched};
use super::traffic::{self, Sent};
use crate::commands::scenario;
use crate::terminal::map::Picture;
use crate::terminal::{self, counted};

/// The maximum number of objects that are listed.
const MAX_LISTED: usize = 20;

/// The measures of a search. Names are those of the JSON object.
#[derive(Serialize)]
pub(super) struct Report {
    scenario: String,
    seed: u64,
    policy: String,
    robots: usize,
    objects: usize,
    /// Of these, objects that no robot can observe: they do not count in any measure.
    objects_out_of_reach: usize,
    found: u32,
    false_positives: u32,
    /// Cells that are declared to hold an object, by index.
    declared: Vec<Declared>,
    /// Of these, finds that the operator has confirmed.
    confirmed: usize,
    /// Finds that the operator has dismissed and that are not declared any more.
    dismissed: usize,
    /// Cells that the operator has closed, and those that are skipped.
    no_go_cells: usize,
    skipped_cells: usize,
    /// This and the next three are undefined without an object in reach.
    recall: Option<f64>,
    precision: Option<f64>,
    f1: Option<f64>,
    /// Mean of F1 over path lengths up to the budget.
    auc_f1: Option<f64>,
    /// Path length of each robot, by number.
    path_cells: Vec<f64>,
    /// Robots that are back at their bases, if they are to return there.
    robots_at_base: Option<usize>,
    mission_time_s: f64,
    /// Expected number of objects in reach beyond those found.
    expected_remaining: f64,
    /// Searched cells that no robot can observe, and the number of objects expected there.
    cells_out_of_reach: usize,
    expected_out_of_reach: f64,
    /// Where the subjects are; absent unless their number is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<Subject>,
    /// When the last of the declared cells was found; absent if none is declared.
    last_find_s: Option<f64>,
    /// Duration from then, or else from the start, to the end.
    tail_s: f64,
    decisions: usize,
    decision_ms: DecisionTimes,
    observations_sent: u64,
    observations_merged: Option<u64>,
    /// Medium of the messages.
    messages_over: Medium,
    /// Messages sent, counted once for each receiver; unknown without a simulator.
    messages_sent: Option<u64>,
    /// Messages sent until the search ended, by kind, counted once; unknown without a simulator.
    traffic: Option<BTreeMap<&'static str, Sent>>,
    /// Messages that were replaced or dropped while they waited for a radio; unknown without a simulator.
    messages_unsent: Option<u64>,
    beliefs_equal: bool,
    /// Whether objects, finds and quality are by all readings that the robots have; not by a simulator that was started
    /// during the search.
    has_all_readings: bool,
    belief_digest: String,
    recording: Option<String>,
}

/// Expected numbers of subjects by all readings: `found`, `remaining` and `rest_of_world` add up to `number`.
#[derive(Serialize)]
struct Subject {
    number: u32,
    /// In declared cells.
    found: f64,
    /// In other searched cells.
    remaining: f64,
    /// Those of them that are out of every robot's reach.
    out_of_reach: f64,
    /// Outside of the searched cells.
    rest_of_world: f64,
}

impl From<Standing> for Subject {
    fn from(Standing { number, found, remaining, out_of_reach, rest_of_world }: Standing) -> Self {
        Self { number, found, remaining, out_of_reach, rest_of_world }
    }
}

/// A cell that is declared to hold an object.
#[derive(Serialize)]
struct Declared {
    row: u32,
    column: u32,
    /// The cell's center; absent if the map is not georeferenced.
    #[serde(skip_serializing_if = "Option::is_none")]
    latitude_degrees: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    longitude_degrees: Option<f64>,
    probability: f64,
    /// Whether there is one.
    is_object: bool,
}

/// Milliseconds; absent without a decision.
#[derive(Serialize)]
struct DecisionTimes {
    p50: Option<f64>,
    p99: Option<f64>,
    max: Option<f64>,
}

impl Report {
    pub(super) fn new(scenario: &Scenario, ended: &Ended) -> Self {
        let Episode { truth, reach, score, path_cells, at_start, outcome, .. } = &ended.episode;
        let latencies = Latencies::new(outcome.decisions.clone());
        let (seconds, robots) = (outcome.ended.as_seconds(), scenario.robots().len());
        let is_simulated = outcome.network.sent > 0;
        let FindCounts { confirmed, dismissed, .. } = FindCounts::of(&decided(scenario, &ended.episode));
        let terrain = scenario.terrain();
        let out_of_reach: Vec<Cell> = terrain.searched_cells().filter(|&cell| !reach.covers(cell)).collect();
        let if_defined = |share: f64| (score.object_count() > 0).then_some(share);
        Self {
            scenario: scenario.name().to_owned(),
            seed: ended.seed,
            policy: scenario::policies(scenario),
            robots,
            objects: truth.objects().len(),
            objects_out_of_reach: truth.objects().iter().filter(|&&cell| !reach.covers(cell)).count(),
            found: score.true_positives,
            false_positives: score.false_positives,
            declared: declared(scenario, &ended.episode),
            confirmed,
            dismissed,
            no_go_cells: ended.episode.zones.cells(Zone::NoGo).count(),
            skipped_cells: ended.episode.zones.cells(Zone::Skip).count(),
            recall: if_defined(score.recall()),
            precision: if_defined(score.precision()),
            f1: if_defined(score.f1()),
            auc_f1: if_defined(outcome.f1.mean_until(scenario.budget_cells())),
            path_cells: path_cells.clone(),
            robots_at_base: scenario
                .mission()
                .return_reserve
                .map(|_| at_start.iter().filter(|&&is_back| is_back).count()),
            mission_time_s: seconds,
            expected_remaining: ended.episode.expected_remaining,
            cells_out_of_reach: out_of_reach.len(),
            expected_out_of_reach: expected_out_of_reach(&ended.episode, &out_of_reach),
            subject: ended.episode.subject.map(Subject::from),
            last_find_s: outcome.last_find.map(dragnet_scenario::time::MissionTime::as_seconds),
            tail_s: outcome.tail().as_secs_f64(),
            decisions: latencies.count(),
            decision_ms: DecisionTimes {
                p50: latencies.percentile_ms(50),
                p99: latencies.percentile_ms(99),
                max: latencies.percentile_ms(100),
            },
            observations_sent: outcome.observations,
            observations_merged: ended.observations_merged,
            messages_over: ended.medium,
            messages_sent: is_simulated.then_some(outcome.network.sent),
            traffic: is_simulated.then(|| traffic::by_kind(&outcome.traffic, seconds, robots)),
            messages_unsent: is_simulated.then_some(outcome.traffic.unsent),
            beliefs_equal: outcome.beliefs_equal,
            has_all_readings: !outcome.beliefs_equal || ended.episode.belief.digest() == outcome.digest,
            belief_digest: outcome.digest.to_string(),
            recording: ended.recording.as_ref().map(|path| path.display().to_string()),
        }
    }

    /// The map, the objects and the measures.
    pub(super) fn text(&self, scenario: &Scenario, episode: &Episode, watched: &Watched) -> String {
        let picture = Picture {
            terrain: scenario.terrain(),
            belief: &episode.belief,
            truth: &episode.truth,
            reach: &episode.reach,
            detection_threshold: scenario.mission().detection_threshold,
            tracks: &watched.tracks,
        };
        let map = picture.draw(terminal::columns());
        let objects = objects(scenario, episode, &watched.finds);
        let subject = subject(scenario, episode);
        format!("\n{map}\n{objects}\n{}", self.measures(scenario, &subject))
    }

    fn measures(&self, scenario: &Scenario, subject: &str) -> String {
        let Self { mission_time_s, tail_s, .. } = self;
        let merged = self.observations_merged.map_or_else(String::new, |merged| format!(", {merged} merged"));
        let beliefs = if self.beliefs_equal { "the same" } else { "NOT the same" };
        let recording = self.recording.as_ref().map_or_else(String::new, |recording| {
            format!("recording     {recording}: open it in Foxglove (https://foxglove.dev)\n")
        });
        let partial = if self.has_all_readings {
            ""
        } else {
            "NOT COMPLETE  this simulator was started during the search, or readings were lost on their way: what is \
             found, missed and measured here is by its own readings; the coordinator has the finds of the team\n"
        };
        let tail = match self.last_find_s {
            Some(_) => format!("{tail_s:.1} s of it after the last find"),
            None => "nothing was found".to_owned(),
        };
        let finds = FindCounts {
            declared: self.declared.len(),
            confirmed: self.confirmed,
            dismissed: self.dismissed,
        };
        let finds = if finds.has_verdicts() { format!("finds         {finds}\n") } else { String::new() };
        format!(
            "{finds}searched      {mission_time_s:.1} s, {tail}; {}\n\
             left          {}\n\
             {}{}\
             quality       {}\n\
             decisions     {}\n\
             observations  {} sent{merged}\n\
             messages      {}\n\
             beliefs       {beliefs} in all robots, digest {}\n\
             {partial}{recording}",
            self.distance(),
            self.left(scenario),
            self.by_order(),
            subject,
            self.quality(scenario),
            self.decisions(),
            self.observations_sent,
            self.messages(),
            self.belief_digest,
        )
    }

    /// Where the operator kept robots from searching, as a line.
    fn by_order(&self) -> String {
        let Self { no_go_cells, skipped_cells, .. } = self;
        if no_go_cells + skipped_cells == 0 {
            return String::new();
        }
        format!(
            "by order      {no_go_cells} cells no-go, {skipped_cells} skipped: what may be there counts as left\n"
        )
    }

    /// What may not have been found. A policy may end a search that is not complete, as one whose pattern is driven.
    fn left(&self, scenario: &Scenario) -> String {
        let expected = self.expected_remaining;
        let limit = scenario.mission().stop_when_expected_remaining;
        let unreachable = self.expected_out_of_reach;
        let cells = self.cells_out_of_reach;
        let limit = match limit {
            Some(limit) if expected > limit => format!("; the search is NOT complete, which is at {limit}"),
            Some(limit) if unreachable > limit => format!(
                "; the search of what is in reach is complete at {limit}, that of the area is NOT: {unreachable:.2} in {cells} \
                 cells out of reach"
            ),
            Some(limit) => format!("; the search is complete at {limit}"),
            None if unreachable >= 0.005 => format!("; {unreachable:.2} in {cells} cells out of reach"),
            None => String::new(),
        };
        format!("{expected:.2} more objects expected in reach{limit}")
    }

    /// What was found of what could be.
    fn quality(&self, scenario: &Scenario) -> String {
        let (Some(recall), Some(precision), Some(f1), Some(auc_f1)) =
            (self.recall, self.precision, self.f1, self.auc_f1)
        else {
            let why =
                if self.objects == 0 { "there is no object" } else { "no object is in reach of a robot" };
            return format!("undefined: {why}");
        };
        let budget_cells = scenario.budget_cells();
        format!(
            "recall {recall:.3}, precision {precision:.3}, F1 {f1:.3}; mean of F1 over {budget_cells:.0} cells {auc_f1:.3}"
        )
    }

    fn messages(&self) -> String {
        let medium = match self.messages_over {
            Medium::Memory => "in memory, as over Zenoh",
            Medium::Zenoh => "over Zenoh",
        };
        self.messages_sent.map_or_else(
            || medium.to_owned(),
            |sent| format!("{sent} sent (one for each receiver), {medium}"),
        )
    }

    fn distance(&self) -> String {
        let total: f64 = self.path_cells.iter().sum();
        let farthest = self.path_cells.iter().copied().fold(0.0, f64::max);
        let driven = match self.robots {
            1 => format!("{total:.0} cells driven"),
            robots => format!("{total:.0} cells driven by {robots} robots, {farthest:.0} by the farthest"),
        };
        self.robots_at_base
            .map_or(driven.clone(), |back| format!("{driven}; {back} of {} back at base", self.robots))
    }

    fn decisions(&self) -> String {
        let DecisionTimes { p50, p99, max } = self.decision_ms;
        match (p50, p99, max) {
            (Some(p50), Some(p99), Some(max)) => {
                format!(
                    "{}: half within {p50:.2} ms, 99 % within {p99:.2} ms, all within {max:.2} ms",
                    self.decisions
                )
            }
            // Robots of other processes decide there.
            _ => "none here".to_owned(),
        }
    }
}

/// The probability of each cell: in a search for subjects of known number by their posterior.
fn probability(scenario: &Scenario, episode: &Episode) -> impl Fn(Cell) -> f64 {
    let probabilities = match scenario.subjects() {
        Some(one) => one.posterior(&episode.belief).probabilities().to_vec(),
        None => episode.belief.probabilities(),
    };
    move |cell| probabilities[cell.index()]
}

fn declared(scenario: &Scenario, episode: &Episode) -> Vec<Declared> {
    let threshold = scenario.mission().detection_threshold;
    let probability = probability(scenario, episode);
    let is_found = |cell: &Cell| episode.belief.is_found(*cell, threshold);
    let places = scenario.places();
    let declare = |cell: Cell| {
        let Position { row, column } = scenario.terrain().grid().position(cell);
        let center = places.center(cell);
        Declared {
            row,
            column,
            latitude_degrees: center.map(|center| center.latitude_degrees),
            longitude_degrees: center.map(|center| center.longitude_degrees),
            probability: probability(cell),
            is_object: episode.truth.is_object(cell),
        }
    };
    scenario.terrain().searched_cells().filter(is_found).map(declare).collect()
}

/// The finds with what the operator has decided.
fn decided(scenario: &Scenario, episode: &Episode) -> Vec<finds::Find> {
    let threshold = scenario.mission().detection_threshold;
    let is_found = |cell: &Cell| episode.belief.is_found(*cell, threshold);
    let object = |cell| Detection { cell, probability: episode.belief.probability(cell), time_ns: 0 };
    let declared: Vec<Detection> = scenario.terrain().searched_cells().filter(is_found).map(object).collect();
    finds::finds(&declared, &episode.verdicts)
}

/// Objects expected in cells out of reach: of subjects by their posterior.
fn expected_out_of_reach(episode: &Episode, cells: &[Cell]) -> f64 {
    let by_cells = || cells.iter().map(|&cell| episode.belief.probability(cell)).sum::<f64>() + 0.0;
    episode.subject.map_or_else(by_cells, |standing| standing.out_of_reach)
}

/// Where the subjects are, and what their finds are, as lines.
fn subject(scenario: &Scenario, episode: &Episode) -> String {
    let Some(standing) = episode.subject else { return String::new() };
    let (places, probability) = (scenario.places(), probability(scenario, episode));
    let find = |find: &finds::Find| {
        let words = of_subject(&places.on_earth(find.cell), probability(find.cell), find.operator);
        format!("declared      {words}\n")
    };
    let decided = decided(scenario, episode);
    let finds = decided.iter().filter(|find| find.is_declared).take(MAX_LISTED).map(find);
    format!("{:14}{standing}\n{}", standing.noun(), finds.collect::<String>())
}

/// The objects found at the end, when and by which robot, the missed ones, and the false finds.
fn objects(scenario: &Scenario, episode: &Episode, finds: &[Find]) -> String {
    let (belief, truth) = (&episode.belief, &episode.truth);
    let (places, detection_threshold) = (scenario.places(), scenario.mission().detection_threshold);
    let is_found = |cell: Cell| belief.is_found(cell, detection_threshold);
    let probability = probability(scenario, episode);
    let line = |cell: Cell| format!("{}, probability {:.4}", places.on_earth(cell), probability(cell));
    let (kept, withdrawn): (Vec<&Find>, Vec<&Find>) = finds.iter().partition(|find| is_found(find.cell));
    let withdrawn = withdrawn
        .into_iter()
        .map(|find| format!("{}, found after {:.1} s", line(find.cell), find.time.as_seconds()));
    let kept = kept.into_iter().filter(|find| truth.is_object(find.cell));
    let found = kept.map(|Find { cell, robot, time }| {
        format!("{}, robot {robot} after {:.1} s", line(*cell), time.as_seconds())
    });
    let objects = truth.objects().iter().copied();
    let (missed, out_of_reach): (Vec<Cell>, Vec<Cell>) =
        objects.filter(|&cell| !is_found(cell)).partition(|&cell| episode.reach.covers(cell));
    let searched = scenario.terrain().searched_cells();
    let wrong = searched.filter(|&cell| is_found(cell) && !truth.is_object(cell)).map(line);
    let truly = if scenario.subjects().is_some() { ", as the simulation knows" } else { "" };
    let title = format!(
        "found {} of {}{truly}\n",
        episode.score.true_positives,
        counted(truth.objects().len(), "object")
    );
    let (missed, out_of_reach) = (missed.into_iter().map(line), out_of_reach.into_iter().map(line));
    [
        title,
        listed(found),
        section("missed", missed),
        section("out of reach: no robot can see them from anywhere", out_of_reach),
        section("false positives", wrong),
        section("found and not declared any more: later readings spoke against them", withdrawn),
    ]
    .concat()
}

/// A titled list, or nothing if it is empty.
fn section(title: &str, lines_of: impl Iterator<Item = String>) -> String {
    let lines = listed(lines_of);
    if lines.is_empty() { lines } else { format!("{title}\n{lines}") }
}

/// A line for each entry, up to the maximum.
fn listed(lines_of: impl Iterator<Item = String>) -> String {
    let mut lines: Vec<String> = lines_of.map(|object| format!("  {object}\n")).collect();
    if lines.len() > MAX_LISTED {
        let rest = lines.split_off(MAX_LISTED);
        lines.push(format!("  and {} more\n", rest.len()));
    }
    lines.concat()
}
