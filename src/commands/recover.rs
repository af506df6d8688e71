//! `dragnet recover`: mends a recording.

use std::path::PathBuf;

use dragnet_coordinator::{RecordingError, recover};

use super::Failure;
use crate::terminal;

/// Repair a recording that was cut off or damaged.
///
/// As by a crash or a full disk. All that is whole, also behind what is damaged, is copied to a new file, which ends as it should. The old one stays as it is.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet recover cut_off.mcap mended.mcap")]
pub(crate) struct Arguments {
    /// The recording that was cut off or damaged
    file: PathBuf,
    /// The new file; it must not exist
    out: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let recovered = recover::recover(&arguments.file, &arguments.out).map_err(|error| match error {
        RecordingError::Write { .. } => Failure::run(error),
        _ => Failure::input(error),
    })?;
    Ok(terminal::print(&format!("{}: {recovered}\n", arguments.out.display()))?)
}
