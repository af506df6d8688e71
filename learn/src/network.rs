//! Inference in plain Rust: from a graph to a logit for each node.
//!
//! Attention is that of Veličković et al., "Graph Attention Networks" (ICLR 2018), Eq. 1 to 5, with heads concatenated.
//! Departures: the inverse distance of an edge enters its score, times a learned number a head (the paper weights edges
//! so, Section V-C); a node's own channels are added to the layer's output instead of counting as a neighbor;
//! rectifiers are leaky. After the attention layers comes a layer that the paper's network lacks, the route layer:
//! channels that decay along the shortest path from the robot, and channels that are summed along it, as Eq. 3 sums
//! information.
//!
//! Sums are computed in a fixed order with fused multiply-add on every machine (emulated, slowly, where the processor
//! has none), so that all machines compute the same bits.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into `Forward` is compiled for the least of vector instructions"
)]

mod attention;
mod coarse;
mod exponential;
mod linear;
mod route;

use pulp::{Arch, Simd, WithSimd};

use crate::graph::{Graph, NEIGHBORS};
use crate::shape::Shape;
use crate::weights::Weights;

use attention::Attention;
use coarse::{Coarse, CoarseWorkspace};
use linear::Linear;
use route::Decay;

/// Slope of a rectifier below 0; libtorch's default.
pub const RECTIFIER_LEAK: f32 = 0.01;
/// Slope of a score's rectifier below 0, as in Veličković et al.
pub const SCORE_LEAK: f32 = 0.2;
/// Added to a sum before its logarithm is taken.
pub const LEAST_SUM: f32 = 1e-6;
/// Sums are of `exp(x)`, with `x` clamped to this range.
pub const SUM_LOG_RANGE: (f32, f32) = (-12.0, 6.0);
/// Factor from the last layer's output to logits: an expert's choice is nearly certain, which small weights learn
/// slowly.
pub const LOGIT_SCALE: f32 = 10.0;

/// A network, ready for inference.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    shape: Shape,
    encoder: Linear,
    attention: Vec<Attention>,
    coarse: Option<Coarse>,
    refine: Vec<Attention>,
    within_cells: f32,
    decay: Option<(Linear, Decay)>,
    mix: Linear,
    sum: Option<Linear>,
    head: Linear,
    logit: Linear,
}

/// Buffers of a network: channels of all nodes.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    channels: Vec<f32>,
    coarse: CoarseWorkspace,
    projected: Vec<f32>,
    faded: Vec<f32>,
    mixed: Vec<f32>,
    sums: Vec<f32>,
    head: Vec<f32>,
    logits: Vec<f32>,
}

impl Network {
    /// Builds a network with these weights.
    #[must_use]
    pub fn new(weights: &Weights) -> Self {
        let shape = weights.shape();
        let linear = |name: &str| linear(weights, name);
        Self {
            shape,
            encoder: linear("encoder"),
            attention: (0..shape.layers)
                .map(|layer| Attention::new(weights, &format!("attention.{layer}")))
                .collect(),
            coarse: (shape.levels > 0).then(|| Coarse::new(weights)),
            refine: if shape.levels > 0 { attentions(weights, shape.refining(0)) } else { Vec::new() },
            within_cells: weights.recipe().within_cells.unwrap_or(f32::INFINITY),
            decay: (shape.decay_channels > 0)
                .then(|| (linear("decay"), Decay::new(weights.get("decay.factor")))),
            mix: linear("mix"),
            sum: (shape.sum_channels > 0).then(|| linear("sum")),
            head: linear("head"),
            logit: linear("logit"),
        }
    }

    /// Sizes of the network.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// The network chooses among cells with a shorter path, cells.
    #[must_use]
    pub const fn within_cells(&self) -> f32 {
        self.within_cells
    }

    /// A logit for each node, shape `[nodes]`. That of the root has no meaning, since the robot is there.
    #[must_use]
    pub fn logits(&self, graph: &Graph) -> Vec<f32> {
        let mut workspace = Workspace::default();
        self.logits_in(graph, &mut workspace);
        workspace.logits
    }

    /// Like [`Network::logits`], with buffers that are reused from one graph to the next: allocating them takes a fifth
    /// of the time.
    pub fn logits_in<'a>(&self, graph: &Graph, workspace: &'a mut Workspace) -> &'a [f32] {
        // The widest vector instructions that this machine has; the order of operations is the same for all.
        Arch::new().dispatch(Forward { network: self, graph, workspace });
        &workspace.logits
    }

    /// What the last two layers had of a node in the last pass, which was on this graph: shape `[Shape::head_inputs]`.
    pub(crate) fn head_inputs<'a>(
        &self,
        graph: &'a Graph,
        workspace: &'a Workspace,
        node: usize,
    ) -> impl Iterator<Item = f32> + 'a {
        let Shape { hidden, sum_channels, .. } = self.shape;
        let of_node = |values: &'a [f32], width: usize| values[node * width..][..width].iter().copied();
        of_node(&workspace.mixed, hidden)
            .chain(of_node(&workspace.sums, sum_channels))
            .chain(of_node(&graph.features, self.shape.features()))
    }

    #[inline(always)]
    fn compute<S: Simd>(&self, simd: S, graph: &Graph, workspace: &mut Workspace) {
        let features = graph.features.as_slice();
        let Workspace { channels, coarse, projected, faded, mixed, sums, head, logits } = workspace;
        let edges = graph.topology.edge_lists();
        self.encoder.apply_rectified(simd, &[features], channels);
        for layer in &self.attention {
            layer.add_to::<S, NEIGHBORS>(simd, channels, edges, projected);
        }
        if let Some(levels) = &self.coarse {
            levels.add_to(simd, channels, &graph.levels, coarse);
        }
        for layer in &self.refine {
            layer.add_to::<S, NEIGHBORS>(simd, channels, edges, projected);
        }
        faded.clear();
        if let Some((linear, decay)) = &self.decay {
            linear.apply_rectified(simd, &[channels], faded);
            decay.carry(faded, graph);
        }
        self.mix.apply_rectified(simd, &[channels, faded], mixed);
        sums.clear();
        if let Some(sum) = &self.sum {
            sum.apply(simd, &[mixed], sums);
            route::log_sums(sums, graph);
        }
        self.head.apply_rectified(simd, &[mixed, sums, features], head);
        self.logit.apply(simd, &[head, mixed, sums, features], logits);
        for logit in logits {
            *logit *= LOGIT_SCALE;
        }
    }
}

fn linear(weights: &Weights, name: &str) -> Linear {
    Linear::new(weights.get(&format!("{name}.weight")), weights.get(&format!("{name}.bias")))
}

fn attentions(weights: &Weights, names: impl Iterator<Item = String>) -> Vec<Attention> {
    names.map(|name| Attention::new(weights, &name)).collect()
}

/// A pass through the network, which [`Arch`] compiles once for each set of vector instructions. All functions that it
/// calls are inlined; others would be compiled for the smallest set.
struct Forward<'a> {
    network: &'a Network,
    graph: &'a Graph,
    workspace: &'a mut Workspace,
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.network.compute(simd, self.graph, self.workspace);
    }
}

/// `x` above 0, `leak * x` below; `leak` is below 1.
#[inline(always)]
fn leaky(value: f32, leak: f32) -> f32 {
    greater(value, leak * value)
}

/// Of two numbers that are not NaN: one instruction, as [`f32::max`] is not.
#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
