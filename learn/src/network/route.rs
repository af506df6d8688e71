//! Channels along the shortest paths from the robot.

use crate::graph::Graph;

use super::exponential::{exp, ln};
use super::{LEAST_SUM, SUM_LOG_RANGE};

/// Channels that decay along the path: `r(child) = m(child) + factor * r(parent)`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Decay {
    /// Share that remains after one cell, `0..1`, shape `[decay_channels]`.
    factors: Vec<f32>,
}

impl Decay {
    /// From the logits of the shares.
    pub(super) fn new(logits: &[f32]) -> Self {
        Self { factors: logits.iter().map(|logit| 1.0 / (1.0 + (-logit).exp())).collect() }
    }

    /// In place, shape `[nodes, decay_channels]`.
    #[inline(always)]
    pub(super) fn carry(&self, channels: &mut [f32], graph: &Graph) {
        let width = self.factors.len();
        for &node in &graph.order[1..] {
            let parent = graph.parent[node as usize] as usize * width;
            let node = node as usize * width;
            for (channel, factor) in self.factors.iter().enumerate() {
                channels[node + channel] += factor * channels[parent + channel];
            }
        }
    }
}

/// `ln(S + LEAST_SUM)` of sums along the path, `S(child) = exp(x(child)) + S(parent)`, in place, shape `[nodes, sum_channels]`.
/// The root adds nothing, since the observation from the robot's own cell has already been made.
#[inline(always)]
pub(super) fn log_sums(values: &mut [f32], graph: &Graph) {
    let width = values.len() / graph.parent.len();
    for value in &mut *values {
        *value = exp(value.clamp(SUM_LOG_RANGE.0, SUM_LOG_RANGE.1));
    }
    values[graph.root as usize * width..][..width].fill(0.0);
    for &node in &graph.order[1..] {
        let parent = graph.parent[node as usize] as usize * width;
        let node = node as usize * width;
        for channel in 0..width {
            values[node + channel] += values[parent + channel];
        }
    }
    for value in values {
        *value = ln(*value + LEAST_SUM);
    }
}
