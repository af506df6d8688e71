//! The data that all searches of a scenario share: its map, and tables computed from it.

use std::borrow::Cow;

use dragnet_scenario::Scenario;
use dragnet_search::cell::Cell;
use dragnet_search::route::{Connectivity, ShortestPathTree};

/// Shares of shortest paths are stored for all pairs of cells up to this number of pairs: 16 MiB.
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
    /// [`Field::distance_shares`] of each cell, shape `[cells, cells]`; empty on large maps.
    distance_shares: Vec<f32>,
    /// [`Field::least_precision`].
    least_precision: f64,
}

/// What an action names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// A cell to go to, by index.
    Waypoint,
    /// A step to a neighbor, by its index in the offsets of the moves.
    Step,
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
        let mut distance_shares = Vec::new();
        if count.checked_mul(count).is_some_and(|pairs| pairs <= MOST_PAIRS) {
            distance_shares.resize(count * count, 1.0);
            for cell in terrain.traversable_cells() {
                distance_shares[cell.index() * count..][..count].copy_from_slice(&shares(&scenario, cell));
            }
        }
        let precisions = scenario.widest_sensor().footprint().iter().map(|it| it.precision as f64);
        let least_precision = precisions.fold(f64::INFINITY, f64::min);
        Self { scenario, neighbors, area, distance_shares, least_precision }
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

    /// Number of actions.
    #[must_use]
    pub fn action_count(&self, control: Control) -> usize {
        match control {
            Control::Waypoint => self.scenario.terrain().grid().cell_count(),
            Control::Step => self.step_count(),
        }
    }

    /// The cell that an action leads to from a cell, if it can be taken.
    #[must_use]
    pub fn target(&self, control: Control, from: Cell, action: usize) -> Option<Cell> {
        match control {
            Control::Step => self.neighbor(from, action),
            Control::Waypoint => {
                let grid = self.scenario.terrain().grid();
                let cell = u32::try_from(action).ok().and_then(|number| grid.cell_numbered(number));
                cell.filter(|&cell| self.is_in_reach(from, cell))
            }
        }
    }

    /// Writes 1 for each action that can be taken from a cell, else 0: shape `[actions]`.
    pub fn draw_mask(&self, control: Control, from: Cell, mask: &mut [i8]) {
        match control {
            Control::Step => {
                for (step, is_open) in mask.iter_mut().enumerate() {
                    *is_open = i8::from(self.neighbor(from, step).is_some());
                }
            }
            Control::Waypoint => {
                let area = self.area[from.index()];
                for (is_open, other) in mask.iter_mut().zip(&self.area) {
                    *is_open = i8::from(area.is_some() && *other == area);
                }
                mask[from.index()] = 0;
            }
        }
    }

    /// The share of a robot's budget that this path length is, meters; `0..=1`.
    #[must_use]
    pub fn budget(&self, remaining_meters: f64) -> f32 {
        let cells = remaining_meters / self.scenario.terrain().cell_meters();
        #[expect(clippy::cast_possible_truncation, reason = "a share for networks")]
        let share = (cells / self.scenario.budget_cells().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0) as f32;
        share
    }

    /// Precision that a reading from the sensor's radius adds, units of [`dragnet_search::evidence`]: the least that any does.
    #[must_use]
    pub const fn least_precision(&self) -> f64 {
        self.least_precision
    }

    /// Length `d` of the shortest path from a cell to each, as `d / (d + h)`, where `h` is half of the sum of the map's rows and
    /// columns; 1 out of reach. Shape `[cells]`.
    #[must_use]
    pub fn distance_shares(&self, from: Cell) -> Cow<'_, [f32]> {
        let count = self.scenario.terrain().grid().cell_count();
        match self.distance_shares.get(from.index() * count..(from.index() + 1) * count) {
            Some(row) => Cow::Borrowed(row),
            None => Cow::Owned(shares(&self.scenario, from)),
        }
    }

    /// Cells entered on the shortest path from a cell to another, that of [`ShortestPathTree::path`]; empty if there is none.
    #[must_use]
    pub fn path(&self, from: Cell, to: Cell) -> Vec<Cell> {
        let (terrain, connectivity) = (self.scenario.terrain(), self.scenario.connectivity());
        if connectivity == Connectivity::Eight || self.distance_shares.is_empty() {
            return ShortestPathTree::from(terrain, connectivity, from).path(to);
        }
        let mut path = Vec::new();
        if !self.is_in_reach(from, to) {
            return path;
        }
        let shares = self.distance_shares(from);
        let mut cell = to;
        while cell != from {
            path.push(cell);
            // Neighbors are one cell nearer or one farther, never as far; of those that are nearer the tree takes the first.
            let steps = (0..self.step_count()).filter_map(|step| self.neighbor(cell, step));
            let Some(nearer) = steps.min_by_key(|&it| (shares[it.index()] > shares[cell.index()], it)) else {
                break;
            };
            cell = nearer;
        }
        path.reverse();
        path
    }

    /// Lengths of the shortest paths from a cell, cells, shape `[cells]`; infinite out of reach.
    #[must_use]
    pub fn distances(&self, from: Cell) -> Vec<f32> {
        let (terrain, connectivity) = (self.scenario.terrain(), self.scenario.connectivity());
        let routes = ShortestPathTree::from(terrain, connectivity, from);
        terrain.grid().cells().map(|cell| routes.length(cell)).collect()
    }
}

fn shares(scenario: &Scenario, from: Cell) -> Vec<f32> {
    let (terrain, connectivity) = (scenario.terrain(), scenario.connectivity());
    let routes = ShortestPathTree::from(terrain, connectivity, from);
    let half = (terrain.grid().rows() + terrain.grid().columns()) as f32 / 2.0;
    // Not `d / (d + h)`: that is no number out of reach.
    terrain.grid().cells().map(|cell| 1.0 - half / (routes.length(cell) + half)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every path between the cells of a map; returns how many there were.
    fn check(map: &str, connectivity: u32) -> usize {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.txt"), map).unwrap();
        let text = format!(
            "name = 'a'\nmap = {{ file = 'a.txt', cell_meters = 10.0, connectivity = {connectivity} }}\n\
             sensor.radius = 1\nobjects.count = 1\nmission.budget_meters = 80.0\n"
        );
        let field = Field::new(Scenario::from_text(&folder.path().join("a.toml"), text).unwrap());
        let terrain = field.scenario().terrain();
        let mut paths = 0;
        for from in terrain.traversable_cells() {
            let tree = ShortestPathTree::from(terrain, field.scenario().connectivity(), from);
            for to in terrain.grid().cells() {
                assert_eq!(field.path(from, to), tree.path(to), "{from:?} to {to:?}");
                paths += usize::from(!tree.path(to).is_empty());
            }
        }
        paths
    }

    #[test]
    fn paths_are_those_of_the_tree() {
        let rooms = ".......#...\n.###.#.#...\n.#...#.#.#.\n...#...#.#.\n.#...###...\n.......#...\n";
        for connectivity in [4, 8] {
            assert_eq!(check("......\n......\n......\n......\n", connectivity), 24 * 23);
            assert!(check(rooms, connectivity) > 1_000);
        }
    }
}
