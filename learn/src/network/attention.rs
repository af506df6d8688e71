//! One layer of graph attention.

use pulp::Simd;

use crate::graph::{NEIGHBORS, Topology};
use crate::shape::HEADS;
use crate::weights::Weights;

use super::exponential::exp;
use super::linear::{Linear, load, store};
use super::{RECTIFIER_LEAK, SCORE_LEAK, leaky};

/// `h_i += rectifier(sum_j a_ij W h_j + b)`, with
/// `a_ij = softmax_j(leaky(source . W h_j + target . W h_i + edge / distance_ij))` in each head.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Attention {
    /// `W`, and below it `source . W` and `target . W` of each head, so that one product yields all three.
    project: Linear,
    edge: [f32; HEADS],
    /// Shape `[hidden]`.
    bias: Vec<f32>,
}

type Scores = [[f32; HEADS]; NEIGHBORS];

impl Attention {
    pub(super) fn new(weights: &Weights, layer: usize) -> Self {
        let get = |name: &str| weights.get(&format!("attention.{layer}.{name}"));
        let (hidden, channels) = (weights.shape().hidden, weights.shape().head_channels());
        let weight = get("weight");
        let mut rows = weight.to_vec();
        for vector in [get("source"), get("target")] {
            for (head, vector) in vector.chunks_exact(channels).enumerate() {
                let of_head = &weight[head * channels * hidden..][..channels * hidden];
                let product = |input| -> f32 {
                    vector.iter().zip(of_head.chunks_exact(hidden)).map(|(a, row)| a * row[input]).sum()
                };
                rows.extend((0..hidden).map(product));
            }
        }
        Self {
            project: Linear::new(&rows, &vec![0.0; hidden + 2 * HEADS]),
            edge: of_heads(get("edge")),
            bias: get("bias").to_vec(),
        }
    }

    /// Adds the layer's output to the channels, shape `[nodes, hidden]`.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(&self, simd: S, channels: &mut [f32], topology: &Topology) {
        let hidden = self.bias.len();
        let width = hidden + 2 * HEADS;
        let projected = self.project.apply(simd, &[channels]);
        let head_channels = hidden / HEADS;
        let leak = simd.splat_f32s(RECTIFIER_LEAK);
        for (node, channels) in channels.chunks_exact_mut(hidden).enumerate() {
            let edges = topology.edges(node);
            let target = of_heads(&projected[node * width + hidden + HEADS..]);
            let mut attention: Scores = [[f32::NEG_INFINITY; HEADS]; NEIGHBORS];
            for (scores, edge) in attention.iter_mut().zip(edges) {
                let source = of_heads(&projected[edge.node as usize * width + hidden..]);
                for head in 0..HEADS {
                    let score = source[head] + target[head] + self.edge[head] * edge.inverse_distance;
                    scores[head] = leaky(score, SCORE_LEAK);
                }
            }
            softmax(&mut attention);
            let lanes = S::F32_LANES;
            for (first, bias) in (0..).step_by(lanes).zip(self.bias.chunks_exact(lanes)) {
                let mut sum = load::<S>(bias);
                for (attention, edge) in attention.iter().zip(edges) {
                    let attention = simd.splat_f32s(attention[first / head_channels]);
                    let values = &projected[edge.node as usize * width + first..][..lanes];
                    sum = simd.mul_add_f32s(attention, load::<S>(values), sum);
                }
                let sum = simd.max_f32s(sum, simd.mul_f32s(sum, leak));
                let channels = &mut channels[first..first + lanes];
                store::<S>(channels, simd.add_f32s(load::<S>(channels), sum));
            }
        }
    }
}

#[inline(always)]
fn of_heads(values: &[f32]) -> [f32; HEADS] {
    let mut heads = [0.0; HEADS];
    heads.copy_from_slice(&values[..HEADS]);
    heads
}

/// Over the neighbors, in each head; `-inf` where there is no neighbor.
#[inline(always)]
fn softmax(scores: &mut Scores) {
    let mut most = [f32::MIN; HEADS];
    for scores in scores.iter() {
        for head in 0..HEADS {
            most[head] = most[head].max(scores[head]);
        }
    }
    for scores in scores.iter_mut() {
        for head in 0..HEADS {
            scores[head] -= most[head];
        }
    }
    for score in scores.as_flattened_mut() {
        *score = exp(*score);
    }
    let mut sum = [0.0; HEADS];
    for scores in scores.iter() {
        for head in 0..HEADS {
            sum[head] += scores[head];
        }
    }
    let share = sum.map(|sum| 1.0 / sum);
    for scores in scores {
        for head in 0..HEADS {
            scores[head] *= share[head];
        }
    }
}
