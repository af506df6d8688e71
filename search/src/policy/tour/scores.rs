//! `tour` as an expert to learn from: what the rest of the search costs if it starts with each of several cells.
//!
//! Of many tours that are equally good `tour` drives one; which it is cannot be learned. The cost of the best tour that
//! starts with a cell has one value. So each scored cell is driven to in imagination, and the tour from there on is
//! annealed. Cells are those that the robot can reach before it would decide anew, or little later.

use rand::RngExt;

use super::anneal::anneal;
use super::ground::Ground;
use super::hidden::HiddenTable;
use super::planner::{Leg, Planner};
use super::{HOT, Plan, Tour, WARM, affordable, best_lanes};
use crate::cell::Cell;
use crate::policy::{Decision, Parameters, Policy};
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::Situation;

/// Cells with a path of at least this length, cells, are not scored.
pub const SCORED_WITHIN_CELLS: f32 = 5.0;
/// Cells that are scored, at most: drawn from all of them, since each costs many evaluations.
const MOST_SCORED: usize = 20;
/// Share of the evaluations of a tour that each scored cell gets.
const SHARE: u32 = 3;

/// The expert. A score is what the best known tour that starts with a cell saves of the cost of no tour, cells;
/// `-inf` for cells that are not scored. The robot drives to the best one. Where no tour is worth driving, `tour`
/// decides, with its scores.
pub struct TourScores {
    tour: Tour,
    evaluations: u32,
}

impl TourScores {
    /// With the evaluations of these parameters.
    #[must_use]
    pub fn new(parameters: Parameters) -> Self {
        let evaluations = parameters.evaluations;
        Self { tour: Tour::new(evaluations, parameters.path_length_weight), evaluations }
    }

    fn scored(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Option<Decision> {
        let Tour { table, ground, plan, .. } = &mut self.tour;
        let table = HiddenTable::kept_for(table, situation.detection_threshold);
        let (ground, _) = Ground::kept_for(ground, situation);
        let planner = Planner::new(ground, table, situation, ground.number(situation.robot)?);
        let evaluations = affordable(self.evaluations, situation.sensor);
        // Where the robot did not follow the last tour, lanes may be better than its rest.
        let rest = plan.rest(&planner);
        let (kept, kept_cost) = anneal(&planner, rest, evaluations, WARM, random);
        let (fresh, fresh_cost) = anneal(&planner, best_lanes(&planner), evaluations, HOT, random);
        let (base, base_cost) = if kept_cost <= fresh_cost { (kept, kept_cost) } else { (fresh, fresh_cost) };
        let nothing_cost = planner.cost(&[]);
        if base_cost >= nothing_cost {
            return None;
        }
        let routes = situation.routes();
        let first_cells = planner.cells(&base).0;
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        let mut best: Option<(f64, Cell, Vec<Leg>)> = None;
        for cell in scored_cells(&routes, ground, &first_cells, random) {
            let path: Option<Vec<u16>> = routes.path(cell).into_iter().map(|it| ground.number(it)).collect();
            let Some(path) = path else { continue };
            let from_there = planner.after(&path);
            let backwards: Vec<Leg> = base.iter().rev().copied().collect();
            let start = [base.clone(), backwards]
                .into_iter()
                .min_by(|a, b| from_there.cost(a).total_cmp(&from_there.cost(b)))?;
            let (rest, cost) = anneal(&from_there, start, evaluations / SHARE, WARM, random);
            scores[cell.index()] = nothing_cost - cost;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                best = Some((cost, cell, rest));
            }
        }
        let (cost, chosen, rest) = best?;
        let path = routes.path(chosen);
        *plan = if cost < base_cost {
            Plan::new(&planner, &base_through(ground, chosen, rest)?)
        } else {
            Plan::new(&planner, &base)
        };
        Some(Decision { chosen, path, scores })
    }
}

impl Policy for TourScores {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        self.scored(situation, random).unwrap_or_else(|| self.tour.decide(situation, random))
    }
}

/// A tour by way of a cell.
fn base_through(ground: &Ground, first: Cell, rest: Vec<Leg>) -> Option<Vec<Leg>> {
    let to = ground.waypoint(ground.number(first)?);
    Some(std::iter::once(Leg { to, bend: 0 }).chain(rest).collect())
}

/// Some of the cells near the robot, among them the farthest on the tour.
fn scored_cells(routes: &ShortestPathTree, ground: &Ground, tour: &[u16], random: &mut Stream) -> Vec<Cell> {
    let candidates = routes.candidates();
    let mut near: Vec<Cell> =
        candidates.iter().copied().filter(|&cell| routes.length(cell) < SCORED_WITHIN_CELLS).collect();
    let on_tour = tour.iter().map(|&number| ground.cell(number));
    let last = on_tour.take_while(|cell| near.contains(cell)).last();
    for place in 0..near.len().min(MOST_SCORED) {
        let other = random.random_range(place..near.len());
        near.swap(place, other);
    }
    near.truncate(MOST_SCORED);
    if let Some(last) = last.filter(|cell| !near.contains(cell)) {
        near.push(last);
    }
    near
}
