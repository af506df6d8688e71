//! The coarser graphs: channels of cells are gathered in larger and larger pieces of the map, and spread again.

use pulp::Simd;

use crate::graph::{COARSE_NEIGHBORS, Level};
use crate::weights::Weights;

use super::attention::Attention;
use super::linear::Linear;
use super::{attentions, linear};

/// `h_p = rectifier(G [mean of the parts' h, size of p])`, then attention layers; on the way back
/// `h_part += rectifier(U h_p)`, then attention layers again.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coarse {
    /// Of each level, the finest first.
    gather: Vec<(Linear, Vec<Attention>)>,
    /// From each level to the one below, with the layers of that; those of the cells are left to the caller.
    spread: Vec<(Linear, Vec<Attention>)>,
}

/// Buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct CoarseWorkspace {
    channels: Vec<Vec<f32>>,
    mean: Vec<f32>,
    projected: Vec<f32>,
    spread: Vec<f32>,
}

impl Coarse {
    pub(super) fn new(weights: &Weights) -> Self {
        let shape = weights.shape();
        let gather = (1..=shape.levels).map(|level| {
            (linear(weights, &format!("gather.{level}")), attentions(weights, shape.gathering(level)))
        });
        let spread = (0..shape.levels).map(|level| {
            let layers = if level == 0 { Vec::new() } else { attentions(weights, shape.refining(level)) };
            (linear(weights, &format!("spread.{level}")), layers)
        });
        Self { gather: gather.collect(), spread: spread.collect() }
    }

    /// Adds what the levels bring to the channels of the cells.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(
        &self,
        simd: S,
        cells: &mut [f32],
        levels: &[Level],
        workspace: &mut CoarseWorkspace,
    ) {
        let CoarseWorkspace { channels, mean, projected, spread } = workspace;
        channels.resize_with(levels.len(), Vec::new);
        for (number, (level, (linear, layers))) in levels.iter().zip(&self.gather).enumerate() {
            let (below, above) = channels.split_at_mut(number);
            mean_of_parts(below.last().map_or(&*cells, Vec::as_slice), level, mean);
            linear.apply_rectified(simd, &[mean, &level.size], &mut above[0]);
            for layer in layers {
                layer.add_to::<S, COARSE_NEIGHBORS>(simd, &mut above[0], &level.edges, projected);
            }
        }
        for (number, (level, (linear, layers))) in levels.iter().zip(&self.spread).enumerate().rev() {
            let (below, above) = channels.split_at_mut(number);
            linear.apply_rectified(simd, &[&above[0]], spread);
            let (Some(below), Some(under)) = (below.last_mut(), number.checked_sub(1)) else {
                add_to_parts(cells, level, spread);
                continue;
            };
            add_to_parts(below, level, spread);
            for layer in layers {
                layer.add_to::<S, COARSE_NEIGHBORS>(simd, below, &levels[under].edges, projected);
            }
        }
    }
}

/// Shape `[nodes of the level, width]`.
#[inline(always)]
fn mean_of_parts(parts: &[f32], level: &Level, mean: &mut Vec<f32>) {
    let width = parts.len() / level.piece.len();
    mean.clear();
    mean.resize(level.len() * width, 0.0);
    let mut counts = vec![0.0_f32; level.len()];
    for (part, &piece) in parts.chunks_exact(width).zip(&level.piece) {
        counts[piece as usize] += 1.0;
        for (sum, value) in mean[piece as usize * width..][..width].iter_mut().zip(part) {
            *sum += value;
        }
    }
    for (sums, count) in mean.chunks_exact_mut(width).zip(counts) {
        for sum in sums {
            *sum /= count;
        }
    }
}

#[inline(always)]
fn add_to_parts(parts: &mut [f32], level: &Level, spread: &[f32]) {
    let width = parts.len() / level.piece.len();
    for (part, &piece) in parts.chunks_exact_mut(width).zip(&level.piece) {
        for (value, added) in part.iter_mut().zip(&spread[piece as usize * width..][..width]) {
            *value += added;
        }
    }
}
