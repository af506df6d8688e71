//! What a shard of demonstrations says of itself, and how shards are joined.

use std::path::{Path, PathBuf};

use dragnet_files::read_at_most;
use dragnet_learn::demonstration::{self, Source};
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::commands::shard::{self, Shard};
use crate::commands::{Failure, output};
use crate::terminal::{self, counted};

/// Format and version; no other is read.
pub(in crate::commands) const FORMAT: &str = "dragnet demonstration part 1";

/// A shard that is done. The trajectories lie beside it.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Part {
    format: String,
    source: Source,
    shard: Shard,
    /// Of this shard.
    decisions: u64,
    /// Files of all shards together, in order; [`Shard::holds`] says which are this one's.
    files: Vec<String>,
}

impl Part {
    pub(super) fn new(plan: &Plan, shard: Shard, decisions: u64) -> Self {
        let files = plan.jobs.iter().map(|job| demonstration::file_name(&job.name, job.seed));
        Self {
            format: FORMAT.to_owned(),
            source: plan.source.clone(),
            shard,
            decisions,
            files: files.collect(),
        }
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        let bytes = serde_json::to_vec(self).map_err(Failure::run)?;
        output::write(&folder.join(self.shard.file_name("json")), &bytes)
    }

    fn read(path: &Path) -> Result<Self, Failure> {
        let wrong = |what: String| Failure::Input(format!("{}: {what}", path.display()));
        let bytes = read_at_most(path, shard::MAX_PART_BYTES).map_err(|error| wrong(error.to_string()))?;
        serde_json::from_slice(&bytes).map_err(|error| wrong(format!("no part of demonstrations: {error}")))
    }
}

/// Checks that all shards are there with all their trajectories, and copies those that lie elsewhere to `out`.
pub(in crate::commands) fn join(paths: &[PathBuf], out: Option<&Path>) -> Result<(), Failure> {
    let parts =
        paths.iter().map(|path| Ok((path, Part::read(path)?))).collect::<Result<Vec<_>, Failure>>()?;
    let Some((first_path, first)) = parts.first() else { return Ok(()) };
    for (path, part) in &parts {
        if part.source != first.source || part.files != first.files {
            let (path, first) = (path.display(), first_path.display());
            return Err(Failure::Input(format!("{path}: not of the same demonstrations as {first}")));
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
    let decisions: u64 = parts.iter().map(|(_, part)| part.decisions).sum();
    let place = out.unwrap_or_else(|| first_path.parent().unwrap_or(Path::new("")));
    Ok(terminal::print(&format!(
        "{} complete: {}, {decisions} decisions of {}; {copied} copied to {}\n",
        counted(parts.len(), "part"),
        counted(first.files.len(), "trajectory"),
        first.source.expert,
        place.display(),
    ))?)
}

/// Checks a trajectory, and copies it to `out` if it is not there. Returns whether it was copied.
fn gather(file: &Path, out: Option<&Path>) -> Result<bool, Failure> {
    let trajectory = demonstration::read(file).map_err(Failure::input)?;
    let (Some(out), Some(name)) = (out, file.file_name()) else { return Ok(false) };
    output::make_folder(out)?;
    let target = out.join(name);
    if target.exists() {
        return Ok(false);
    }
    demonstration::write(&target, &trajectory).map_err(Failure::run)?;
    Ok(true)
}
