//! Recording of experts' decisions as files for training.
//!
//! A [`Plan`] lists the trajectories of all shards, [`record`] makes those of one of them, [`Part`] describes a
//! completed shard, and [`part::join`] checks that all are complete.

pub mod part;
mod plan;

use std::path::Path;
use std::sync::Arc;

use dragnet_learn::demonstration::{self, Recorder, Source, Trajectory};
use dragnet_learn::network::Network;
use dragnet_learn::policy::{self, Gnn, PolicyName};
use dragnet_learn::weights::Weights;
use dragnet_search::evidence::Digest;
use dragnet_search::policy::Parameters;
use dragnet_sim::demonstration::watch;

use crate::ExperimentError;
use crate::jobs::{self, Effort};
use crate::progress::Progress;
use crate::shard::Shard;
pub use part::Part;
use plan::{Job, Search};
pub use plan::{MIXTURE, Plan};

/// How an expert is recorded.
#[derive(Clone, Debug)]
pub struct Watch {
    /// The expert.
    pub expert: PolicyName,
    /// Maximum number of decisions of a trajectory, over all robots.
    pub max_decisions: u32,
    /// Share of the decisions after which a robot goes to a random cell, 0 to 1.
    pub explore: f64,
    /// The network that robots follow instead of the expert.
    pub follow: Option<Follow>,
}

/// A network to follow.
#[derive(Clone, Debug)]
pub struct Follow {
    /// The network.
    pub network: Arc<Network>,
    /// Digest of its weights.
    pub digest: String,
}

impl Watch {
    /// The description in trajectories, with the version of the program that made them.
    fn source(&self, program: &str) -> Source {
        Source {
            expert: self.expert.to_string(),
            path_length_weight: Parameters::default().path_length_weight,
            max_decisions: self.max_decisions,
            explore: self.explore,
            follow: self.follow.as_ref().map(|follow| follow.digest.clone()),
            scored_within_cells: policy::scored_within_cells(self.expert),
            program: program.to_owned(),
        }
    }
}

impl Follow {
    /// The network of a weights file.
    ///
    /// # Errors
    /// If the file is none.
    pub fn load(path: &Path) -> Result<Self, ExperimentError> {
        let weights = Weights::load(path).map_err(ExperimentError::input)?;
        let digest = digest(&weights).map_err(ExperimentError::Input)?;
        Ok(Self { network: Arc::new(Network::new(&weights)), digest })
    }
}

/// Digest of a network's weights.
///
/// # Errors
/// If they cannot be serialized.
pub fn digest(weights: &Weights) -> Result<String, String> {
    Ok(Digest(xxhash_rust::xxh3::xxh3_128(&weights.to_bytes()?)).to_string())
}

/// The result of recording a shard.
pub struct Recorded {
    /// Number of trajectories.
    pub trajectories: usize,
    /// Decisions in all of them.
    pub decisions: u64,
    /// Number of trajectories that existed already.
    pub were_there: usize,
    /// Time and threads.
    pub effort: Effort,
}

/// A completed trajectory.
struct Done {
    decisions: u64,
    was_there: bool,
}

/// Writes a shard's trajectories to a folder on this many threads, by default one for each core. Existing ones are
/// kept.
///
/// # Errors
/// If an existing one differs, a search fails, or a file cannot be written.
pub fn record(
    plan: &Plan,
    shard: Shard,
    threads: Option<u16>,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Recorded, ExperimentError> {
    let mine: Vec<&Job> =
        (0..).zip(&plan.jobs).filter(|(place, _)| shard.holds(*place)).map(|(_, job)| job).collect();
    let done = jobs::run(&mine, threads, "trajectories", progress, |job| watch_one(job, plan, folder))?;
    let trajectories = done.results;
    Ok(Recorded {
        trajectories: trajectories.len(),
        decisions: trajectories.iter().map(|trajectory| trajectory.decisions).sum(),
        were_there: trajectories.iter().filter(|trajectory| trajectory.was_there).count(),
        effort: done.effort,
    })
}

fn watch_one(job: &Job, plan: &Plan, folder: &Path) -> Result<Done, ExperimentError> {
    let path = folder.join(demonstration::file_name(&job.name, job.seed));
    let search = job.search(plan.expert)?;
    let Search { scenario, digest } = &*search;
    if path.exists() {
        let known = demonstration::read(&path).map_err(ExperimentError::input)?;
        check_is_same(&known, &plan.source, digest, &path)?;
        return Ok(Done { decisions: known.decisions.len() as u64, was_there: true });
    }
    let record = |explore, sink| {
        let recorder = Recorder::new(policy::expert(plan.expert, Parameters::default()), explore, sink);
        match &plan.follow {
            Some(follow) => recorder.following(Box::new(Gnn::new(Arc::clone(&follow.network)))),
            None => recorder,
        }
    };
    let (source, digest) = (plan.source.clone(), digest.clone());
    let trajectory = watch(scenario, job.seed, source, digest, record).map_err(ExperimentError::run)?;
    demonstration::write(&path, &trajectory).map_err(ExperimentError::run)?;
    Ok(Done { decisions: trajectory.decisions.len() as u64, was_there: false })
}

/// An existing file may only be kept if it equals what would be written now.
fn check_is_same(
    known: &Trajectory,
    source: &Source,
    digest: &str,
    path: &Path,
) -> Result<(), ExperimentError> {
    if known.source == *source && known.scenario_digest == digest {
        return Ok(());
    }
    Err(ExperimentError::Input(format!(
        "{}: there already, and made otherwise: {}; now it would be {}. Choose another --out, or remove it",
        path.display(),
        describe(&known.source, &known.scenario_digest),
        describe(source, digest),
    )))
}

fn describe(source: &Source, digest: &str) -> String {
    let Source { expert, max_decisions, explore, program, follow, .. } = source;
    let follow = follow.as_deref().map_or_else(String::new, |follow| format!(" after the network {follow}"));
    format!(
        "{expert}{follow}, {max_decisions} decisions at most, exploring {explore}, scenario {digest}, by {program}"
    )
}
