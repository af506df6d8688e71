//! Demonstrations as graphs with training targets.

use std::sync::Arc;

use dragnet_files::FileError;
use dragnet_learn::demonstration::{Demonstration, Folder, Source, Trajectory};
use dragnet_learn::graph::{FEATURES, Graph, Topology};
use dragnet_search::route::ShortestPathTree;

/// All demonstrations of a folder, divided into training and validation.
#[derive(Debug)]
pub struct Data {
    pub(super) learned: Vec<Sample>,
    pub(super) held_out: Vec<Sample>,
    source: Source,
    scenarios: Vec<String>,
}

/// One decision of the expert.
#[derive(Debug)]
pub(super) struct Sample {
    pub(super) graph: Graph,
    /// The node that the expert chose.
    pub(super) chosen: u32,
    /// The training target as a distribution, shape `[nodes]`.
    pub(super) wished: Vec<f32>,
    /// The expert's score over its best, where scores are above 0: shape `[nodes]`, or empty.
    pub(super) share_of_best: Vec<f32>,
}

/// Why training data cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// A file or folder is invalid.
    #[error(transparent)]
    File(#[from] FileError),
    /// No file has a decision.
    #[error("{0}: no decision to learn from")]
    Nothing(String),
    /// Too few trajectories for validation.
    #[error("{0}: one trajectory only; at least 2 are needed, so that one can be held out")]
    TooFew(String),
    /// Not enough memory.
    #[error(
        "{folder}: {needed_mib} MiB of memory are needed and {free_mib} MiB are free: take fewer files or smaller maps"
    )]
    Memory {
        /// The demonstrations.
        folder: String,
        /// Estimated.
        needed_mib: u64,
        /// Available.
        free_mib: u64,
    },
}

impl Data {
    /// Reads a folder. Every `held_out_every`-th trajectory is used for validation, as a whole, since its decisions are
    /// similar. `target_exponent` is the power of the expert's scores by which the training target is spread over
    /// cells.
    ///
    /// # Errors
    /// If a file cannot be read, is of another expert, or there are too few or too many decisions.
    pub fn load(folder: &Folder, held_out_every: usize, target_exponent: f64) -> Result<Self, DataError> {
        let name = folder.path().display().to_string();
        if folder.len() < 2 {
            return Err(DataError::TooFew(name));
        }
        let (mut learned, mut held_out) = (Vec::new(), Vec::new());
        let (mut source, mut scenarios) = (None, Vec::new());
        let mut topology = None;
        let mut budget = Budget::new();
        for (place, trajectory) in folder.trajectories().enumerate() {
            let trajectory = trajectory?;
            budget.take(&trajectory).map_err(|(needed_mib, free_mib)| DataError::Memory {
                folder: name.clone(),
                needed_mib,
                free_mib,
            })?;
            let is_held_out = place % held_out_every == held_out_every - 1
                || place + 1 == folder.len() && held_out.is_empty();
            let samples = if is_held_out { &mut held_out } else { &mut learned };
            samples.extend(
                trajectory
                    .decisions
                    .iter()
                    .filter_map(|decision| sample(&trajectory, decision, target_exponent, &mut topology)),
            );
            if !scenarios.contains(&trajectory.scenario) {
                scenarios.push(trajectory.scenario.clone());
            }
            source.get_or_insert(trajectory.source);
        }
        match source {
            Some(source) if !learned.is_empty() && !held_out.is_empty() => {
                Ok(Self { learned, held_out, source, scenarios })
            }
            _ => Err(DataError::Nothing(name)),
        }
    }

    /// The expert and its settings.
    #[must_use]
    pub const fn source(&self) -> &Source {
        &self.source
    }

    /// Names of the scenarios, without repetition.
    #[must_use]
    pub fn scenarios(&self) -> &[String] {
        &self.scenarios
    }

    /// Number of training decisions.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.learned.len()
    }

    /// Always false.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.learned.is_empty()
    }

    /// Number of validation decisions.
    #[must_use]
    pub const fn held_out_len(&self) -> usize {
        self.held_out.len()
    }
}

/// `None` for a decision without a choice. `topology` is that of the sample before: trajectories on one map share one.
fn sample(
    trajectory: &Trajectory,
    decision: &Demonstration,
    target_exponent: f64,
    topology: &mut Option<Arc<Topology>>,
) -> Option<Sample> {
    let belief = trajectory.belief(decision)?;
    let situation = trajectory.situation(decision, &belief);
    let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
    if routes.parent(decision.chosen) == decision.chosen {
        return None;
    }
    let graph = Graph::new(&situation, &routes, topology);
    let chosen = graph.topology.node(decision.chosen);
    let scores = graph.topology.cells().iter().map(|cell| decision.scores[cell.index()]);
    let best = decision.scores[decision.chosen.index()];
    let share_of_best: Vec<f32> = if best > 0.0 && best.is_finite() {
        scores.map(|score| (score / best).max(0.0)).collect()
    } else {
        Vec::new()
    };
    let wished = wishes(&share_of_best, chosen, graph.topology.len(), target_exponent);
    Some(Sample { graph, chosen, wished, share_of_best })
}

/// `share^target_exponent`, normalized; the choice alone if no score is above 0.
#[expect(clippy::cast_possible_truncation, reason = "learned from as f32")]
fn wishes(share_of_best: &[f32], chosen: u32, nodes: usize, target_exponent: f64) -> Vec<f32> {
    if share_of_best.is_empty() {
        let mut wished = vec![0.0; nodes];
        wished[chosen as usize] = 1.0;
        return wished;
    }
    let powers: Vec<f64> =
        share_of_best.iter().map(|&share| f64::from(share).powf(target_exponent)).collect();
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|power| (power / sum) as f32).collect()
}

/// Memory that samples may take.
struct Budget {
    free_bytes: Option<u64>,
    taken_bytes: u64,
}

impl Budget {
    /// The available memory by the kernel; `None` where it is unknown.
    fn new() -> Self {
        let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        Self { free_bytes: kib.map(|kib| kib * 1024), taken_bytes: 0 }
    }

    /// Needed and free MiB, if a trajectory does not fit.
    fn take(&mut self, trajectory: &Trajectory) -> Result<(), (u64, u64)> {
        // Features, parent, order, target and shares of each node.
        let of_node = size_of::<f32>() * (FEATURES + 4);
        let cells = trajectory.terrain.grid().cell_count();
        self.taken_bytes += (trajectory.decisions.len() * cells * of_node) as u64;
        match self.free_bytes {
            Some(free) if self.taken_bytes > free => Err((self.taken_bytes >> 20, free >> 20)),
            _ => Ok(()),
        }
    }
}
