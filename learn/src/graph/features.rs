//! Features of each node. Every feature is of the order of 1, and none depends on position or direction.

use dragnet_search::belief::entropy_nats;
use dragnet_search::evidence::UNITS;
use dragnet_search::route::ShortestPathTree;
use dragnet_search::situation::Situation;

use super::topology::{NEIGHBORS, Topology};

/// Features of a node.
pub const FEATURES: usize = 10;

/// Names of the features, in order; weights carry these names, so that weights of another feature set are rejected.
pub const FEATURE_NAMES: [&str; FEATURES] = [
    // Of an object in the cell.
    "probability",
    // Clamped to 8 nats, over 8.
    "log_odds",
    // Over ln 2.
    "entropy",
    // Information gain of an observation from the cell, beyond teammates' plans, over the best cell's.
    "information_gain",
    // ln of that, from 0 at 1e-4 of the best to 1 at the best.
    "log_information_gain",
    // ln(1 + L) / 4, L the length of the path to the cell in cells.
    "log_path_length",
    // ln(1 + L / 5) / 3: the paper's weight of path length, as a logarithm.
    "log_path_weight",
    // 1 in the robot's own cell.
    "robot",
    // Share of the eight cells around that are traversable and in reach.
    "openness",
    // k / (k + 10), k the planned precision of teammates.
    "planned_precision",
];

/// Gains below this share of the best one count as none.
const LEAST_SHARE: f64 = 1e-4;

/// Features of all nodes, shape `[nodes, FEATURES]`. `gains` are those of an observation from each cell, `-inf` in the
/// root.
#[expect(clippy::cast_possible_truncation, reason = "features are f32")]
pub(super) fn of(
    situation: &Situation<'_>,
    routes: &ShortestPathTree,
    topology: &Topology,
    gains: &[f64],
) -> Vec<f32> {
    let best = gains.iter().copied().fold(0.0, f64::max);
    let mut features = Vec::with_capacity(topology.len() * FEATURES);
    for (node, &cell) in topology.cells().iter().enumerate() {
        let log_odds = situation.belief.log_odds_nats(cell);
        let share = if best > 0.0 { (gains[cell.index()] / best).max(0.0) } else { 0.0 };
        let length = f64::from(routes.length(cell));
        let planned_precision = situation.planned_precision.precision(cell) as f64 / UNITS;
        let of_node: [f64; FEATURES] = [
            1.0 / (1.0 + (-log_odds).exp()),
            log_odds.clamp(-8.0, 8.0) / 8.0,
            entropy_nats(log_odds) / std::f64::consts::LN_2,
            share,
            1.0 - (share + LEAST_SHARE).ln() / LEAST_SHARE.ln(),
            length.ln_1p() / 4.0,
            (length / 5.0).ln_1p() / 3.0,
            f64::from(u8::from(cell == routes.root())),
            topology.edges(node).len() as f64 / NEIGHBORS as f64,
            planned_precision / (planned_precision + 10.0),
        ];
        features.extend(of_node.map(|feature| feature as f32));
    }
    features
}
