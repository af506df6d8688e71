//! A tour over the whole rest of the search, kept and improved from decision to decision.
//!
//! `path` scores one path at a time and leaves pockets behind. A tour is a list of waypoints, joined by shortest paths,
//! that is to find all that is left on the shortest way ([`planner`] says what it costs). The first tour is the best of
//! several patterns of parallel lanes ([`lanes`]), improved by simulated annealing ([`anneal`]). Later decisions keep
//! the tour, less what has been driven, and improve it under the new belief; without that the robot dithers between
//! tours that are equally good.
//!
//! In a team each robot plans beside the tours of its teammates ([`team`]).
//!
//! Annealing is bounded by evaluations, never by time, and draws from the robot's own stream: decisions are a function
//! of the robot's history. A robot that restarts has no tour and plans anew. With sensors wider than the default there
//! are fewer evaluations, in proportion to the cells that they see.
//!
//! Where the budget ends before the tour, the tour is planned for the budget: what is observed by then counts. A robot
//! that is to be at its base by then plans to see the most on the way out and back.
//!
//! The robot drives the whole path of a decision unless it decides again before, as by default it does
//! ([`REPLAN_AFTER_CELLS`]). On a large map the tour covers the nearest cells only ([`ground`]). Where no tour is worth
//! driving, because nothing is left that it can confirm, the policy `path` decides.

mod anneal;
mod cost_to_go;
mod ground;
mod hidden;
mod lanes;
#[cfg(test)]
mod optimum;
mod planner;
mod scores;
mod team;
#[cfg(test)]
mod tests;

use std::num::NonZeroU32;

pub use cost_to_go::{CostToGo, TourCost};
pub use hidden::{Hidden, HiddenMass};
pub use scores::{SCORED_WITHIN_CELLS, TourScores};

use ground::Ground;
use hidden::HiddenTable;
use planner::{Leg, Planner};

use super::path_integral::Path;
use super::worth::{is_path_informative, without_plans};
use super::{Decision, Policy};
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::seed::Stream;
use crate::sensor::Sensor;
use crate::situation::Situation;
use crate::utility::Utility;

/// Number of cells after which a robot improves its tour, unless its scenario says otherwise.
pub(super) const REPLAN_AFTER_CELLS: NonZeroU32 = NonZeroU32::new(4).unwrap();
/// Evaluations of a first tour, times those of later ones; and those of a team, whose tours are shorter and have been
/// improved together.
const FIRST_FACTOR: u32 = 10;
const TEAM_FACTOR: u32 = 2;
/// Cells that a sensor of the default radius sees.
const DEFAULT_FOOTPRINT: u64 = {
    let radius = Sensor::DEFAULT_RADIUS as u64;
    2 * radius * (radius + 1) + 1
};
/// The temperature that a first tour is annealed from, and later ones, cells.
const HOT: f64 = 1.0;
const WARM: f64 = 0.3;

pub(super) struct Tour {
    evaluations: u32,
    table: Option<HiddenTable>,
    ground: Option<Ground>,
    plan: Plan,
    /// Whether the budget has ended before a tour: it will not last for the rest either.
    is_cut: bool,
    path: Path,
}

/// The tour of the last decision.
#[derive(Default)]
struct Plan {
    /// Where it starts.
    root: Option<Cell>,
    /// The cells on it.
    cells: Vec<Cell>,
    /// The bend of each leg, and how many cells have been entered at its end.
    legs: Vec<(u8, usize)>,
}

/// What a decision anneals.
struct Start {
    tour: Vec<Leg>,
    /// What teammates observe meanwhile.
    by_teammates: Vec<planner::PlannedObservation>,
    evaluations: u32,
    temperature: f64,
}

impl Tour {
    pub(super) fn new(evaluations: u32, path_length_weight: f64) -> Self {
        Self {
            evaluations,
            table: None,
            ground: None,
            plan: Plan::default(),
            is_cut: false,
            path: Path::new(path_length_weight, Utility::Information),
        }
    }

    /// The decision to drive a tour, if one is worth it.
    fn tour(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Option<Decision> {
        let table = HiddenTable::kept_for(&mut self.table, situation.detection_threshold);
        let (ground, is_new) = Ground::kept_for(&mut self.ground, situation);
        let planner = Planner::new(ground, table, situation, ground.number(situation.robot)?);
        let evaluations = affordable(self.evaluations, situation.sensor);
        let rest = self.plan.rest(&planner);
        let start = match (is_new && rest.is_empty(), situation.place.team > 1) {
            (false, _) => Start {
                tour: rest,
                by_teammates: team::planned(ground, situation),
                evaluations,
                temperature: WARM,
            },
            (true, false) => Start {
                tour: best_lanes(&planner),
                by_teammates: team::planned(ground, situation),
                evaluations: evaluations.saturating_mul(FIRST_FACTOR),
                temperature: HOT,
            },
            (true, true) => {
                let (tour, by_teammates) = team::first_tour(&planner, situation, evaluations, random);
                let evaluations = evaluations.saturating_mul(TEAM_FACTOR);
                Start { tour, by_teammates, evaluations, temperature: HOT }
            }
        };
        let (tour, saved_cells) = anneal_within(&planner, start, &mut self.is_cut, situation, random);
        self.plan = Plan::new(&planner, &tour);
        // Messages hold no longer path than the map has cells; a tour may enter cells again.
        let cell_count = situation.terrain.grid().cell_count();
        let most_cells = most_cells(situation.remaining_cells).min(cell_count);
        let mut path: Vec<Cell> = self.plan.cells.iter().copied().take(most_cells).collect();
        path.truncate(situation.leading_cells_with_way_home(&path));
        // The planner has counted what teammates plan to observe, from when they observe it.
        let is_informative = if situation.planned_precision.plans().is_empty() {
            is_path_informative(situation, &path)
        } else {
            let nothing = PlannedPrecision::nothing(situation.terrain);
            is_path_informative(&without_plans(situation, &nothing), &path)
        };
        let chosen = *path.last().filter(|_| is_informative)?;
        let mut scores = vec![f64::NEG_INFINITY; cell_count];
        scores[chosen.index()] = saved_cells;
        Some(Decision { chosen, path, scores })
    }
}

impl Policy for Tour {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        self.tour(situation, random).unwrap_or_else(|| self.path.decide(situation, random))
    }

    fn choose(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        self.tour(situation, random).unwrap_or_else(|| self.path.choose(situation, random))
    }
}

impl Plan {
    fn new(planner: &Planner<'_>, tour: &[Leg]) -> Self {
        let (cells, ends) = planner.cells(tour);
        Self {
            root: Some(planner.ground.cell(planner.root.at)),
            cells: cells.into_iter().map(|number| planner.ground.cell(number)).collect(),
            legs: tour.iter().map(|leg| leg.bend).zip(ends).collect(),
        }
    }

    /// Cells that have been driven of the plan when the robot is here. A tour may enter a cell several times: of the
    /// possible numbers it is the greatest up to that at which robots decide anew, or the least above. A robot that is
    /// where the plan starts is there again, if the plan comes back: otherwise it would start it over and over.
    fn driven(&self, robot: Cell) -> usize {
        let mut entered = (1..).zip(&self.cells).filter(|(_, cell)| **cell == robot).map(|(count, _)| count);
        let early = entered.clone().take_while(|&count| count <= REPLAN_AFTER_CELLS.get() as usize).last();
        early.or_else(|| entered.next().filter(|_| self.root != Some(robot))).unwrap_or(0)
    }

    /// The legs that have not been driven to their end when the robot is where the planner starts.
    fn rest(&self, planner: &Planner<'_>) -> Vec<Leg> {
        self.legs_after(self.driven(planner.ground.cell(planner.root.at)), planner)
    }

    /// All legs, from where the planner starts.
    fn whole(&self, planner: &Planner<'_>) -> Vec<Leg> {
        self.legs_after(0, planner)
    }

    fn legs_after(&self, driven: usize, planner: &Planner<'_>) -> Vec<Leg> {
        let ground = planner.ground;
        let ahead = self.legs.iter().filter(|&&(_, end)| end > driven);
        ahead
            .filter_map(|&(bend, end)| {
                let to = ground.waypoint(ground.number(self.cells[end - 1])?);
                Some(Leg { to, bend })
            })
            .collect()
    }
}

/// Improves a tour; returns it and what it saves of the cost of no tour, cells. A tour that the budget cuts is improved
/// again for the time that there is, and so are all later ones: it is the better tour for that, and ends with the budget.
fn anneal_within(
    planner: &Planner<'_>,
    start: Start,
    is_cut: &mut bool,
    situation: &Situation<'_>,
    random: &mut Stream,
) -> (Vec<Leg>, f64) {
    let Start { mut tour, by_teammates, evaluations, temperature } = start;
    let horizon = horizon(situation.remaining_cells);
    if !*is_cut {
        let planner = planner.beside(planner.root.at, by_teammates.clone());
        let (annealed, cost) = anneal::anneal(&planner, tour, evaluations, temperature, random);
        if planner.length(&annealed) <= horizon {
            let saved_cells = planner.cost(&[]) - cost;
            return (annealed, saved_cells);
        }
        (*is_cut, tour) = (true, annealed);
    }
    let planner = planner.beside(planner.root.at, by_teammates).ending_at(horizon);
    let (mut tour, cost) = anneal::anneal(&planner, tour, evaluations, temperature, random);
    tour.truncate(planner.within(&tour, horizon));
    let saved_cells = planner.cost(&[]) - cost;
    (tour, saved_cells)
}

/// Cells that a robot enters at most before a path length (cells) is driven.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
fn most_cells(remaining_cells: f64) -> usize {
    remaining_cells.ceil().clamp(1.0, f64::from(u32::MAX)) as usize
}

/// Fifths of a cell that a path length (cells) lasts for.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
fn horizon(remaining_cells: f64) -> u32 {
    (remaining_cells * f64::from(ground::PER_CELL)).clamp(0.0, f64::from(u32::MAX)) as u32
}

/// Evaluations that take about as long as these do with a sensor of the default radius: an evaluation takes as long as
/// the sensor sees cells.
fn affordable(evaluations: u32, sensor: &Sensor) -> u32 {
    let seen = u64::try_from(sensor.footprint().len()).unwrap_or(u64::MAX);
    let affordable = u64::from(evaluations) * DEFAULT_FOOTPRINT / seen.max(DEFAULT_FOOTPRINT);
    u32::try_from(affordable).unwrap_or(u32::MAX)
}

fn best_lanes(planner: &Planner<'_>) -> Vec<Leg> {
    let tours = lanes::lanes(planner).into_iter();
    let by_cost = tours.map(|tour| (planner.cost(&tour), tour));
    by_cost.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tour)| tour).unwrap_or_default()
}
