//! Shortest paths: one tree from the robot's cell serves all candidates.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};

use crate::cell::{Cell, Offset, Position};
use crate::terrain::Terrain;

const FOUR: [Offset; 4] = [step(-1, 0), step(0, -1), step(0, 1), step(1, 0)];

const EIGHT: [Offset; 8] =
    [step(-1, -1), step(-1, 0), step(-1, 1), step(0, -1), step(0, 1), step(1, -1), step(1, 0), step(1, 1)];

const fn step(north: i32, east: i32) -> Offset {
    Offset { north, east }
}

/// The neighboring cells that a robot can move to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Connectivity {
    /// North, east, south and west, at cost 1.
    #[default]
    Four,
    /// Also the diagonals, at cost sqrt 2, where both cells beside the diagonal are traversable: no corner is cut.
    Eight,
}

impl Connectivity {
    /// The steps, in order of the index of the cell that they reach.
    #[must_use]
    pub const fn offsets(self) -> &'static [Offset] {
        match self {
            Self::Four => &FOUR,
            Self::Eight => &EIGHT,
        }
    }

    /// The cell that one of the steps leads to from a cell, if it can be taken.
    #[must_use]
    pub fn step(terrain: &Terrain, from: Cell, offset: Offset) -> Option<Cell> {
        Self::step_from(terrain, terrain.grid().position(from), offset)
    }

    #[inline]
    fn step_from(terrain: &Terrain, from: Position, offset: Offset) -> Option<Cell> {
        let grid = terrain.grid();
        let is_open = |offset| grid.step_from(from, offset).filter(|&to| terrain.is_traversable(to));
        let to = is_open(offset)?;
        let is_straight = offset.north == 0 || offset.east == 0;
        let is_clear = || {
            is_open(Offset { north: offset.north, east: 0 }).is_some()
                && is_open(Offset { north: 0, east: offset.east }).is_some()
        };
        (is_straight || is_clear()).then_some(to)
    }

    /// Cells that can be reached from a cell in one move, by index.
    pub fn neighbors(self, terrain: &Terrain, from: Cell) -> impl Iterator<Item = Cell> + '_ {
        let from = terrain.grid().position(from);
        self.offsets().iter().filter_map(move |&offset| Self::step_from(terrain, from, offset))
    }
}

/// Shortest paths from one cell to all that can be reached. Of equally short paths to a cell the one whose last step
/// comes from the smallest cell index is taken, and so on back to the root.
#[derive(Clone, Debug)]
pub struct ShortestPathTree {
    root: Cell,
    /// Reached cells, the root first, parents before children.
    order: Vec<Cell>,
    /// The cell before each on its path, shape `[cells]`; of the root and of cells out of reach, itself.
    parent: Vec<Cell>,
    /// Path length, in cells (a diagonal counts sqrt 2), shape `[cells]`; infinite out of reach.
    length: Vec<f32>,
    /// Whether longer paths were left out.
    is_cut: bool,
}

impl ShortestPathTree {
    /// The tree from `root`, by breadth-first search or, with diagonals, by Dijkstra (1959).
    #[must_use]
    pub fn from(terrain: &Terrain, connectivity: Connectivity, root: Cell) -> Self {
        Self::within(terrain, connectivity, root, f32::INFINITY)
    }

    /// The part of that tree whose paths are at most `longest` cells long. Other cells are out of reach; their lengths
    /// and parents are meaningless.
    #[must_use]
    pub fn within(terrain: &Terrain, connectivity: Connectivity, root: Cell, longest: f32) -> Self {
        let count = terrain.grid().cell_count();
        let mut routes = Self {
            root,
            order: Vec::with_capacity(count),
            parent: terrain.grid().cells().collect(),
            length: vec![f32::INFINITY; count],
            is_cut: false,
        };
        routes.length[root.index()] = 0.0;
        match connectivity {
            Connectivity::Four => routes.breadth_first(terrain, longest),
            Connectivity::Eight => routes.dijkstra(terrain, longest),
        }
        routes
    }

    fn breadth_first(&mut self, terrain: &Terrain, longest: f32) {
        let mut queue = VecDeque::from([self.root]);
        while let Some(cell) = queue.pop_front() {
            let length = self.length[cell.index()] + 1.0;
            if length > longest + 1.0 {
                self.is_cut = true;
                return;
            }
            self.order.push(cell);
            for next in Connectivity::Four.neighbors(terrain, cell) {
                let known = &mut self.length[next.index()];
                if known.is_infinite() {
                    *known = length;
                    self.parent[next.index()] = cell;
                    queue.push_back(next);
                } else if *known >= length {
                    // The queue holds a ring in an order of its own; the tie is by index.
                    let parent = &mut self.parent[next.index()];
                    *parent = (*parent).min(cell);
                }
            }
        }
    }

    fn dijkstra(&mut self, terrain: &Terrain, longest: f32) {
        let mut steps = vec![Steps::default(); terrain.grid().cell_count()];
        let mut settled = vec![false; terrain.grid().cell_count()];
        let mut queue = BinaryHeap::from([Frontier { length: 0.0, cell: self.root }]);
        while let Some(Frontier { cell, length }) = queue.pop() {
            if std::mem::replace(&mut settled[cell.index()], true) {
                continue;
            }
            if length > longest {
                self.is_cut = true;
                return;
            }
            self.order.push(cell);
            for next in Connectivity::Eight.neighbors(terrain, cell) {
                let taken = steps[cell.index()].and(terrain.grid().offset(cell, next));
                let length = taken.length();
                let known = &mut self.length[next.index()];
                let parent = &mut self.parent[next.index()];
                match length.total_cmp(known) {
                    Ordering::Less => {
                        (*known, *parent) = (length, cell);
                        steps[next.index()] = taken;
                        queue.push(Frontier { length, cell: next });
                    }
                    Ordering::Equal => *parent = (*parent).min(cell),
                    Ordering::Greater => {}
                }
            }
        }
    }

    /// The part of the tree that leads to those of its cells that are wanted, by their path lengths. Other cells count as
    /// unreachable.
    #[must_use]
    pub fn only_to(mut self, is_wanted: impl Fn(Cell, f32) -> bool) -> Self {
        let mut is_kept = vec![false; self.length.len()];
        is_kept[self.root.index()] = true;
        for &cell in self.order.iter().rev() {
            if is_kept[cell.index()] || is_wanted(cell, self.length(cell)) {
                is_kept[cell.index()] = true;
                is_kept[self.parent(cell).index()] = true;
            }
        }
        let Self { order, parent, length, .. } = &mut self;
        order.retain(|&cell| {
            if !is_kept[cell.index()] {
                (parent[cell.index()], length[cell.index()]) = (cell, f32::INFINITY);
            }
            is_kept[cell.index()]
        });
        self
    }

    /// Whether longer paths exist that were left out.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// The cell that the paths start in.
    #[must_use]
    pub const fn root(&self) -> Cell {
        self.root
    }

    /// Reached cells, parents before children, the root first.
    #[must_use]
    pub fn reached(&self) -> &[Cell] {
        &self.order
    }

    /// Reached cells except the root, parents before children: the candidates of a decision.
    #[must_use]
    pub fn candidates(&self) -> &[Cell] {
        &self.order[1..]
    }

    /// Length of the path to a cell, in cells; infinite out of reach.
    #[must_use]
    pub fn length(&self, to: Cell) -> f32 {
        self.length[to.index()]
    }

    /// The cell before `to` on its path; of the root and of cells out of reach, itself.
    #[must_use]
    pub fn parent(&self, to: Cell) -> Cell {
        self.parent[to.index()]
    }

    /// Cells entered on the path to a cell, that cell last; empty for the root and for cells out of reach.
    #[must_use]
    pub fn path(&self, to: Cell) -> Vec<Cell> {
        let mut path = Vec::new();
        let mut cell = to;
        while self.parent(cell) != cell {
            path.push(cell);
            cell = self.parent(cell);
        }
        path.reverse();
        path
    }
}

/// Straight and diagonal steps of a path. Lengths are computed from the counts, so that equally long paths compare
/// equal whatever the order of their steps.
#[derive(Clone, Copy, Debug, Default)]
struct Steps {
    straight: u32,
    diagonal: u32,
}

impl Steps {
    const fn and(self, step: Offset) -> Self {
        if step.manhattan() == 2 {
            Self { diagonal: self.diagonal + 1, ..self }
        } else {
            Self { straight: self.straight + 1, ..self }
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "paths are shorter than 2^24 cells")]
    fn length(self) -> f32 {
        (f64::from(self.straight) + f64::from(self.diagonal) * std::f64::consts::SQRT_2) as f32
    }
}

/// An entry of Dijkstra's queue: the nearest first, of equally near ones the smallest index.
#[derive(PartialEq)]
struct Frontier {
    length: f32,
    cell: Cell,
}

impl Eq for Frontier {}

impl Ord for Frontier {
    fn cmp(&self, other: &Self) -> Ordering {
        other.length.total_cmp(&self.length).then_with(|| other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Frontier {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::cell::Grid;
    use crate::terrain::Ground;

    /// Path lengths by Bellman-Ford: relax every move until nothing changes.
    fn bellman_ford(terrain: &Terrain, connectivity: Connectivity, root: Cell) -> Vec<f64> {
        let mut length = vec![f64::INFINITY; terrain.grid().cell_count()];
        length[root.index()] = 0.0;
        loop {
            let before = length.clone();
            for from in terrain.traversable_cells() {
                for to in connectivity.neighbors(terrain, from) {
                    let step = if terrain.grid().manhattan(from, to) == 2 { 2.0_f64.sqrt() } else { 1.0 };
                    length[to.index()] = length[to.index()].min(length[from.index()] + step);
                }
            }
            if length == before {
                return length;
            }
        }
    }

    fn terrain() -> impl Strategy<Value = Terrain> {
        (1_u32..9, 1_u32..9).prop_flat_map(|(rows, columns)| {
            let grid = Grid::new(rows, columns).unwrap();
            prop::collection::vec(prop::bool::weighted(0.7), grid.cell_count()).prop_map(move |open| {
                let ground =
                    open.into_iter().map(|open| if open { Ground::OPEN } else { Ground::BLOCKED }).collect();
                Terrain::new(grid, 1.0, ground).unwrap()
            })
        })
    }

    proptest! {
        #[test]
        fn paths_are_as_short_as_bellman_ford_finds(terrain in terrain(), eight in any::<bool>()) {
            let connectivity = if eight { Connectivity::Eight } else { Connectivity::Four };
            for root in terrain.traversable_cells() {
                let routes = ShortestPathTree::from(&terrain, connectivity, root);
                let expected = bellman_ford(&terrain, connectivity, root);
                for cell in terrain.grid().cells() {
                    let (given, expected) = (f64::from(routes.length(cell)), expected[cell.index()]);
                    prop_assert!(given.is_infinite() && expected.is_infinite() || (given - expected).abs() < 1e-4);
                    let smallest = connectivity
                        .neighbors(&terrain, cell)
                        .filter(|&from| terrain.is_traversable(cell) && given.is_finite() && {
                            let step = f64::from(terrain.grid().manhattan(from, cell)).sqrt();
                            (f64::from(routes.length(from)) + step - given).abs() < 1e-4
                        })
                        .min();
                    if cell != root && given.is_finite() {
                        prop_assert_eq!(Some(routes.parent(cell)), smallest);
                    }
                }
                prop_assert_eq!(routes.reached().len(), expected.iter().filter(|l| l.is_finite()).count());
            }
        }
    }

    #[test]
    fn a_path_goes_around_and_ends_at_its_goal() {
        let terrain = Terrain::from_ascii("...\n.#.\n.#.\n", 1.0).unwrap();
        let at = |row, column| terrain.grid().cell(Position { row, column }).unwrap();
        let routes = ShortestPathTree::from(&terrain, Connectivity::Four, at(0, 0));
        let path = routes.path(at(0, 2));
        assert_eq!(path, [at(1, 0), at(2, 0), at(2, 1), at(2, 2), at(1, 2), at(0, 2)]);
        assert!(routes.path(at(0, 0)).is_empty());
        assert!(routes.path(at(0, 1)).is_empty());
    }

    #[test]
    fn a_diagonal_cuts_no_corner() {
        let terrain = Terrain::from_ascii("..\n.#\n", 1.0).unwrap();
        let at = |row, column| terrain.grid().cell(Position { row, column }).unwrap();
        let routes = ShortestPathTree::from(&terrain, Connectivity::Eight, at(0, 0));
        assert_eq!(routes.path(at(1, 1)), [at(1, 0), at(1, 1)]);
    }
}
