//! Graphs in a batch, padded to one size, and a last row that stands for no node.

use tch::{Device, Kind, Tensor};

use super::data::Sample;
use dragnet_learn::graph::{Edges, Graph, NEIGHBORS};

/// Added to the score of a missing neighbor and the logit of a cell that is not a candidate: its softmax is 0.
pub(super) const NEVER: f32 = -1e9;

/// A batch of graphs. Rows are `graphs * nodes + 1`.
#[derive(Debug)]
pub(super) struct Batch {
    pub(super) graphs: i64,
    /// Nodes of the largest graph.
    pub(super) nodes: i64,
    /// Shape `[rows, features]`.
    pub(super) features: Tensor,
    pub(super) neighbors: Neighbors,
    /// Coarser graphs, the finest first.
    pub(super) levels: Vec<LevelBatch>,
    /// 1 or 0, shape `[rows, 1]`.
    pub(super) is_node: Tensor,
    /// 1 for nodes except the root, otherwise 0, shape `[rows, 1]`.
    pub(super) is_candidate: Tensor,
    /// Rows of the ancestors 1, 2, 4, .. cells before each row on its path, shape `[rows]` each.
    ancestors: Vec<Tensor>,
}

/// Neighbors of all rows, in as many slots as one may have.
#[derive(Debug)]
pub(super) struct Neighbors {
    /// How many one may have.
    pub(super) slots: i64,
    /// Row of each neighbor, shape `[rows * slots]`.
    pub(super) rows: Tensor,
    /// Of each neighbor, shape `[rows, slots, 1]`.
    pub(super) inverse_distance: Tensor,
    /// 1 or 0, shape `[rows, slots, 1]`.
    pub(super) is_there: Tensor,
    /// 0 or [`NEVER`], shape `[rows, slots, 1]`.
    pub(super) is_missing: Tensor,
}

/// One of the coarser graphs, all of a batch behind each other and a last row that stands for no node.
#[derive(Debug)]
pub(super) struct LevelBatch {
    /// The row of this level that each row below is part of, shape `[rows below]`.
    pub(super) piece: Tensor,
    /// Rows below of each, at least 1, shape `[rows, 1]`.
    pub(super) parts: Tensor,
    /// Shape `[rows, 1]`.
    pub(super) size: Tensor,
    pub(super) neighbors: Neighbors,
}

/// The expert's choices in the graphs of a batch.
#[derive(Debug)]
pub(super) struct Answers {
    /// Shape `[graphs, 1]`.
    pub(super) chosen: Tensor,
    /// A distribution over nodes, shape `[graphs, nodes]`.
    pub(super) wished: Tensor,
    /// 0 or [`NEVER`], shape `[graphs, nodes]`.
    pub(super) no_candidate: Tensor,
}

impl Batch {
    pub(super) fn of_graphs(graphs: &[&Graph], device: Device) -> Self {
        let nodes = graphs.iter().map(|graph| graph.topology.len()).max().unwrap_or(0);
        let rows = graphs.len() * nodes + 1;
        let none = int(rows - 1);
        let width = graphs.first().map_or(0, |graph| graph.features.len() / graph.topology.len());
        let mut features = vec![0.0_f32; rows * width];
        let (mut is_node, mut is_candidate) = (vec![0.0_f32; rows], vec![0.0_f32; rows]);
        let mut parent = vec![none; rows];
        let mut deepest = 0;
        let mut neighbors = Lists::new(rows, NEIGHBORS);
        for (place, graph) in graphs.iter().enumerate() {
            let first = place * nodes;
            let count = graph.topology.len();
            features[first * width..][..count * width].copy_from_slice(&graph.features);
            is_node[first..first + count].fill(1.0);
            is_candidate[first..first + count].fill(1.0);
            is_candidate[first + graph.root as usize] = 0.0;
            neighbors.add(graph.topology.edge_lists(), first, count);
            deepest = deepest.max(carry_parents(graph, first, &mut parent));
        }
        let firsts: Vec<usize> = (0..graphs.len()).map(|place| place * nodes).collect();
        let column = |values: &[f32]| Tensor::from_slice(values).view([-1, 1]).to_device(device);
        Self {
            graphs: int(graphs.len()),
            nodes: int(nodes),
            features: Tensor::from_slice(&features).view([int(rows), int(width)]).to_device(device),
            neighbors: neighbors.tensors(device),
            levels: levels(graphs, (firsts, rows), device),
            is_node: column(&is_node),
            is_candidate: column(&is_candidate),
            ancestors: ancestors(parent, deepest)
                .iter()
                .map(|rows| Tensor::from_slice(rows).to_device(device))
                .collect(),
        }
    }

    /// `r(child) = values(child) + fade * r(parent)` along all paths, without `fade` a plain sum, by doubling: after
    /// step `k` a row holds what the `2^k` cells up to it carry. No row of the result depends on depth, so that one
    /// operation serves all rows, while a traversal of the tree takes as many as the longest path has cells.
    pub(super) fn carry(&self, values: Tensor, fade: Option<&Tensor>) -> Tensor {
        let mut carried = values;
        let mut fade = fade.map(Tensor::shallow_clone);
        for ancestors in &self.ancestors {
            let before = carried.index_select(0, ancestors);
            carried = match &fade {
                Some(fade) => carried + before * fade,
                None => carried + before,
            };
            fade = fade.map(|fade| fade.square());
        }
        carried
    }
}

/// Neighbors as they are collected. The last row stands for none.
struct Lists {
    slots: usize,
    rows: Vec<i64>,
    inverse_distance: Vec<f32>,
}

impl Lists {
    fn new(rows: usize, slots: usize) -> Self {
        Self { slots, rows: vec![int(rows - 1); rows * slots], inverse_distance: vec![0.0; rows * slots] }
    }

    /// Those of a graph whose nodes start at this row.
    fn add(&mut self, edges: &Edges, first: usize, count: usize) {
        for node in 0..count {
            for (slot, edge) in edges.of(node).iter().enumerate() {
                let slot = (first + node) * self.slots + slot;
                self.rows[slot] = int(first + edge.node as usize);
                self.inverse_distance[slot] = edge.inverse_distance;
            }
        }
    }

    fn tensors(&self, device: Device) -> Neighbors {
        let shape = [-1, int(self.slots), 1];
        let floats = |values: &[f32]| Tensor::from_slice(values).view(shape).to_device(device);
        let of = |there: f32, missing: f32| -> Vec<f32> {
            self.inverse_distance.iter().map(|&it| if it > 0.0 { there } else { missing }).collect()
        };
        Neighbors {
            slots: int(self.slots),
            rows: Tensor::from_slice(&self.rows).to_device(device),
            inverse_distance: floats(&self.inverse_distance),
            is_there: floats(&of(1.0, 0.0)),
            is_missing: floats(&of(0.0, NEVER)),
        }
    }
}

/// The coarser graphs of all graphs. `below` is the first row of each of them in the level below, and its rows.
fn levels(graphs: &[&Graph], mut below: (Vec<usize>, usize), device: Device) -> Vec<LevelBatch> {
    let count = graphs.first().map_or(0, |graph| graph.levels.len());
    let level = |number: usize| {
        let nodes = |graph: &Graph| graph.levels[number].len();
        let rows = graphs.iter().map(|graph| nodes(graph)).sum::<usize>() + 1;
        let mut firsts = Vec::with_capacity(graphs.len());
        let mut piece = vec![int(rows - 1); below.1];
        let mut size = Vec::with_capacity(rows);
        let most = graphs.iter().flat_map(|graph| {
            let level = &graph.levels[number];
            (0..level.len()).map(|node| level.edges.of(node).len())
        });
        let mut neighbors = Lists::new(rows, most.max().unwrap_or(0).max(1));
        for (graph, &below) in graphs.iter().zip(&below.0) {
            let (level, first) = (&graph.levels[number], size.len());
            for (place, &of_place) in piece[below..].iter_mut().zip(&level.piece) {
                *place = int(first + of_place as usize);
            }
            neighbors.add(&level.edges, first, level.len());
            size.extend_from_slice(&level.size);
            firsts.push(first);
        }
        size.push(0.0);
        let mut parts = vec![0.0_f32; rows];
        for &row in &piece {
            #[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "rows")]
            let row = row as usize;
            parts[row] += 1.0;
        }
        parts[rows - 1] = 1.0;
        below = (firsts, rows);
        let column = |values: &[f32]| Tensor::from_slice(values).view([-1, 1]).to_device(device);
        LevelBatch {
            piece: Tensor::from_slice(&piece).to_device(device),
            parts: column(&parts),
            size: column(&size),
            neighbors: neighbors.tensors(device),
        }
    };
    (0..count).map(level).collect()
}

/// Rows of the parents of a graph's nodes; that of the root is unchanged. Returns the number of moves of the longest
/// path.
fn carry_parents(graph: &Graph, first: usize, parent: &mut [i64]) -> usize {
    let mut depth = vec![0_usize; graph.parent.len()];
    for &node in &graph.order[1..] {
        let above = graph.parent[node as usize] as usize;
        parent[first + node as usize] = int(first + above);
        depth[node as usize] = depth[above] + 1;
    }
    depth.into_iter().max().unwrap_or(0)
}

fn ancestors(parent: Vec<i64>, deepest: usize) -> Vec<Vec<i64>> {
    let mut tables = vec![parent];
    while 1 << tables.len() <= deepest {
        let last = &tables[tables.len() - 1];
        #[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "rows")]
        let next = last.iter().map(|&row| last[row as usize]).collect();
        tables.push(next);
    }
    tables
}

impl Answers {
    pub(super) fn of(samples: &[&Sample], nodes: i64, device: Device) -> Self {
        #[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "a size")]
        let width = nodes as usize;
        let mut wished = vec![0.0_f32; samples.len() * width];
        let mut no_candidate = vec![NEVER; samples.len() * width];
        for (place, sample) in samples.iter().enumerate() {
            let first = place * width;
            let count = sample.graph.topology.len();
            wished[first..first + count].copy_from_slice(&sample.wished);
            for (no_candidate, &is_scored) in no_candidate[first..].iter_mut().zip(&sample.is_scored) {
                *no_candidate = if is_scored { 0.0 } else { NEVER };
            }
            no_candidate[first + sample.graph.root as usize] = NEVER;
        }
        let chosen: Vec<i64> = samples.iter().map(|sample| i64::from(sample.chosen)).collect();
        let shape = [int(samples.len()), nodes];
        Self {
            chosen: Tensor::from_slice(&chosen).view([shape[0], 1]).to_device(device),
            wished: Tensor::from_slice(&wished).view(shape).to_device(device),
            no_candidate: Tensor::from_slice(&no_candidate).view(shape).to_device(device),
        }
    }

    /// `ln pi(x | G)` over candidates, shape `[graphs, nodes]`.
    pub(super) fn log_policy(&self, logits: &Tensor) -> Tensor {
        (logits + &self.no_candidate).log_softmax(1, Kind::Float)
    }
}

/// libtorch counts in signed numbers.
pub(super) fn int(size: usize) -> i64 {
    i64::try_from(size).unwrap_or(i64::MAX)
}
