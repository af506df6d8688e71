//! One layer of graph attention.

use pulp::Simd;

use crate::graph::Edges;
use crate::shape::HEADS;
use crate::weights::Weights;

use super::exponential::exp;
use super::linear::{LANES, Linear, load, rectify, store};
use super::{SCORE_LEAK, greater, leaky};

/// `h_i += rectifier(sum_j a_ij W h_j + b)`, with
/// `a_ij = softmax_j(leaky(source . W h_j + target . W h_i + edge / distance_ij))` in each head.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Attention {
    /// `W`, and below it `source . W` and `target . W` of each head, so that one product yields all three. The rows of
    /// `W` stand as [`Values`] do.
    project: Linear,
    edge: [f32; HEADS],
    /// Likewise.
    bias: Vec<Values>,
}

/// Nodes that are computed together.
const NODES: usize = 8;

/// A number for each neighbor and head.
type Scores<const NEIGHBORS: usize> = [[f32; HEADS]; NEIGHBORS];

/// Some channels of each head. A layer has as many of these as its heads have channels, over `LANES`.
type Values = [[f32; LANES]; HEADS];

impl Attention {
    /// The layer of a name.
    pub(super) fn new(weights: &Weights, name: &str) -> Self {
        let get = |part: &str| weights.get(&format!("{name}.{part}"));
        let hidden = get("bias").len();
        let channels = hidden / HEADS;
        let weight = get("weight");
        let row = |output: usize| &weight[output * hidden..][..hidden];
        let order: Vec<usize> = (0..channels / LANES)
            .flat_map(|group| (0..HEADS).map(move |head| head * channels + group * LANES))
            .flat_map(|first| first..first + LANES)
            .collect();
        let mut rows: Vec<f32> = order.iter().flat_map(|&output| row(output)).copied().collect();
        for vector in [get("source"), get("target")] {
            for (head, vector) in vector.chunks_exact(channels).enumerate() {
                let product = |input| -> f32 {
                    (head * channels..).zip(vector).map(|(output, a)| a * row(output)[input]).sum()
                };
                rows.extend((0..hidden).map(product));
            }
        }
        let bias: Vec<f32> = order.iter().map(|&output| get("bias")[output]).collect();
        Self {
            project: Linear::new(&rows, &vec![0.0; hidden + 2 * HEADS]),
            edge: of_heads(get("edge")),
            bias: values(&bias).to_vec(),
        }
    }

    /// Adds the layer's output to the channels, shape `[nodes, hidden]`. No node has more than `NEIGHBORS` edges.
    /// `projected` is a buffer.
    #[inline(always)]
    pub(super) fn add_to<S: Simd, const NEIGHBORS: usize>(
        &self,
        simd: S,
        channels: &mut [f32],
        edges: &Edges,
        projected: &mut Vec<f32>,
    ) {
        self.project.apply(simd, &[channels], projected);
        let hidden = self.bias.len() * HEADS * LANES;
        let width = hidden + 2 * HEADS;
        let count = channels.len() / hidden;
        let projected = |node: usize| projected[node * width..][..width].split_at(hidden);
        let mut powers = [[[0.0; HEADS]; NEIGHBORS]; NODES];
        for (first, channels) in (0..).step_by(NODES).zip(channels.chunks_mut(NODES * hidden)) {
            // Several nodes at a time, since the operations of one node depend on each other.
            let nodes = (first..count).zip(&mut powers);
            for (node, powers) in nodes {
                let target = of_heads(&projected(node).1[HEADS..]);
                let edges = edges.of(node).iter();
                let sources =
                    edges.map(|edge| (of_heads(projected(edge.node as usize).1), edge.inverse_distance));
                *powers = self.scores(target, sources);
            }
            for power in powers.as_flattened_mut().as_flattened_mut() {
                *power = exp(*power);
            }
            for ((node, powers), channels) in (first..).zip(&powers).zip(channels.chunks_exact_mut(hidden)) {
                let edges = edges.of(node);
                let mut share = [0.0; HEADS];
                for (powers, _) in powers.iter().zip(edges) {
                    for head in 0..HEADS {
                        share[head] += powers[head];
                    }
                }
                // The highest power is 1, if there is a neighbor.
                for share in &mut share {
                    *share = 1.0 / greater(*share, 1.0);
                }
                for (group, bias) in self.bias.iter().enumerate() {
                    let brought = edges.iter().map(|edge| &values(projected(edge.node as usize).0)[group]);
                    let added = (group * LANES..).step_by(hidden / HEADS);
                    for lane in (0..LANES).step_by(S::F32_LANES) {
                        let sums = weigh(simd, powers, share, brought.clone(), lane);
                        for ((first, bias), sum) in added.clone().zip(bias).zip(sums) {
                            let sum = rectify(simd, simd.add_f32s(sum, load::<S>(&bias[lane..])));
                            let channels = &mut channels[first + lane..];
                            store::<S>(channels, simd.add_f32s(load::<S>(channels), sum));
                        }
                    }
                }
            }
        }
    }

    /// The exponents of the softmax: scores, less the highest of each head so that no power is too large.
    #[inline(always)]
    fn scores<const NEIGHBORS: usize>(
        &self,
        target: [f32; HEADS],
        sources: impl Iterator<Item = ([f32; HEADS], f32)>,
    ) -> Scores<NEIGHBORS> {
        let edge = self.edge;
        let mut scores = [[0.0; HEADS]; NEIGHBORS];
        let mut most = [f32::MIN; HEADS];
        for (scores, (source, inverse_distance)) in scores.iter_mut().zip(sources) {
            let mut of_edge = [0.0; HEADS];
            for head in 0..HEADS {
                let score = source[head] + target[head] + edge[head] * inverse_distance;
                of_edge[head] = leaky(score, SCORE_LEAK);
                most[head] = greater(most[head], of_edge[head]);
            }
            *scores = of_edge;
        }
        for scores in &mut scores {
            for head in 0..HEADS {
                scores[head] -= most[head];
            }
        }
        scores
    }
}

/// The weighted mean of the edges' values in some lanes of each head.
#[inline(always)]
fn weigh<'a, S: Simd, const NEIGHBORS: usize>(
    simd: S,
    powers: &Scores<NEIGHBORS>,
    share: [f32; HEADS],
    brought: impl Iterator<Item = &'a Values>,
    lane: usize,
) -> [S::f32s; HEADS] {
    let mut sums = [simd.splat_f32s(0.0); HEADS];
    for (powers, values) in powers.iter().zip(brought) {
        for head in 0..HEADS {
            let power = simd.splat_f32s(powers[head]);
            sums[head] = simd.mul_add_f32s(power, load::<S>(&values[head][lane..]), sums[head]);
        }
    }
    for head in 0..HEADS {
        sums[head] = simd.mul_f32s(sums[head], simd.splat_f32s(share[head]));
    }
    sums
}

/// The channels of a row.
#[inline(always)]
fn values(row: &[f32]) -> &[Values] {
    row.as_chunks::<LANES>().0.as_chunks::<HEADS>().0
}

#[inline(always)]
fn of_heads(values: &[f32]) -> [f32; HEADS] {
    let mut heads = [0.0; HEADS];
    heads.copy_from_slice(&values[..HEADS]);
    heads
}
