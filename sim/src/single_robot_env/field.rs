//! The data that all searches of a scenario share: its map, and tables computed from it.

use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;
use dragnet_search::route::{Connectivity, ShortestPathTree};

/// Lengths of shortest paths are stored for all pairs of cells up to this number of pairs: 16 MiB.
const MOST_PAIRS: usize = 1 << 22;

/// A scenario, and the paths on its map.
#[derive(Clone, Debug)]
pub struct Field {
    scenario: Scenario,
    /// The cell that each step leads to, shape `[cells, steps]`.
    neighbors: Vec<Option<Cell>>,
    /// The connected area of a cell, named by the index of one of its cells; `None` for cells that are not traversable.
    /// Shape `[cells]`.
    area: Vec<Option<Cell>>,
    /// Lengths of shortest paths, cells, shape `[cells, cells]` by start and end; empty on large maps.
    distances: Vec<f32>,
}

impl Field {
    /// Computes the tables of a scenario.
    #[must_use]
    pub fn new(scenario: Scenario) -> Self {
        let (terrain, connectivity) = (scenario.terrain(), scenario.connectivity());
        let steps = |cell| {
            connectivity.offsets().iter().map(move |&offset| Connectivity::step(terrain, cell, offset))
        };
        let neighbors = terrain
            .grid()
            .cells()
            .flat_map(|cell| {
                let is_open = terrain.is_traversable(cell);
                steps(cell).map(move |to| to.filter(|_| is_open))
            })
            .collect();
        let count = terrain.grid().cell_count();
        let mut area = vec![None; count];
        for start in terrain.traversable_cells() {
            if area[start.index()].is_none() {
                for reached in ShortestPathTree::from(terrain, connectivity, start).reached() {
                    area[reached.index()] = Some(start);
                }
            }
        }
        let mut distances = Vec::new();
        if count.checked_mul(count).is_some_and(|pairs| pairs <= MOST_PAIRS) {
            distances.resize(count * count, f32::INFINITY);
            for cell in terrain.traversable_cells() {
                fill(&scenario, cell, &mut distances[cell.index() * count..][..count]);
            }
        }
        Self { scenario, neighbors, area, distances }
    }

    /// The scenario.
    #[must_use]
    pub const fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Number of steps in the scenario's moves: 4 or 8.
    #[must_use]
    pub const fn step_count(&self) -> usize {
        self.scenario.connectivity().offsets().len()
    }

    /// The cell that a step leads to, by its index in [`Connectivity::offsets`], if it can be taken.
    #[must_use]
    pub fn neighbor(&self, from: Cell, step: usize) -> Option<Cell> {
        let steps = self.step_count();
        if step < steps { self.neighbors[from.index() * steps + step] } else { None }
    }

    /// Whether there is a path from one cell to another.
    #[must_use]
    pub fn is_in_reach(&self, from: Cell, to: Cell) -> bool {
        from != to && self.area[from.index()].is_some() && self.area[from.index()] == self.area[to.index()]
    }

    /// Writes the lengths of the shortest paths from a cell, cells, to shape `[cells]`; infinite out of reach.
    pub fn draw_distances(&self, from: Cell, lengths: &mut [f32]) {
        let count = lengths.len();
        match self.distances.get(from.index() * count..(from.index() + 1) * count) {
            Some(row) => lengths.copy_from_slice(row),
            None => fill(&self.scenario, from, lengths),
        }
    }
}

fn fill(scenario: &Scenario, from: Cell, lengths: &mut [f32]) {
    let routes = ShortestPathTree::from(scenario.terrain(), scenario.connectivity(), from);
    for (cell, length) in scenario.terrain().grid().cells().zip(lengths) {
        *length = routes.length(cell);
    }
}
