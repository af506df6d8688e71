//! Demonstrations as graphs with training targets.

use dragnet_files::FileError;
use dragnet_learn::demonstration::{Demonstration, Folder, Source, Trajectory};
use dragnet_learn::graph::{Graph, Memory};
use dragnet_learn::shape::Shape;
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
    /// Whether the expert scored a node, which otherwise is no candidate: shape `[nodes]`.
    pub(super) is_scored: Vec<bool>,
    /// The expert's score over its best, where scores are above 0: shape `[nodes]`, or empty.
    pub(super) share_of_best: Vec<f32>,
}

/// How an expert's scores are spread over cells as a training target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// By this power of them, for scores whose ratios tell how good a choice is.
    Power(f64),
    /// By `exp` of them over this, for scores whose differences do, as those of `tour`, cells.
    Temperature(f64),
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
    /// similar. The samples are for a network of this shape.
    ///
    /// # Errors
    /// If a file cannot be read, is of another expert, or there are too few or too many decisions.
    pub fn load(
        folder: &Folder,
        held_out_every: usize,
        spread: Spread,
        shape: Shape,
    ) -> Result<Self, DataError> {
        let name = folder.path().display().to_string();
        if folder.len() < 2 {
            return Err(DataError::TooFew(name));
        }
        let (mut learned, mut held_out) = (Vec::new(), Vec::new());
        let (mut source, mut scenarios) = (None, Vec::new());
        let mut memory = Memory::default();
        let mut budget = Budget::new(shape);
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
                    .filter_map(|decision| sample(&trajectory, decision, (spread, shape), &mut memory)),
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

/// `None` for a decision without a choice. `memory` is that of the sample before: trajectories on one map share a topology.
fn sample(
    trajectory: &Trajectory,
    decision: &Demonstration,
    (spread, shape): (Spread, Shape),
    memory: &mut Memory,
) -> Option<Sample> {
    let belief = trajectory.belief(decision)?;
    let situation = trajectory.situation(decision, &belief);
    let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
    if routes.parent(decision.chosen) == decision.chosen {
        return None;
    }
    let graph = Graph::of_shape(shape, &situation, &routes, memory);
    let chosen = graph.topology.node(decision.chosen);
    let scores: Vec<f64> =
        graph.topology.cells().iter().map(|cell| decision.scores[cell.index()].into()).collect();
    // An expert that scores nothing but its choice leaves all cells as candidates.
    let finite_count = scores.iter().filter(|score| score.is_finite()).count();
    let is_scored = scores.iter().map(|score| finite_count < 2 || score.is_finite()).collect();
    let best = scores[chosen as usize];
    #[expect(clippy::cast_possible_truncation, reason = "a share")]
    let share_of_best: Vec<f32> = if best > 0.0 && best.is_finite() {
        scores.iter().map(|score| (score / best).max(0.0) as f32).collect()
    } else {
        Vec::new()
    };
    let wished = match spread {
        Spread::Power(power) => powers(&share_of_best, power),
        Spread::Temperature(cells) => scores.iter().map(|score| ((score - best) / cells).exp()).collect(),
    };
    let wished = normalized(wished, chosen, graph.topology.len());
    Some(Sample { graph, chosen, wished, is_scored, share_of_best })
}

fn powers(share_of_best: &[f32], power: f64) -> Vec<f64> {
    share_of_best.iter().map(|&share| f64::from(share).powf(power)).collect()
}

/// A distribution over nodes; the choice alone if there is none.
#[expect(clippy::cast_possible_truncation, reason = "learned from as f32")]
fn normalized(wished: Vec<f64>, chosen: u32, nodes: usize) -> Vec<f32> {
    let sum: f64 = wished.iter().sum();
    if wished.is_empty() || !(sum.is_finite() && sum > 0.0) {
        let mut wished = vec![0.0; nodes];
        wished[chosen as usize] = 1.0;
        return wished;
    }
    wished.into_iter().map(|wish| (wish / sum) as f32).collect()
}

/// Memory that samples may take.
struct Budget {
    free_bytes: Option<u64>,
    taken_bytes: u64,
    /// Numbers of a node.
    numbers: usize,
}

impl Budget {
    /// The available memory by the kernel; `None` where it is unknown.
    fn new(shape: Shape) -> Self {
        let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
        let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        // Features, parent, order, target, shares and candidates of each node, and a little for its part of the levels.
        let numbers = shape.features() + 5 + shape.levels;
        Self { free_bytes: kib.map(|kib| kib * 1024), taken_bytes: 0, numbers }
    }

    /// Needed and free MiB, if a trajectory does not fit.
    fn take(&mut self, trajectory: &Trajectory) -> Result<(), (u64, u64)> {
        let of_node = size_of::<f32>() * self.numbers;
        let cells = trajectory.terrain.grid().cell_count();
        self.taken_bytes += (trajectory.decisions.len() * cells * of_node) as u64;
        match self.free_bytes {
            Some(free) if self.taken_bytes > free => Err((self.taken_bytes >> 20, free >> 20)),
            _ => Ok(()),
        }
    }
}
