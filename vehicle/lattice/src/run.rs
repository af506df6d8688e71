//! One planning run: its searches, and their solutions.

use dragnet_search::cell::Position;

use super::ara::{Best, Search, Until};
use super::costmap::CostMap;
use super::guidance::{FreeGround, Guidance, OUT_OF_REACH};
use super::guide::Guide;
use super::heuristic::Heuristic;
use super::plan::{Effort, Plan, PlanError, Progress, Solution, Step};
use super::primitives::PrimitiveSet;
use super::stopped::Stopped;
use crate::plane::Pose;

/// Inflation below which the next search is the last one: stopping so near to 1 gains nothing.
const LAST_INFLATION: f64 = 1.002;

/// Inflations with a guide: it overestimates slightly, so that little inflation finds good paths already.
const GUIDED_INFLATIONS: [f64; 2] = [1.1, 1.0];
/// Maximum number of expansions with each of them: some tens of milliseconds.
const GUIDED_EXPANSIONS: u64 = 1 << 15;

/// The center of a state's cell, and its heading.
pub(super) fn pose(map: &CostMap, set: &PrimitiveSet, at: Position, heading: u8) -> Pose {
    let center = map.grid().cell(at).map_or((0.0, 0.0), |cell| map.center_meters(cell));
    let heading_radians = set.headings_radians()[usize::from(heading)];
    Pose { x_meters: center.0, y_meters: center.1, heading_radians }
}

/// A planning run.
pub(super) struct Run<'a, 'b> {
    pub(super) search: Search<'a>,
    pub(super) solutions: Vec<Solution>,
    /// The best bound proven.
    pub(super) bound: f64,
    pub(super) go_on: &'b mut dyn FnMut(&Progress) -> bool,
}

impl Run<'_, '_> {
    pub(super) fn ask(&mut self) -> bool {
        let solution = self.solutions.last().copied();
        (self.go_on)(&Progress { expansions: self.search.expansions, solution })
    }

    fn search(&mut self, guidance: &impl Guidance, until: Until) -> Result<(), Stopped> {
        let solution = self.solutions.last().copied();
        self.search
            .improve(guidance, until, &mut |expansions| (self.go_on)(&Progress { expansions, solution }))
    }

    /// First paths, by a guide: one soon, then better ones as long as they come fast.
    pub(super) fn follow(
        &mut self,
        guide: &Guide,
        free_ground: &FreeGround,
        from: Position,
        inflation: f64,
    ) -> Result<Result<(), Stopped>, PlanError> {
        if guide.at(from) == OUT_OF_REACH {
            return Err(self.none());
        }
        self.search.reopen(guide, inflation);
        if self.search(guide, Until::First) == Err(Stopped) {
            return Err(PlanError::Stopped { expansions: self.search.expansions });
        }
        if self.search.best.is_none() {
            return Err(self.none());
        }
        let mut ended = self.solved(free_ground, None);
        for inflation in GUIDED_INFLATIONS {
            if ended.is_ok() && inflation < self.bound {
                self.search.reopen(guide, inflation);
                let until = Until::Expanded(self.search.expansions + GUIDED_EXPANSIONS);
                let stopped = self.search(guide, until);
                ended = self.solved(free_ground, None).and(stopped);
            }
        }
        Ok(ended)
    }

    /// ARA*: searches with decreasing inflation.
    pub(super) fn improve(
        &mut self,
        heuristic: &Heuristic,
        from: Position,
        effort: Effort,
    ) -> Result<(), PlanError> {
        if self.search.best.is_none() && heuristic.at(from) == OUT_OF_REACH {
            return Err(self.none());
        }
        let mut inflation = effort.first_inflation;
        // The heuristic gives a better bound than that of the guided path.
        self.search.raise_lower_bound(heuristic);
        self.bound = self.bound.min(self.search.bound());
        if self.search.best.is_some() {
            inflation = self.next_inflation(effort.first_inflation);
        }
        while self.bound > 1.0 {
            self.search.reopen(heuristic, inflation);
            let stopped = self.search(heuristic, Until::Proven);
            if self.search.best.is_none() {
                let expansions = self.search.expansions;
                return Err(if stopped.is_err() { PlanError::Stopped { expansions } } else { self.none() });
            }
            if stopped.is_ok() {
                self.bound = self.bound.min(inflation);
            }
            if self.solved(heuristic, Some(inflation)).is_err() || stopped.is_err() {
                break;
            }
            inflation = self.next_inflation(inflation - effort.inflation_step);
        }
        Ok(())
    }

    /// At most `most`; in 1024ths, so that the search's inflation is exactly the reported one.
    fn next_inflation(&self, most: f64) -> f64 {
        let next = most.min(1.0 + (self.bound - 1.0) / 2.0);
        if next < LAST_INFLATION { 1.0 } else { (next * 1024.0).ceil() / 1024.0 }
    }

    /// Records the best path and its bound, and asks whether to go on.
    pub(super) fn solved<G: Guidance>(
        &mut self,
        lower_bound: &G,
        inflation: Option<f64>,
    ) -> Result<(), Stopped> {
        if let Some(best) = self.search.best {
            // Cheaper paths to states on the path may have been found since.
            let cost = u32::try_from(self.path(best).1).unwrap_or(best.cost).min(best.cost);
            self.search.best = Some(Best { cost, ..best });
            self.search.raise_lower_bound(lower_bound);
            self.note(cost, inflation);
        }
        if self.ask() { Ok(()) } else { Err(Stopped) }
    }

    /// Primitives of the best path with their costs, and their sum.
    fn path(&self, best: Best) -> (Vec<(u16, u64)>, u64) {
        let mut steps = Vec::new();
        let (mut state, mut cost) = (best.state, 0);
        while self.search.space.states.record(state).cost > 0 {
            let primitive = self.search.space.states.record(state).primitive;
            let (before, step) = self.search.before(state);
            steps.push((primitive, step));
            cost += step;
            state = before;
        }
        steps.reverse();
        (steps, cost)
    }

    const fn none(&self) -> PlanError {
        if self.search.too_costly {
            PlanError::TooCostly
        } else {
            PlanError::NoWay { expansions: self.search.expansions }
        }
    }

    /// Stopped while the heuristic was computed: this is a lower bound of the start's distance to the goal.
    pub(super) fn stopped(&mut self, at_least: u32) -> Result<(), PlanError> {
        let Some(best) = self.search.best else {
            return Err(PlanError::Stopped { expansions: self.search.expansions });
        };
        self.search.lower_bound = self.search.lower_bound.max(u64::from(at_least.min(best.cost)));
        self.note(best.cost, None);
        Ok(())
    }

    fn note(&mut self, cost: u32, inflation: Option<f64>) {
        self.bound = self.bound.min(self.search.bound());
        let expansions = self.search.expansions;
        self.solutions.push(Solution { inflation, cost, bound: self.bound, expansions });
    }

    pub(super) fn plan(&self, set: &PrimitiveSet, from: Position, heading: u8) -> Plan {
        let map = self.search.map;
        let (path, cost) = self.search.best.map(|best| self.path(best)).unwrap_or_default();
        let mut poses = vec![pose(map, set, from, heading)];
        let mut steps = Vec::with_capacity(path.len());
        let mut at = from;
        for (index, step_cost) in path {
            let primitive = &set.primitives()[usize::from(index)];
            let begin = poses.len() - 1;
            let corner = pose(map, set, at, 0);
            poses.extend(primitive.poses[1..].iter().map(|relative| Pose {
                x_meters: corner.x_meters + relative.x_meters,
                y_meters: corner.y_meters + relative.y_meters,
                heading_radians: relative.heading_radians,
            }));
            steps.push(Step { primitive: usize::from(index), cost: step_cost, poses: begin..poses.len() });
            at.row = at.row.wrapping_add_signed(primitive.north_cells);
            at.column = at.column.wrapping_add_signed(primitive.east_cells);
        }
        let leg =
            |pair: &[Pose]| (pair[1].x_meters - pair[0].x_meters).hypot(pair[1].y_meters - pair[0].y_meters);
        let length_meters = poses.windows(2).map(leg).sum();
        let solutions = self.solutions.clone();
        Plan {
            poses,
            steps,
            cost,
            length_meters,
            bound: self.bound,
            solutions,
            expansions: self.search.expansions,
        }
    }
}
