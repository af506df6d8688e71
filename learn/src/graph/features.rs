//! Features of each node. Every feature is of the order of 1, and none depends on position or direction.

use dragnet_search::belief::entropy_nats;
use dragnet_search::evidence::UNITS;
use dragnet_search::policy::Hidden;
use dragnet_search::route::{Connectivity, ShortestPathTree};
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

/// Features of a node that networks with levels get beside [`FEATURES`].
pub const PLANNING_FEATURES: usize = 9;

const PLANNING_FEATURE_NAMES: [&str; PLANNING_FEATURES] = [
    // What the cell hides, as `tour` counts it, over the most of all nodes.
    "hidden",
    // ln of that, nats, from 0 at 1e-6 to 1 at 1.
    "log_hidden",
    // What an observation from the cell takes from the sum of what all cells hide, over the best cell's.
    "hidden_gain",
    // ln of that, from 0 at 1e-4 of the best to 1 at the best.
    "log_hidden_gain",
    // 1 if the cell is suspected of an object that is not found.
    "suspected",
    // ln of the sum of what all cells hide, over 8.
    "log_total_hidden",
    // Length of the path to the cell, over 10 cells, at most 1.
    "near_path_length",
    // Radius of the sensor, over 10 cells.
    "sensor_radius",
    // 1 for a robot that moves to eight neighbors, 0 for one that moves to four.
    "diagonal_moves",
];

/// Log-odds from which a cell is suspected, nats.
const SUSPECTED_NATS: f64 = 1.0;
/// What a cell hides counts from this on in its logarithm.
const LEAST_HIDDEN: f32 = 1e-6;
const LEAST_TOTAL_HIDDEN: f32 = 1e-3;

/// Names of a network's features.
pub(crate) fn feature_names(count: usize) -> Vec<&'static str> {
    FEATURE_NAMES.into_iter().chain(PLANNING_FEATURE_NAMES).take(count).collect()
}

/// The features of [`of`] with those of planning behind them, shape `[nodes, FEATURES + PLANNING_FEATURES]`.
pub(super) fn with_planning(
    features: &[f32],
    situation: &Situation<'_>,
    routes: &ShortestPathTree,
    topology: &Topology,
    hidden: &Hidden,
) -> Vec<f32> {
    let most = |values: &[f32]| {
        let of_nodes = topology.cells().iter().map(|cell| values[cell.index()]);
        of_nodes.fold(0.0, f32::max).max(f32::MIN_POSITIVE)
    };
    let (most_hidden, most_gain) = (most(&hidden.mass), most(&hidden.gain));
    let total: f32 = hidden.mass.iter().sum();
    #[expect(clippy::cast_possible_truncation, reason = "features are f32")]
    let least_share = LEAST_SHARE as f32;
    let mut all = Vec::with_capacity(topology.len() * (FEATURES + PLANNING_FEATURES));
    for (of_node, &cell) in features.chunks_exact(FEATURES).zip(topology.cells()) {
        let mass = hidden.mass[cell.index()];
        let gain = (hidden.gain[cell.index()] / most_gain).max(0.0);
        let is_suspected = situation.belief.log_odds_nats(cell) >= SUSPECTED_NATS && mass > 0.0;
        all.extend_from_slice(of_node);
        all.extend([
            mass / most_hidden,
            1.0 - (mass + LEAST_HIDDEN).ln() / LEAST_HIDDEN.ln(),
            gain,
            1.0 - (gain + least_share).ln() / least_share.ln(),
            f32::from(u8::from(is_suspected)),
            (total + LEAST_TOTAL_HIDDEN).ln() / 8.0,
            (routes.length(cell) / 10.0).min(1.0),
            situation.sensor.radius() as f32 / 10.0,
            f32::from(u8::from(situation.connectivity == Connectivity::Eight)),
        ]);
    }
    all
}

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
