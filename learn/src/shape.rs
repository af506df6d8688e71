//! Sizes of a network, which determine the names and shapes of its parameters.

use serde::{Deserialize, Serialize};

use crate::graph::FEATURES;

/// Number of attention heads per layer.
pub const HEADS: usize = 4;

/// Sizes of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// Channels of a node between layers: a multiple of 32 up to 1024, so that each head fills vector registers.
    pub hidden: usize,
    /// Number of attention layers, from 1 to 64.
    pub layers: usize,
    /// Channels that decay along the path, 0 to 1024: they carry information about the preceding cells.
    pub decay_channels: usize,
    /// Channels that are summed along the path, 0 to 256. Without `decay_channels` and `sum_channels` the network does
    /// not use paths.
    pub sum_channels: usize,
}

impl Shape {
    /// The sizes of the built-in networks.
    pub const DEFAULT: Self = Self { hidden: 32, layers: 3, decay_channels: 16, sum_channels: 4 };

    /// The largest sizes that are accepted; larger ones are rejected before memory is allocated.
    const MOST: Self = Self { hidden: 1024, layers: 64, decay_channels: 1024, sum_channels: 256 };

    /// Channels per head.
    #[must_use]
    pub const fn head_channels(self) -> usize {
        self.hidden / HEADS
    }

    /// Inputs of the last layers: mixed channels, logarithms of sums, features.
    #[must_use]
    pub const fn head_inputs(self) -> usize {
        self.hidden + self.sum_channels + FEATURES
    }

    /// Whether all sizes are within the ranges of the fields.
    #[must_use]
    pub const fn is_valid(self) -> bool {
        let most = Self::MOST;
        self.hidden >= 1
            && self.layers >= 1
            && self.hidden <= most.hidden
            && self.layers <= most.layers
            && self.decay_channels <= most.decay_channels
            && self.sum_channels <= most.sum_channels
            && self.hidden.is_multiple_of(32)
    }

    /// Name and shape of every parameter, in a fixed order. Matrices are `[outputs, inputs]`, as libtorch has them.
    #[must_use]
    pub fn parameters(self) -> Vec<Parameter> {
        let Self { hidden, layers, decay_channels, sum_channels } = self;
        let mut list = List::default();
        list.linear("encoder", hidden, FEATURES);
        for layer in 0..layers {
            let name = format!("attention.{layer}");
            list.linear(&name, hidden, hidden);
            list.push(format!("{name}.source"), &[HEADS, hidden / HEADS]);
            list.push(format!("{name}.target"), &[HEADS, hidden / HEADS]);
            list.push(format!("{name}.edge"), &[HEADS]);
        }
        if decay_channels > 0 {
            list.linear("decay", decay_channels, hidden);
            list.push("decay.factor".to_owned(), &[decay_channels]);
        }
        list.linear("mix", hidden, hidden + decay_channels);
        if sum_channels > 0 {
            list.linear("sum", sum_channels, hidden);
        }
        list.linear("head", hidden, self.head_inputs());
        list.linear("logit", 1, hidden + self.head_inputs());
        list.0
    }
}

/// A parameter: its name and shape.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name in a weights file.
    pub name: String,
    /// Its shape, row-major.
    pub shape: Vec<usize>,
}

#[derive(Default)]
struct List(Vec<Parameter>);

impl List {
    fn push(&mut self, name: String, shape: &[usize]) {
        self.0.push(Parameter { name, shape: shape.to_vec() });
    }

    fn linear(&mut self, name: &str, outputs: usize, inputs: usize) {
        self.push(format!("{name}.weight"), &[outputs, inputs]);
        self.push(format!("{name}.bias"), &[outputs]);
    }
}
