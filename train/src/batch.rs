//! Graphs in a batch, padded to one size, and a last row that stands for no node.

use tch::{Device, Kind, Tensor};

use super::data::Sample;
use dragnet_learn::graph::{FEATURES, Graph, NEIGHBORS};

/// Added to the score of a missing neighbor and the logit of a cell that is not a candidate: its softmax is 0.
const NEVER: f32 = -1e9;

/// A batch of graphs. Rows are `graphs * nodes + 1`.
#[derive(Debug)]
pub(super) struct Batch {
    pub(super) graphs: i64,
    /// Nodes of the largest graph.
    pub(super) nodes: i64,
    /// Shape `[rows, FEATURES]`.
    pub(super) features: Tensor,
    /// Row of each neighbor, shape `[rows * NEIGHBORS]`.
    pub(super) neighbors: Tensor,
    /// Of each neighbor, shape `[rows, NEIGHBORS, 1]`.
    pub(super) inverse_distance: Tensor,
    /// 1 or 0, shape `[rows, NEIGHBORS, 1]`.
    pub(super) is_neighbor: Tensor,
    /// 0 or [`NEVER`], shape `[rows, NEIGHBORS, 1]`.
    pub(super) no_neighbor: Tensor,
    /// 1 or 0, shape `[rows, 1]`.
    pub(super) is_node: Tensor,
    /// 1 for nodes except the root, otherwise 0, shape `[rows, 1]`.
    pub(super) is_candidate: Tensor,
    /// Rows of the ancestors 1, 2, 4, .. cells before each row on its path, shape `[rows]` each.
    ancestors: Vec<Tensor>,
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
        let mut features = vec![0.0_f32; rows * FEATURES];
        let mut neighbors = vec![none; rows * NEIGHBORS];
        let mut inverse_distance = vec![0.0_f32; rows * NEIGHBORS];
        let mut is_neighbor = vec![0.0_f32; rows * NEIGHBORS];
        let (mut is_node, mut is_candidate) = (vec![0.0_f32; rows], vec![0.0_f32; rows]);
        let mut parent = vec![none; rows];
        let mut deepest = 0;
        for (place, graph) in graphs.iter().enumerate() {
            let first = place * nodes;
            let count = graph.topology.len();
            features[first * FEATURES..][..count * FEATURES].copy_from_slice(&graph.features);
            is_node[first..first + count].fill(1.0);
            is_candidate[first..first + count].fill(1.0);
            is_candidate[first + graph.root as usize] = 0.0;
            for node in 0..count {
                for (slot, edge) in graph.topology.edges(node).iter().enumerate() {
                    let slot = (first + node) * NEIGHBORS + slot;
                    neighbors[slot] = int(first + edge.node as usize);
                    inverse_distance[slot] = edge.inverse_distance;
                    is_neighbor[slot] = 1.0;
                }
            }
            deepest = deepest.max(carry_parents(graph, first, &mut parent));
        }
        let no_neighbor: Vec<f32> =
            is_neighbor.iter().map(|is| if *is > 0.0 { 0.0 } else { NEVER }).collect();
        let (rows, slots) = (int(rows), int(NEIGHBORS));
        let floats = |values: &[f32], shape: &[i64]| Tensor::from_slice(values).view(shape).to_device(device);
        Self {
            graphs: int(graphs.len()),
            nodes: int(nodes),
            features: floats(&features, &[rows, int(FEATURES)]),
            neighbors: Tensor::from_slice(&neighbors).to_device(device),
            inverse_distance: floats(&inverse_distance, &[rows, slots, 1]),
            is_neighbor: floats(&is_neighbor, &[rows, slots, 1]),
            no_neighbor: floats(&no_neighbor, &[rows, slots, 1]),
            is_node: floats(&is_node, &[rows, 1]),
            is_candidate: floats(&is_candidate, &[rows, 1]),
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
            no_candidate[first..first + count].fill(0.0);
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
