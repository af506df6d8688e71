//! Coarser graphs above that of cells.
//!
//! A level is the map in square blocks of 3, 9, 27, .. cells a side, the robot's cell in the middle of one. So a map that
//! is moved, turned or mirrored has the same blocks. A node is a connected piece of a block: what a wall separates stays
//! separate. Edges join pieces that touch.

use dragnet_search::cell::{Cell, Grid};

use super::topology::{Edge, Edges, Topology};

/// No node.
const NONE: u32 = u32::MAX;
/// Cells along the side of a block, in blocks of the level below.
const SIDE: i32 = 3;
/// The most neighbors of a node of a level. One with more, on a map of many small pieces, keeps those that it touches
/// most, and of these the ones with the smaller index.
pub const COARSE_NEIGHBORS: usize = 24;

/// One of the coarser graphs.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// The node of this level that each node of the level below is part of.
    pub piece: Vec<u32>,
    /// Cells of each node, as a share of its block: shape `[nodes]`.
    pub size: Vec<f32>,
    /// Its edges.
    pub edges: Edges,
}

impl Level {
    /// Number of nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.size.len()
    }

    /// Whether there is no node: never so.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.size.is_empty()
    }
}

/// Row and column of a block, from that of the robot.
type Block = (i32, i32);

/// The graph below the next level.
struct Below<'a> {
    edges: &'a Edges,
    /// Of each node.
    blocks: Vec<Block>,
    /// Cells of each node.
    cells: Vec<u32>,
}

/// This many levels above the cells.
pub(super) fn levels(topology: &Topology, grid: Grid, robot: Cell, count: usize) -> Vec<Level> {
    let origin = grid.position(robot);
    let from_robot = |cell: &Cell| {
        let position = grid.position(*cell);
        let difference = |to: u32, from: u32| to.cast_signed() - from.cast_signed();
        (difference(position.row, origin.row), difference(position.column, origin.column))
    };
    let mut levels: Vec<Level> = Vec::with_capacity(count);
    let mut blocks: Vec<Block> = topology.cells().iter().map(from_robot).collect();
    let mut cells = vec![1; topology.len()];
    let mut block_cells = 1;
    for _ in 0..count {
        let edges = levels.last().map_or(topology.edge_lists(), |level| &level.edges);
        block_cells *= SIDE * SIDE;
        let (level, above) = level_above(&Below { edges, blocks, cells }, block_cells);
        (blocks, cells) = above;
        levels.push(level);
    }
    levels
}

/// The next level, and the blocks and cells of its nodes.
fn level_above(below: &Below<'_>, block_cells: i32) -> (Level, (Vec<Block>, Vec<u32>)) {
    let middle = (SIDE - 1) / 2;
    let block_of =
        |(row, column): Block| ((row + middle).div_euclid(SIDE), (column + middle).div_euclid(SIDE));
    let count = below.blocks.len();
    let of_node: Vec<Block> = below.blocks.iter().map(|&block| block_of(block)).collect();
    let mut piece = vec![NONE; count];
    let (mut blocks, mut cells) = (Vec::new(), Vec::new());
    let mut open = Vec::new();
    for start in 0..count {
        if piece[start] != NONE {
            continue;
        }
        let number = u32::try_from(blocks.len()).unwrap_or(NONE);
        blocks.push(of_node[start]);
        cells.push(0);
        piece[start] = number;
        open.push(start);
        while let Some(node) = open.pop() {
            cells[number as usize] += below.cells[node];
            for edge in below.edges.of(node) {
                let near = edge.node as usize;
                if piece[near] == NONE && of_node[near] == of_node[start] {
                    piece[near] = number;
                    open.push(near);
                }
            }
        }
    }
    let edges = edges_between(below.edges, &piece, &blocks);
    let size = cells.iter().map(|&cells| cells as f32 / block_cells as f32).collect();
    (Level { piece, size, edges }, (blocks, cells))
}

fn edges_between(below: &Edges, piece: &[u32], blocks: &[Block]) -> Edges {
    // How often each pair touches.
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for (node, &from) in piece.iter().enumerate() {
        let others = below.of(node).iter().map(|edge| piece[edge.node as usize]);
        pairs.extend(others.filter(|&to| to != from).map(|to| (from, to)));
    }
    pairs.sort_unstable();
    let mut lists = Edges::default();
    let mut pairs = pairs.chunk_by(|a, b| a == b).peekable();
    for from in 0..blocks.len() {
        let mut touching: Vec<(usize, u32)> = Vec::new();
        while let Some(pair) = pairs.next_if(|pair| pair[0].0 as usize == from) {
            touching.push((pair.len(), pair[0].1));
        }
        if touching.len() > COARSE_NEIGHBORS {
            touching.sort_by_key(|&(touches, to)| (std::cmp::Reverse(touches), to));
            touching.truncate(COARSE_NEIGHBORS);
            touching.sort_by_key(|&(_, to)| to);
        }
        lists.push(touching.into_iter().map(|(_, to)| {
            let ((row, column), (to_row, to_column)) = (blocks[from], blocks[to as usize]);
            Edge::between(to, row == to_row || column == to_column)
        }));
    }
    lists
}

#[cfg(test)]
mod tests {
    use dragnet_search::route::{Connectivity, ShortestPathTree};
    use dragnet_search::terrain::Terrain;

    use super::*;

    #[test]
    fn what_a_wall_separates_are_two_pieces_of_a_block() {
        let terrain = Terrain::from_ascii(".........\n####.####\n.........\n", 1.0).unwrap();
        let middle = terrain.grid().cells().nth(13).unwrap();
        let routes = ShortestPathTree::from(&terrain, Connectivity::Four, middle);
        let topology = Topology::new(&terrain, &routes);
        let levels = levels(&topology, terrain.grid(), middle, 2);
        // Two pieces at the left, one around the robot, two at the right.
        let cells: Vec<f32> = levels[0].size.iter().map(|size| size * 9.0).collect();
        assert_eq!(cells, [3.0, 7.0, 3.0, 3.0, 3.0]);
        let neighbors = |node: usize| -> Vec<(u32, f32)> {
            levels[0].edges.of(node).iter().map(|it| (it.node, it.inverse_distance)).collect()
        };
        assert_eq!(neighbors(1), [(0, 1.0), (2, 1.0), (3, 1.0), (4, 1.0)]);
        for node in [0, 2, 3, 4] {
            assert_eq!(neighbors(node), [(1, 1.0)], "{node}");
        }
        assert_eq!(levels[1].piece, [0; 5]);
        assert_eq!(levels[1].size, [19.0 / 81.0]);
        assert!(levels[1].edges.of(0).is_empty());
    }
}
