//! `dragnet inspect`: what a recording holds.

use std::path::PathBuf;

use dragnet_coordinator::inspect;

use super::Failure;
use crate::terminal;

/// Summarize a recording.
///
/// When, who, which topics, and what was found. Of a recording that was cut off or is damaged all that is whole is read; `dragnet recover` makes a complete one of it.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet inspect ice_cream_cone-0.mcap")]
pub(crate) struct Arguments {
    /// A recording (MCAP)
    file: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let inspection = inspect::inspect(&arguments.file).map_err(Failure::input)?;
    Ok(terminal::print(&format!("{inspection}\n"))?)
}
