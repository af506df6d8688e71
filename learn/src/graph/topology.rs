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
    /// First edge of each node in `edges`, and the end of the last: shape `[nodes + 1]`.
    starts: Vec<u32>,
    edges: Vec<Edge>,
}

/// An edge to a neighbor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The neighbor.
    pub node: u32,
    /// Inverse of its distance in cells (paper, Section V-C): 1, or `1 / sqrt 2` at a corner.
    pub inverse_distance: f32,
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
        let (mut starts, mut edges) = (vec![0], Vec::with_capacity(cells.len() * NEIGHBORS));
        for &cell in &cells {
            for offset in OFFSETS {
                let neighbor = grid.step(cell, offset).map_or(NONE, |to| node[to.index()]);
                if neighbor != NONE {
                    let is_straight = offset.north == 0 || offset.east == 0;
                    let inverse_distance = if is_straight { 1.0 } else { std::f32::consts::FRAC_1_SQRT_2 };
                    edges.push(Edge { node: neighbor, inverse_distance });
                }
            }
            starts.push(u32::try_from(edges.len()).unwrap_or(u32::MAX));
        }
        Self { cells, node, columns: grid.columns(), starts, edges }
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
        &self.edges[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}
