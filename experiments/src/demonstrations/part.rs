//! The description of a completed shard of demonstrations, and joining of shards.

use std::path::{Path, PathBuf};

use dragnet_files::read_at_most;
use dragnet_learn::demonstration::{self, Source};
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::shard::{self, Shard};
use crate::{ExperimentError, output};

/// Format and version; no other is read.
const FORMAT: &str = "dragnet demonstration part 1";

/// A completed shard. The trajectories are in the same folder.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    format: String,
    source: Source,
    shard: Shard,
    /// Of this shard.
    decisions: u64,
    /// Files of all shards together, in order; [`Shard::holds`] says which belong to this one.
    files: Vec<String>,
}

impl Part {
    /// The description of a recorded shard.
    #[must_use]
    pub fn new(plan: &Plan, shard: Shard, decisions: u64) -> Self {
        let files = plan.jobs.iter().map(|job| demonstration::file_name(&job.name, job.seed));
        Self {
            format: FORMAT.to_owned(),
            source: plan.source.clone(),
            shard,
            decisions,
            files: files.collect(),
        }
    }

    /// Writes the part to the folder of its trajectories.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ExperimentError> {
        let bytes = serde_json::to_vec(self).map_err(ExperimentError::run)?;
        output::write(&folder.join(self.shard.file_name("json")), &bytes)
    }

    fn read(path: &Path) -> Result<Self, ExperimentError> {
        let wrong = |what: String| ExperimentError::Input(format!("{}: {what}", path.display()));
        let bytes = read_at_most(path, shard::MAX_PART_BYTES).map_err(|error| wrong(error.to_string()))?;
        serde_json::from_slice(&bytes).map_err(|error| wrong(format!("no part of demonstrations: {error}")))
    }
}

/// All shards of demonstrations.
pub struct Joined {
    /// Name of the expert.
    pub expert: String,
    /// Number of parts.
    pub parts: usize,
    /// Number of trajectories in all parts.
    pub trajectories: usize,
    /// Decisions in all of them.
    pub decisions: u64,
    /// Number of copied trajectories.
    pub copied: usize,
    /// The folder of all of them, if they were copied; else that of the first part.
    pub folder: PathBuf,
}

/// Whether the first part is one of demonstrations; the others must be too.
#[must_use]
pub fn are_demonstrations(files: &[PathBuf]) -> bool {
    #[derive(Deserialize)]
    struct Stamp {
        format: String,
    }
    let text = files.first().and_then(|path| read_at_most(path, shard::MAX_PART_BYTES).ok());
    let stamp = text.and_then(|text| serde_json::from_slice::<Stamp>(&text).ok());
    stamp.is_some_and(|stamp| stamp.format == FORMAT)
}

/// Checks that all shards are present with all their trajectories, and copies those in other folders to `out`.
///
/// # Errors
/// If one is not a part, they are of different commands, a shard is missing or repeated, or a trajectory is missing or
/// cannot be copied.
pub fn join(paths: &[PathBuf], out: Option<&Path>) -> Result<Joined, ExperimentError> {
    let parts = paths
        .iter()
        .map(|path| Ok((path, Part::read(path)?)))
        .collect::<Result<Vec<_>, ExperimentError>>()?;
    let Some((first_path, first)) = parts.first() else {
        return Err(ExperimentError::Input("no parts to merge".to_owned()));
    };
    for (path, part) in &parts {
        if part.source != first.source || part.files != first.files {
            let (path, first) = (path.display(), first_path.display());
            return Err(ExperimentError::Input(format!("{path}: not of the same demonstrations as {first}")));
        }
    }
    let shards: Vec<(&Path, Shard)> = parts.iter().map(|(path, part)| (path.as_path(), part.shard)).collect();
    shard::check_complete(&shards)?;
    let mut copied = 0;
    for (path, part) in &parts {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mine = (0..).zip(&part.files).filter(|(place, _)| part.shard.holds(*place));
        for (_, name) in mine {
            copied += usize::from(gather(&folder.join(name), out)?);
        }
    }
    Ok(Joined {
        expert: first.source.expert.clone(),
        parts: parts.len(),
        trajectories: first.files.len(),
        decisions: parts.iter().map(|(_, part)| part.decisions).sum(),
        copied,
        folder: out.unwrap_or_else(|| first_path.parent().unwrap_or(Path::new(""))).to_owned(),
    })
}

/// Checks a trajectory, and copies it to `out` if it is not there. Returns whether it was copied.
fn gather(file: &Path, out: Option<&Path>) -> Result<bool, ExperimentError> {
    let trajectory = demonstration::read(file).map_err(ExperimentError::input)?;
    let (Some(out), Some(name)) = (out, file.file_name()) else { return Ok(false) };
    output::make_folder(out)?;
    let target = out.join(name);
    if target.exists() {
        return Ok(false);
    }
    demonstration::write(&target, &trajectory).map_err(ExperimentError::run)?;
    Ok(true)
}
