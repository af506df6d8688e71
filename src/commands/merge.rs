//! `dragnet merge`: what shards made, joined.

use std::fs;
use std::path::{Path, PathBuf};

use dragnet_files::read_at_most;
use serde::Deserialize;

use super::comparison::part::{self, Joined};
use super::comparison::{Origin, Output};
use super::{Failure, demonstrate, shard};

/// Join the parts of a command that ran in shards.
///
/// Prints and writes what the command would have without shards. Every shard must be there exactly once, all of the same
/// experiment, run by the same version of this program.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet merge parts --out results
  dragnet merge part-1-of-2.json part-2-of-2.json")]
pub(crate) struct Arguments {
    /// Parts, or folders: all parts in them
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut files = Vec::new();
    for path in &arguments.parts {
        files.extend(part_files(path)?);
    }
    if are_demonstrations(&files) {
        return demonstrate::part::join(&files, arguments.output.out.as_deref());
    }
    let Joined { design, trials, parts } = part::join(&files)?;
    arguments.output.prepare()?;
    arguments.output.tell(&design, trials, Origin::Parts(parts))
}

/// Whether the first part is one of demonstrations; those that go with it are then as well, or are refused.
fn are_demonstrations(files: &[PathBuf]) -> bool {
    #[derive(Deserialize)]
    struct Stamp {
        format: String,
    }
    let text = files.first().and_then(|path| read_at_most(path, shard::MAX_PART_BYTES).ok());
    let stamp = text.and_then(|text| serde_json::from_slice::<Stamp>(&text).ok());
    stamp.is_some_and(|stamp| stamp.format == demonstrate::part::FORMAT)
}

/// The file itself, or all parts in a folder: at least one.
fn part_files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let failure = |what: String| Failure::Input(format!("{}: {what}", path.display()));
    let entries = fs::read_dir(path).map_err(|error| failure(error.to_string()))?;
    let files = entries.map(|entry| entry.map(|entry| entry.path()));
    let mut files = files.collect::<Result<Vec<_>, _>>().map_err(|error| failure(error.to_string()))?;
    files.retain(|file| shard::is_part(file));
    files.sort_unstable();
    if files.is_empty() {
        return Err(failure("no part in this folder; parts are named part-I-of-N".to_owned()));
    }
    Ok(files)
}
