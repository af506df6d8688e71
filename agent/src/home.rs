//! The way back to a robot's base, for robots that are to end there.

use dragnet_scenario::{Robot, Start};
use dragnet_search::cell::Cell;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::situation::is_way_home_within;
use dragnet_search::terrain::Terrain;

/// The base of a robot that is in this cell, and was in another first, if that is known: where its scenario lets it start,
/// or else where it was first.
pub(crate) fn base(robot: &Robot, was_first_in: Option<Cell>, cell: Cell) -> Cell {
    match robot.start {
        Start::Cell(start) => start,
        Start::Together { .. } | Start::Scattered => was_first_in.unwrap_or(cell),
    }
}

/// Shortest paths between a base and all other cells.
#[derive(Clone, Debug)]
pub(crate) struct Home {
    ways: ShortestPathTree,
}

impl Home {
    /// The ways to a base.
    pub(crate) fn new(terrain: &Terrain, connectivity: Connectivity, base: Cell) -> Self {
        Self { ways: ShortestPathTree::from(terrain, connectivity, base) }
    }

    /// Whether a path leads there from a cell.
    pub(crate) fn is_in_reach(&self, from: Cell) -> bool {
        self.ways.length(from).is_finite()
    }

    /// The base.
    pub(crate) const fn base(&self) -> Cell {
        self.ways.root()
    }

    /// Shortest paths from the base. Moves can be reversed, so they are the ways home too.
    pub(crate) const fn ways(&self) -> &ShortestPathTree {
        &self.ways
    }

    /// Cells entered on the way home, the base last; empty in the base, and where none leads there.
    pub(crate) fn path_from(&self, cell: Cell) -> Vec<Cell> {
        let mut path = self.ways.path(cell);
        if path.pop().is_some() {
            path.reverse();
            path.push(self.base());
        }
        path
    }

    /// Whether a robot in this cell can reach a cell from which its budget, cells, would not leave the way home.
    pub(crate) fn is_any_too_far(
        &self,
        terrain: &Terrain,
        connectivity: Connectivity,
        cell: Cell,
        remaining_cells: f64,
    ) -> bool {
        let routes = ShortestPathTree::from(terrain, connectivity, cell);
        routes.candidates().iter().any(|&to| {
            let left = remaining_cells - f64::from(routes.length(to));
            !is_way_home_within(&self.ways, to, left)
        })
    }
}
