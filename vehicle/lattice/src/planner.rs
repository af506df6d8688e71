//! Planning from a vehicle's pose to a goal.
//!
//! On a large map a coarse `guide` leads to first paths; the cost of the best then limits where the `heuristic` is
//! needed. From there on, and on small maps from the start, it is ARA* (`ara`; Likhachev, Gordon and Thrun 2003).
//!
//! After the map or the start has changed, planning starts again. The planner keeps the motions with the ground that
//! they sweep, the bits of rows that have not changed, all memory and, for the same goal on the same map, the guide's
//! distances and those of a small map's heuristic.

use dragnet_search::cell::{Cell, Position};

use super::ara::{Search, Space};
use super::costmap::{CostMap, CostMapError};
use super::footprint::Footprint;
use super::goal::GoalStates;
use super::guidance::FreeGround;
use super::guide::Guide;
use super::heuristic::{Heuristic, Limit};
use super::layers::Layers;
use super::motions::Motions;
use super::plan::{Effort, Goal, Plan, PlanError, PlannerError, Progress, Solution, check_numbers};
use super::primitives::PrimitiveSet;
use super::run::{Run, pose};
use super::stopped::Stopped;
use crate::plane::Pose;

/// Number of cells from which on a guide is worth it: below, the whole heuristic is computed in a few milliseconds.
const GUIDED_CELLS: usize = 1 << 18;

/// A vehicle on a map.
#[derive(Clone, Debug)]
pub struct Planner {
    set: PrimitiveSet,
    motions: Motions,
    map: CostMap,
    layers: Layers,
    guided_cells: usize,
    guide: Option<Guide>,
    /// The goal cells that the guide's distances are for.
    guide_goals: Vec<Position>,
    heuristic: Heuristic,
    /// The goal cells that the heuristic is for, if it is computed for the whole map.
    heuristic_goals: Vec<Position>,
    space: Space,
}

impl Planner {
    /// A planner for this vehicle on this map.
    ///
    /// # Errors
    /// If the footprint is invalid, or primitives and map differ in resolution.
    pub fn new(set: PrimitiveSet, footprint: &Footprint, map: CostMap) -> Result<Self, PlannerError> {
        footprint.check(set.resolution_meters())?;
        check_resolution(&set, &map)?;
        let motions = Motions::new(&set, footprint);
        let layers = Layers::new(&map, &motions);
        let mut planner = Self {
            set,
            motions,
            map,
            layers,
            guided_cells: GUIDED_CELLS,
            guide: None,
            guide_goals: Vec::new(),
            heuristic: Heuristic::default(),
            heuristic_goals: Vec::new(),
            space: Space::new(),
        };
        planner.make_guide();
        Ok(planner)
    }

    /// The map.
    #[must_use]
    pub const fn map(&self) -> &CostMap {
        &self.map
    }

    /// The primitives.
    #[must_use]
    pub const fn primitives(&self) -> &PrimitiveSet {
        &self.set
    }

    /// Memory that the planner holds, bytes: it grows with the visited states, and is kept.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        self.motions.bytes()
            + self.map.costs().len()
            + self.layers.bytes()
            + self.guide.as_ref().map_or(0, Guide::bytes)
            + self.heuristic.bytes()
            + self.space.bytes()
    }

    /// Sets costs of cells. Work grows with the rows between the first and the last of them, and the reach of motions.
    ///
    /// # Errors
    /// If a cell is not on the map. No cost is changed in that case. For a map of another size use
    /// [`Planner::replace_map`].
    pub fn set_costs(&mut self, costs: &[(Cell, u8)]) -> Result<(), PlannerError> {
        let cells = self.map.grid().cell_count();
        if let Some((cell, _)) = costs.iter().find(|(cell, _)| cell.index() >= cells) {
            return Err(CostMapError::Cell { number: cell.number(), cells }.into());
        }
        let row = |cell: Cell| self.map.grid().position(cell).row as usize;
        let rows = costs.iter().map(|&(cell, _)| row(cell));
        let (Some(first), Some(last)) = (rows.clone().min(), rows.max()) else { return Ok(()) };
        for &(cell, cost) in costs {
            self.map.set(cell, cost)?;
        }
        self.layers.refresh(&self.map, &self.motions, first..last + 1);
        if let Some(guide) = &mut self.guide {
            let frame = self.motions.reach_cells();
            let touched = first.saturating_sub(frame)..(last + 1 + frame).min(self.layers.rows());
            guide.refresh(&self.map, &self.layers, touched);
        }
        self.guide_goals.clear();
        self.heuristic_goals.clear();
        Ok(())
    }

    /// Replaces the map; the new one may have any size.
    ///
    /// # Errors
    /// If its resolution is not that of the primitives.
    pub fn replace_map(&mut self, map: CostMap) -> Result<(), PlannerError> {
        check_resolution(&self.set, &map)?;
        self.layers = Layers::new(&map, &self.motions);
        self.map = map;
        self.make_guide();
        Ok(())
    }

    /// Uses a guide from this number of cells on.
    #[cfg(test)]
    pub(super) fn guide_from(&mut self, cells: usize) {
        self.guided_cells = cells;
        self.make_guide();
    }

    fn make_guide(&mut self) {
        let is_large = self.map.grid().cell_count() >= self.guided_cells;
        self.guide = is_large.then(|| Guide::new(&self.map, &self.layers));
        self.guide_goals.clear();
        self.heuristic_goals.clear();
    }

    /// The cheapest path from a pose to a goal, or the best one found in time. `go_on` is called about every
    /// millisecond of work and returns whether to continue, on large maps with some tens of milliseconds between one
    /// search and the next; its argument is the progress.
    ///
    /// The start is rounded to the center of its cell and the nearest heading of the lattice.
    ///
    /// # Errors
    /// If the start or the goal is off the map or blocked, or no path exists; or if `go_on` returned false before there
    /// was a first path.
    pub fn plan(
        &mut self,
        start: Pose,
        goal: &Goal,
        effort: Effort,
        go_on: &mut dyn FnMut(&Progress) -> bool,
    ) -> Result<Plan, PlanError> {
        check_numbers(start, goal, effort)?;
        let (from, heading) = self.start_state(start)?;
        let (goals, cells) = self.goal_states(goal)?;
        if goals.contains(from, heading) {
            return Ok(self.standing(from, heading));
        }
        self.aim_guide(&cells);
        let Self { map, layers, motions, guide, heuristic, heuristic_goals, space, set, .. } = self;
        let mut search = Search::new(map, layers, motions, &goals, space);
        search.begin(from, heading);
        let mut run = Run { search, solutions: Vec::new(), bound: f64::INFINITY, go_on };
        let metric = motions.metric();
        let mut limit = None;
        if let Some(guide) = guide {
            let tolerance = goals.tolerance_units(&cells, metric);
            let free_ground = FreeGround { metric, goal: goals.cell(), tolerance };
            if run.follow(guide, &free_ground, from, effort.first_inflation)? == Err(Stopped) {
                return Ok(run.plan(set, from, heading));
            }
            limit = run.search.best.map(|best| Limit { start: from, cost: best.cost });
        }
        if limit.is_some() || *heuristic_goals != cells {
            heuristic_goals.clear();
            if heuristic.compute(map, layers, motions, &cells, limit, &mut || run.ask()) == Err(Stopped) {
                return run.stopped(heuristic.at_least(from)).map(|()| run.plan(set, from, heading));
            }
            if limit.is_none() {
                heuristic_goals.clone_from(&cells);
            }
        }
        run.improve(heuristic, from, effort)?;
        Ok(run.plan(set, from, heading))
    }

    /// Whether the vehicle has room at a goal, wherever it comes from.
    ///
    /// # Errors
    /// [`PlanError::GoalOutside`] and [`PlanError::GoalBlocked`].
    pub fn check_goal(&self, goal: &Goal) -> Result<(), PlanError> {
        self.goal_states(goal).map(|_| ())
    }

    fn start_state(&self, start: Pose) -> Result<(Position, u8), PlanError> {
        let Pose { x_meters: x, y_meters: y, heading_radians } = start;
        let cell = self.map.cell_at(x, y).ok_or(PlanError::StartOutside(x, y))?;
        let at = self.map.grid().position(cell);
        let heading = self.set.nearest_heading(heading_radians);
        if !self.layers.is_free(at, self.motions.standing(heading)) {
            return Err(PlanError::StartBlocked(x, y));
        }
        Ok((at, u8::try_from(heading).unwrap_or(u8::MAX)))
    }

    /// The goal, and its cells that are not blocked.
    fn goal_states(&self, goal: &Goal) -> Result<(GoalStates, Vec<Position>), PlanError> {
        let (x, y) = (goal.x_meters, goal.y_meters);
        let cell = self.map.cell_at(x, y).ok_or(PlanError::GoalOutside(x, y))?;
        let nearest = |radians| u8::try_from(self.set.nearest_heading(radians)).unwrap_or(u8::MAX);
        let heading = goal.heading_radians.map(nearest);
        let goals = GoalStates::new(&self.map, cell, (x, y), goal.tolerance_meters, heading);
        let cells = goals.open_cells(self.map.grid(), &self.layers);
        if !goals.has_room(&cells, &self.layers, &self.motions) {
            return Err(PlanError::GoalBlocked(x, y));
        }
        Ok((goals, cells))
    }

    fn aim_guide(&mut self, cells: &[Position]) {
        if let Some(guide) = &mut self.guide
            && self.guide_goals != cells
        {
            guide.compute(cells);
            cells.clone_into(&mut self.guide_goals);
        }
    }

    fn standing(&self, at: Position, heading: u8) -> Plan {
        Plan {
            poses: vec![pose(&self.map, &self.set, at, heading)],
            steps: Vec::new(),
            cost: 0,
            length_meters: 0.0,
            bound: 1.0,
            solutions: vec![Solution { inflation: Some(1.0), cost: 0, bound: 1.0, expansions: 0 }],
            expansions: 0,
        }
    }
}

fn check_resolution(set: &PrimitiveSet, map: &CostMap) -> Result<(), PlannerError> {
    let (primitives_meters, map_meters) = (set.resolution_meters(), map.resolution_meters());
    // Numbers in files are rounded.
    let is_same = (primitives_meters - map_meters).abs() <= 1e-6 * map_meters;
    if is_same { Ok(()) } else { Err(PlannerError::Resolution { primitives_meters, map_meters }) }
}
