//! Sizes of a network, which determine the names and shapes of its parameters.

use serde::{Deserialize, Serialize};

use crate::graph::{FEATURES, PLANNING_FEATURES};

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
    /// Levels of coarser graphs above that of cells; 0 for a network that sees only as far as it has attention layers.
    #[serde(default, skip_serializing_if = "is_none")]
    pub levels: usize,
    /// Channels of a node of the coarser graphs: a multiple of 32, or 0 without levels.
    #[serde(default, skip_serializing_if = "is_none")]
    pub coarse_channels: usize,
    /// Attention layers of each level on the way up, and as many on the way down.
    #[serde(default, skip_serializing_if = "is_none")]
    pub coarse_layers: usize,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
const fn is_none(size: &usize) -> bool {
    *size == 0
}

impl Shape {
    /// The sizes of the built-in networks.
    pub const DEFAULT: Self = Self {
        hidden: 32,
        layers: 3,
        decay_channels: 16,
        sum_channels: 4,
        levels: 0,
        coarse_channels: 0,
        coarse_layers: 0,
    };

    /// The sizes of the built-in network that imitates `tour`.
    pub const PLANNING: Self =
        Self { layers: 2, levels: 3, coarse_channels: 64, coarse_layers: 2, ..Self::DEFAULT };

    /// The largest sizes that are accepted; larger ones are rejected before memory is allocated.
    const MOST: Self = Self {
        hidden: 1024,
        layers: 64,
        decay_channels: 1024,
        sum_channels: 256,
        levels: 8,
        coarse_channels: 1024,
        coarse_layers: 64,
    };

    /// Number of features of a node: networks with levels get those of planning too.
    #[must_use]
    pub const fn features(self) -> usize {
        if self.levels > 0 { FEATURES + PLANNING_FEATURES } else { FEATURES }
    }

    /// Inputs of the last layers: mixed channels, logarithms of sums, features.
    #[must_use]
    pub const fn head_inputs(self) -> usize {
        self.hidden + self.sum_channels + self.features()
    }

    /// Whether all sizes are within the ranges of the fields, and all or none of those of levels are 0.
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
            && self.levels <= most.levels
            && self.coarse_channels <= most.coarse_channels
            && self.coarse_layers <= most.coarse_layers
            && self.coarse_channels.is_multiple_of(32)
            && (self.coarse_channels > 0) == (self.levels > 0)
            && (self.coarse_layers > 0) == (self.levels > 0)
    }

    /// Names of the attention layers of a level, from 1, before what is above it has been added.
    pub fn gathering(self, level: usize) -> impl Iterator<Item = String> {
        (0..self.coarse_layers).map(move |layer| format!("level.{level}.gather.{layer}"))
    }

    /// Names of those that come after; level 0 is that of cells, and nothing is above the coarsest.
    pub fn refining(self, level: usize) -> impl Iterator<Item = String> {
        let count = match level {
            0 => 1,
            _ if level < self.levels => self.coarse_layers,
            _ => 0,
        };
        (0..count).map(
            move |layer| {
                if level == 0 { "refine".to_owned() } else { format!("level.{level}.refine.{layer}") }
            },
        )
    }

    /// Name and shape of every parameter, in a fixed order. Matrices are `[outputs, inputs]`, as libtorch has them.
    #[must_use]
    pub fn parameters(self) -> Vec<Parameter> {
        let Self { hidden, layers, decay_channels, sum_channels, .. } = self;
        let mut list = List::default();
        list.linear("encoder", hidden, self.features());
        for layer in 0..layers {
            list.attention(&format!("attention.{layer}"), hidden);
        }
        if self.levels > 0 {
            list.levels(self);
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

    fn attention(&mut self, name: &str, width: usize) {
        self.linear(name, width, width);
        self.push(format!("{name}.source"), &[HEADS, width / HEADS]);
        self.push(format!("{name}.target"), &[HEADS, width / HEADS]);
        self.push(format!("{name}.edge"), &[HEADS]);
    }

    /// From cells to the coarsest level, and back.
    fn levels(&mut self, shape: Shape) {
        let Shape { hidden, levels, coarse_channels, .. } = shape;
        let width = |level: usize| if level == 0 { hidden } else { coarse_channels };
        for level in 1..=levels {
            self.linear(&format!("gather.{level}"), coarse_channels, width(level - 1) + 1);
            for name in shape.gathering(level) {
                self.attention(&name, coarse_channels);
            }
        }
        for level in (0..levels).rev() {
            self.linear(&format!("spread.{level}"), width(level), coarse_channels);
            for name in shape.refining(level) {
                self.attention(&name, width(level));
            }
        }
    }

    fn linear(&mut self, name: &str, outputs: usize, inputs: usize) {
        self.push(format!("{name}.weight"), &[outputs, inputs]);
        self.push(format!("{name}.bias"), &[outputs]);
    }
}
