//! Nodes and edges of a map.

use dragnet_search::cell::{Cell, Offset};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::terrain::Terrain;

/// Maximum number of neighbors of a node.
pub const NEIGHBORS: usize = 8;

const OFFSETS: [Offset; NEIGHBORS] = [
    Offset { north: -1, east: -1 },
    Offset { north: -1, east: 0 },
    Offset { north: -1, east: 1 },
    Offset { north: 0, east: -1 },
    Offset { north: 0, east: 1 },
    Offset { north: 1, east: -1 },
    Offset { north: 1, east: 0 },
    Offset { north: 1, east: 1 },
];

/// The node of a cell that is not a node.
const NONE: u32 = u32::MAX;

/// The connected area of a map that a robot can reach, as nodes and edges.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    cells: Vec<Cell>,
    /// Shape `[cells of the map]`.
    node: Vec<u32>,
    columns: u32,
    edges: Edges,
}

/// The edges of all nodes of a graph.
#[derive(Clone, Debug, PartialEq)]
pub struct Edges {
    /// First edge of each node in `edges`, and the end of the last: shape `[nodes + 1]`.
    starts: Vec<u32>,
    edges: Vec<Edge>,
}

impl Default for Edges {
    fn default() -> Self {
        Self { starts: vec![0], edges: Vec::new() }
    }
}

impl Edges {
    /// Adds those of the next node.
    pub(super) fn push(&mut self, edges: impl IntoIterator<Item = Edge>) {
        self.edges.extend(edges);
        self.starts.push(u32::try_from(self.edges.len()).unwrap_or(u32::MAX));
    }

    /// Edges from the neighbors of a node to it.
    #[must_use]
    pub fn of(&self, node: usize) -> &[Edge] {
        &self.edges[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}

/// An edge to a neighbor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The neighbor.
    pub node: u32,
    /// Inverse of its distance in cells (paper, Section V-C): 1, or `1 / sqrt 2` at a corner.
    pub inverse_distance: f32,
}

impl Edge {
    /// An edge to a neighbor that lies straight ahead, or at a corner.
    pub(super) const fn between(node: u32, is_straight: bool) -> Self {
        let inverse_distance = if is_straight { 1.0 } else { std::f32::consts::FRAC_1_SQRT_2 };
        Self { node, inverse_distance }
    }
}

impl Topology {
    /// The nodes and edges of the area that `routes` reach.
    #[must_use]
    pub fn new(terrain: &Terrain, routes: &ShortestPathTree) -> Self {
        let grid = terrain.grid();
        let mut cells = routes.reached().to_vec();
        cells.sort_unstable();
        let mut node = vec![NONE; grid.cell_count()];
        for (number, cell) in (0..).zip(&cells) {
            node[cell.index()] = number;
        }
        let mut edges = Edges::default();
        for &cell in &cells {
            edges.push(OFFSETS.into_iter().filter_map(|offset| {
                let neighbor = grid.step(cell, offset).map_or(NONE, |to| node[to.index()]);
                (neighbor != NONE).then(|| Edge::between(neighbor, offset.north == 0 || offset.east == 0))
            }));
        }
        Self { cells, node, columns: grid.columns(), edges }
    }

    /// Whether this is the topology of the area that `routes` reach on a terrain.
    #[must_use]
    pub fn is_of(&self, terrain: &Terrain, routes: &ShortestPathTree) -> bool {
        self.columns == terrain.grid().columns()
            && self.node.len() == terrain.grid().cell_count()
            && self.cells.len() == routes.reached().len()
            && routes.reached().iter().all(|&cell| self.node(cell) != NONE)
    }

    /// Number of nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether there is no node; never true, because the robot's own cell is a node.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The cell of each node, by ascending index.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The node of a cell that is in reach.
    #[must_use]
    pub fn node(&self, cell: Cell) -> u32 {
        self.node[cell.index()]
    }

    /// Edges from the neighbors of a node to it.
    #[must_use]
    pub fn edges(&self, node: usize) -> &[Edge] {
        self.edges.of(node)
    }

    /// Those of all nodes.
    #[must_use]
    pub const fn edge_lists(&self) -> &Edges {
        &self.edges
    }
}
