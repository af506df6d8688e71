//! `dragnet recover`: repairs a recording.

use std::path::PathBuf;

use dragnet_coordinator::{RecordingError, recover};

use super::Failure;
use crate::terminal;

/// Repair a recording that a crash or a full disk has truncated or damaged.
///
/// All intact parts, including those behind damage, are copied to a new, complete file. The old file is not changed.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet recover cut_off.mcap mended.mcap")]
pub(crate) struct Arguments {
    /// The truncated or damaged recording (MCAP)
    file: PathBuf,
    /// The new recording; the file must not exist
    out: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let recovered = recover::recover(&arguments.file, &arguments.out).map_err(|error| match error {
        RecordingError::Write { .. } => Failure::run(error),
        _ => Failure::input(error),
    })?;
    Ok(terminal::print(&format!("{}: {recovered}\n", arguments.out.display()))?)
}
