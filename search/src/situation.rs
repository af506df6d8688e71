//! The inputs of a policy.

use crate::belief::Belief;
use crate::cell::{Cell, Grid};
use crate::intent::PlannedPrecision;
use crate::route::{Connectivity, ShortestPathTree};
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// The state of the search as one robot knows it at one decision.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The map.
    pub terrain: &'a Terrain,
    /// The moves that the robot can make.
    pub connectivity: Connectivity,
    /// The robot's sensor.
    pub sensor: &'a Sensor,
    /// The robot's belief.
    pub belief: &'a Belief,
    /// Precision that teammates plan to add.
    pub planned_precision: &'a PlannedPrecision,
    /// The robot's cell.
    pub robot: Cell,
    /// The robot's place in the team.
    pub place: Place,
    /// Probability from which a cell's object counts as found, above 0 and below 1.
    pub detection_threshold: f64,
    /// Path length that the robot may still drive by its budget, cells, at least 0; infinite without a budget.
    pub remaining_cells: f64,
    /// Shortest paths from the robot's base, if it is to be there when its budget ends: it enters only cells from which
    /// the budget leaves it the way back. Without one it may end anywhere.
    pub ways_home: Option<&'a ShortestPathTree>,
}

/// By how much a path may be longer than the budget, cells: less than any step, more than lengths are rounded by.
const ROUNDING_CELLS: f64 = 1e-3;

impl<'a> Situation<'a> {
    /// The situation of a robot without teammates in a cell, with moves to four neighbors, the default detection
    /// threshold and no budget.
    #[must_use]
    pub const fn alone(
        terrain: &'a Terrain,
        sensor: &'a Sensor,
        belief: &'a Belief,
        planned_precision: &'a PlannedPrecision,
        robot: Cell,
    ) -> Self {
        Self {
            terrain,
            connectivity: Connectivity::Four,
            sensor,
            belief,
            planned_precision,
            robot,
            place: Place::ALONE,
            detection_threshold: DEFAULT_DETECTION_THRESHOLD,
            remaining_cells: f64::INFINITY,
            ways_home: None,
        }
    }

    /// Shortest paths to the candidates of a decision: the cells in reach, from which the robot can still return to its
    /// base if it has one.
    #[must_use]
    pub fn routes(&self) -> ShortestPathTree {
        self.routes_within(f32::INFINITY)
    }

    /// The part of [`Situation::routes`] whose paths are at most `longest` cells long.
    ///
    /// With a cell it holds each cell of the path to it: by the triangle inequality the way home is never longer from
    /// a cell on a path than along the path and home from its end.
    #[must_use]
    pub fn routes_within(&self, longest: f32) -> ShortestPathTree {
        self.with_way_home(ShortestPathTree::within(self.terrain, self.connectivity, self.robot, longest))
    }

    /// Those of the shortest paths from the robot's cell after which the budget leaves the way home.
    #[must_use]
    pub fn with_way_home(&self, routes: ShortestPathTree) -> ShortestPathTree {
        match self.ways_home {
            None => routes,
            Some(_) => routes.only_to(|cell, length| self.leaves_way_home(cell, f64::from(length))),
        }
    }

    /// Whether the budget leaves the way home from a cell that is entered after a path of this length, cells.
    #[must_use]
    pub fn leaves_way_home(&self, cell: Cell, length_cells: f64) -> bool {
        let left = self.remaining_cells - length_cells;
        self.ways_home.is_none_or(|ways_home| is_way_home_within(ways_home, cell, left))
    }

    /// Number of cells at the beginning of a path, entered from the robot's cell, from all of which the budget leaves the
    /// way home.
    #[must_use]
    pub fn leading_cells_with_way_home(&self, path: &[Cell]) -> usize {
        let Self { terrain, robot, ways_home, remaining_cells, .. } = *self;
        leading_cells_with_way_home(terrain.grid(), robot, path, ways_home, remaining_cells)
    }
}

/// [`Situation::leading_cells_with_way_home`] without a situation.
#[must_use]
pub fn leading_cells_with_way_home(
    grid: Grid,
    robot: Cell,
    path: &[Cell],
    ways_home: Option<&ShortestPathTree>,
    remaining_cells: f64,
) -> usize {
    let Some(ways_home) = ways_home else { return path.len() };
    let (mut from, mut length_cells) = (robot, 0.0);
    let leaves_way_home = |&&cell: &&Cell| {
        length_cells += grid.offset(from, cell).euclidean();
        from = cell;
        is_way_home_within(ways_home, cell, remaining_cells - length_cells)
    };
    path.iter().take_while(leaves_way_home).count()
}

/// Whether the way home from a cell is no longer than this, cells.
#[must_use]
pub fn is_way_home_within(ways_home: &ShortestPathTree, cell: Cell, remaining_cells: f64) -> bool {
    f64::from(ways_home.length(cell)) <= remaining_cells + ROUNDING_CELLS
}

/// The usual [`Situation::detection_threshold`].
pub const DEFAULT_DETECTION_THRESHOLD: f64 = 0.95;

/// A robot's index in its team, and the team's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// `0..team`.
    pub member: u16,
    /// Robots in the team, at least 1.
    pub team: u16,
}

impl Place {
    /// A team of one robot.
    pub const ALONE: Self = Self { member: 0, team: 1 };
}
