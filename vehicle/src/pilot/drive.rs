//! Driving along a straight run.
//!
//! A lattice plan is the cheapest path, and ground beside the run's cells costs several times as much: so the vehicle
//! enters the cells that the agent expects, and leaves them where an obstacle is in the way.

use std::collections::BTreeSet;

use dragnet_search::cell::{Cell, Position};
use dragnet_search::terrain::Terrain;

use super::{Action, PilotError};
use crate::settings::{Motion, Source};
use dragnet_lattice::costmap::{CostMap, LETHAL};
use dragnet_lattice::footprint::Footprint;
use dragnet_lattice::plan::{self, Effort, Plan, PlanError};
use dragnet_lattice::plane::Pose;
use dragnet_lattice::planner::Planner;

/// Distances from the center of its goal's cell at which a plan may end, in edges of a cell: at first 0; with an
/// obstacle there, beside it.
const TOLERANCES: [f64; 3] = [0.0, 0.2, WIDEST];
/// The largest: a cell in which the vehicle has no room so near to the center is too narrow.
const WIDEST: f64 = 0.45;
/// Cost factor of ground beside the run.
const BESIDE: u8 = 4;
/// The cost of the dearest ground that can be driven on.
const DEAREST: u8 = LETHAL - 1;
/// A plan that fails after so few expansions has not left the start.
const BOXED_IN_EXPANSIONS: u64 = 500;

/// The state of the vehicle's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leg {
    /// Nothing yet.
    Idle,
    /// It drives to a cell.
    Driving { target: Cell },
    /// It stands until a fault is over, or a new route comes.
    Holding,
    /// It stands because no path leads on.
    GivenUp,
}

impl Leg {
    pub(super) const fn is_still(self) -> bool {
        matches!(self, Self::Holding | Self::GivenUp)
    }
}

/// The end of a run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Goal {
    /// The direction into its last cell, radians.
    pub(super) heading_radians: f64,
    /// Its cells; it ends in the center of the last.
    pub(super) corridor: Corridor,
}

/// Cells, as of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Corridor {
    /// Meters east and north; of a run at least one.
    pub(super) middles: Vec<(f64, f64)>,
    /// Their edge, meters.
    pub(super) cell_meters: f64,
}

impl Goal {
    fn pose(&self) -> Pose {
        let (x_meters, y_meters) = self.corridor.middles.last().copied().unwrap_or_default();
        Pose { x_meters, y_meters, heading_radians: self.heading_radians }
    }
}

/// The planner of paths.
#[derive(Clone, Debug)]
pub(super) enum Driver {
    Lattice(Box<Lattice>),
    /// A navigation stack of the vehicle's own, and the last goal that was sent to it.
    Goal(Option<Pose>),
}

#[derive(Clone, Debug)]
pub(super) struct Lattice {
    source: Source,
    footprint: Footprint,
    /// On a map on which all ground that is free costs [`BESIDE`] more, and closed ground the most.
    planner: Planner,
    /// What that ground costs by itself.
    map: CostMap,
    /// Ground that the operator has closed.
    closed: Corridor,
    max_expansions: u64,
    replan_beyond_meters: f64,
    /// The current path.
    path: Vec<Pose>,
}

impl Driver {
    pub(super) fn new(motion: &Motion, map: &CostMap) -> Result<Self, PilotError> {
        let Motion::Lattice { source, footprint, max_expansions, replan_beyond_meters } = motion else {
            return Ok(Self::Goal(None));
        };
        Ok(Self::Lattice(Box::new(Lattice {
            planner: planner(source, footprint, map, &Corridor::default())?,
            map: map.clone(),
            closed: Corridor::default(),
            source: source.clone(),
            footprint: footprint.clone(),
            max_expansions: *max_expansions,
            replan_beyond_meters: *replan_beyond_meters,
            path: Vec::new(),
        })))
    }

    /// A new map, of any size; generated motion primitives fit any resolution.
    pub(super) fn set_map(&mut self, map: &CostMap) -> Result<(), PilotError> {
        if let Self::Lattice(lattice) = self {
            lattice.planner = planner(&lattice.source, &lattice.footprint, map, &lattice.closed)?;
            lattice.map = map.clone();
        }
        Ok(())
    }

    /// Cells that the operator has closed, instead of those before. A navigation stack does not know of them.
    pub(super) fn close(&mut self, terrain: &Terrain, cells: &BTreeSet<Cell>) {
        let Self::Lattice(lattice) = self else { return };
        lattice.closed = Corridor {
            middles: cells.iter().map(|&cell| terrain.center_meters(cell)).collect(),
            cell_meters: terrain.cell_meters(),
        };
        let Lattice { source, footprint, map, closed, .. } = &**lattice;
        // It was made of the same parts before.
        if let Ok(planner) = planner(source, footprint, map, closed) {
            lattice.planner = planner;
        }
    }

    /// The path to the end of a run.
    pub(super) fn set_out(&mut self, from: &Pose, goal: &Goal) -> Result<Action, PlanError> {
        match self {
            Self::Goal(sent) => {
                *sent = Some(goal.pose());
                Ok(Action::Go(goal.pose()))
            }
            Self::Lattice(lattice) => lattice.set_out(from, goal),
        }
    }

    pub(super) fn stop(&mut self) {
        match self {
            Self::Lattice(lattice) => lattice.path.clear(),
            Self::Goal(sent) => *sent = None,
        }
    }

    /// Traversable cells in which the vehicle has no room, by its own map, in order. A navigation stack tells of none.
    pub(super) fn too_narrow(&self, terrain: &Terrain) -> Vec<Cell> {
        let Self::Lattice(lattice) = self else { return Vec::new() };
        let is_too_narrow = |&cell: &Cell| {
            let has_no_room = || lattice.has_no_room(terrain.center_meters(cell), terrain.cell_meters());
            terrain.is_traversable(cell) && has_no_room()
        };
        terrain.grid().cells().filter(is_too_narrow).collect()
    }

    /// Whether a pose is near the end of the current path; true without one.
    pub(super) fn is_near_end(&self, pose: &Pose, near_meters: f64) -> bool {
        let end = match self {
            Self::Lattice(lattice) => lattice.path.last(),
            Self::Goal(sent) => sent.as_ref(),
        };
        end.is_none_or(|end| (end.position_meters() - pose.position_meters()).norm() <= near_meters)
    }

    /// Whether the vehicle is too far from its path.
    pub(super) fn is_beside(&self, pose: &Pose) -> bool {
        let Self::Lattice(lattice) = self else { return false };
        let squared = |point: &Pose| (point.position_meters() - pose.position_meters()).norm_squared();
        let nearest = lattice.path.iter().map(squared).fold(f64::INFINITY, f64::min);
        nearest.sqrt() > lattice.replan_beyond_meters + lattice.planner.map().resolution_meters()
    }
}

impl Lattice {
    fn has_no_room(&self, (x_meters, y_meters): (f64, f64), cell_meters: f64) -> bool {
        let tolerance_meters = WIDEST * cell_meters;
        let goal = plan::Goal { x_meters, y_meters, heading_radians: None, tolerance_meters };
        matches!(self.planner.check_goal(&goal), Err(PlanError::GoalBlocked(..)))
    }

    fn set_out(&mut self, from: &Pose, goal: &Goal) -> Result<Action, PlanError> {
        let within = squares(self.planner.map(), &goal.corridor);
        self.reprice(&within, |cost| cost - BESIDE);
        let plan = self.plan(from, goal);
        self.reprice(&within, |cost| cost + BESIDE);
        let plan = plan?;
        self.path.clone_from(&plan.poses);
        Ok(Action::Drive(plan))
    }

    /// The cells come from the map itself, so the planner never rejects them.
    fn reprice(&mut self, squares: &[Cell], price: impl Fn(u8) -> u8) {
        let costs = self.planner.map().costs();
        let free = squares.iter().filter(|square| costs[square.index()] < LETHAL);
        let prices: Vec<(Cell, u8)> = free.map(|&square| (square, price(costs[square.index()]))).collect();
        let result = self.planner.set_costs(&prices);
        debug_assert!(result.is_ok());
    }

    fn plan(&mut self, from: &Pose, goal: &Goal) -> Result<Plan, PlanError> {
        let mut result = self.plan_from(from, goal);
        // The lattice represents the vehicle only in the center of a square, where a tree may be too near that the
        // vehicle has passed.
        for start in beside(from, self.planner.map().resolution_meters()) {
            let is_boxed_in = match &result {
                Err(PlanError::NoWay { expansions }) => *expansions <= BOXED_IN_EXPANSIONS,
                Err(error) => is_of_the_start(error),
                Ok(_) => false,
            };
            if !is_boxed_in {
                break;
            }
            result = self.plan_from(&start, goal).or(result);
        }
        result
    }

    fn plan_from(&mut self, from: &Pose, goal: &Goal) -> Result<Plan, PlanError> {
        let (most, Pose { x_meters, y_meters, .. }) = (self.max_expansions, goal.pose());
        let mut result = Err(PlanError::GoalBlocked(x_meters, y_meters));
        for share in TOLERANCES {
            let tolerance_meters = share * goal.corridor.cell_meters;
            let goal = plan::Goal { x_meters, y_meters, heading_radians: None, tolerance_meters };
            result = self
                .planner
                .plan(*from, &goal, Effort::default(), &mut |progress| progress.expansions < most);
            if !matches!(result, Err(PlanError::GoalBlocked(..) | PlanError::NoWay { .. })) {
                break;
            }
        }
        result
    }
}

/// Whether a plan failed where the vehicle is, wherever it was to go.
pub(super) const fn is_of_the_start(error: &PlanError) -> bool {
    matches!(error, PlanError::StartBlocked(..) | PlanError::StartOutside(..))
}

/// Squares of the lattice's map whose centers lie in a corridor, each once, by index.
fn squares(map: &CostMap, corridor: &Corridor) -> Vec<Cell> {
    let half_meters = corridor.cell_meters / 2.0;
    let mut squares = Vec::new();
    for &(x, y) in &corridor.middles {
        let corner = |sign: f64| {
            // The edge itself belongs to the next cell.
            let inside = half_meters - 1e-6 * corridor.cell_meters;
            map.cell_at(x + sign * inside, y + sign * inside).map(|cell| map.grid().position(cell))
        };
        let (Some(first), Some(last)) = (corner(-1.0), corner(1.0)) else { continue };
        for row in first.row..=last.row {
            squares.extend((first.column..=last.column).filter_map(|column| {
                let square = map.grid().cell(Position { row, column })?;
                let middle = map.center_meters(square);
                let is_in = (middle.0 - x).abs().max((middle.1 - y).abs()) <= half_meters;
                is_in.then_some(square)
            }));
        }
    }
    squares.sort_unstable();
    squares.dedup();
    squares
}

/// Poses one square or one heading away, the nearest first.
fn beside(pose: &Pose, resolution_meters: f64) -> Vec<Pose> {
    let turned = |radians: f64| Pose { heading_radians: pose.heading_radians + radians, ..*pose };
    let moved = |forward: f64, left: f64| {
        pose.of_part(&Pose::new(forward * resolution_meters, left * resolution_meters, 0.0))
    };
    vec![
        turned(0.4),
        turned(-0.4),
        moved(-1.0, 0.0),
        moved(1.0, 0.0),
        moved(0.0, 1.0),
        moved(0.0, -1.0),
        moved(-2.0, 0.0),
        moved(2.0, 0.0),
    ]
}

/// Closed ground is not lethal: a vehicle that stands there has to leave.
fn planner(
    source: &Source,
    footprint: &Footprint,
    map: &CostMap,
    closed: &Corridor,
) -> Result<Planner, PilotError> {
    let set = source.primitives(map.resolution_meters())?;
    let dearer = map
        .costs()
        .iter()
        .map(|&cost| if cost < LETHAL { cost.min(DEAREST - BESIDE) + BESIDE } else { cost });
    let mut costs: Vec<u8> = dearer.collect();
    for square in squares(map, closed) {
        costs[square.index()] = costs[square.index()].max(DEAREST);
    }
    let map = CostMap::new(map.grid(), map.resolution_meters(), map.origin_meters(), costs)
        .map_err(dragnet_lattice::plan::PlannerError::from)?;
    Ok(Planner::new(set, footprint, map)?)
}
