//! An expert's decisions with their situations: one file for each trajectory, so that shards can share a folder and
//! existing files count as done.
//!
//! A file is safetensors, which Python reads as arrays. It holds the situations themselves, not features of them, so
//! that a different network can be trained on the same files. A file appears under its name only when it is complete.

mod file;
mod folder;
mod record;

use std::fmt;
use std::sync::Arc;

use dragnet_search::belief::Belief;
use dragnet_search::cell::Cell;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::route::Connectivity;
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::Terrain;
use serde::{Deserialize, Serialize};

pub use file::{read, write};
pub use folder::{Folder, file_name};
pub use record::Recorder;

/// Properties that all files of one folder share: the expert, and how it was recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// The expert: a policy's name.
    pub expert: String,
    /// `w_l` of its path-length weight (Eq. 4), if it has one.
    pub path_length_weight: f64,
    /// Maximum number of decisions of a trajectory.
    pub max_decisions: u32,
    /// Share of the decisions after which the robot went to a random cell instead of the expert's, 0 to 1.
    pub explore: f64,
    /// Version and commit of the program.
    pub program: String,
    /// Digest of the network that robots followed instead of the expert.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follow: Option<String>,
    /// If the expert scores only cells with a path shorter than this, cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scored_within_cells: Option<f32>,
}

impl Source {
    /// Whether both have the same expert; the program's version may differ.
    #[must_use]
    pub fn is_same_expert(&self, other: &Self) -> bool {
        self.expert == other.expert && self.path_length_weight.to_bits() == other.path_length_weight.to_bits()
    }
}

impl fmt::Display for Source {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} (length weight {})", self.expert, self.path_length_weight)
    }
}

/// One search by an expert.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// The expert.
    pub source: Source,
    /// The scenario's name.
    pub scenario: String,
    /// Digest of the scenario except its seed: distinguishes two scenarios of one name.
    pub scenario_digest: String,
    /// Its seed.
    pub seed: u64,
    /// The map.
    pub terrain: Arc<Terrain>,
    /// The robot's moves.
    pub connectivity: Connectivity,
    /// The robot's sensor.
    pub sensor: Arc<Sensor>,
    /// The expert's decisions, in order.
    pub decisions: Vec<Demonstration>,
}

/// One decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Demonstration {
    /// `ln(p / (1 - p))`, shape `[cells]`.
    pub log_odds_nats: Vec<f32>,
    /// Precision planned by teammates, units of evidence, shape `[cells]`.
    pub planned_precision: PlannedPrecision,
    /// The robot's cell.
    pub robot: Cell,
    /// The expert's choice.
    pub chosen: Cell,
    /// The expert's scores, shape `[cells]`; `-inf` for cells that are not candidates.
    pub scores: Vec<f32>,
}

impl Trajectory {
    /// The situation of a decision. `belief` is the result of [`Trajectory::belief`].
    #[must_use]
    pub fn situation<'a>(&'a self, decision: &'a Demonstration, belief: &'a Belief) -> Situation<'a> {
        Situation {
            connectivity: self.connectivity,
            ..Situation::alone(
                &self.terrain,
                &self.sensor,
                belief,
                &decision.planned_precision,
                decision.robot,
            )
        }
    }

    /// The belief at a decision; `None` if the log-odds contain a NaN or do not fit the map.
    #[must_use]
    pub fn belief(&self, decision: &Demonstration) -> Option<Belief> {
        let log_odds = decision.log_odds_nats.iter().copied().map(f64::from).collect();
        Belief::from_log_odds(&self.terrain, log_odds).ok()
    }
}
