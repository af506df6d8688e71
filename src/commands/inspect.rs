//! `dragnet inspect`: summarizes a recording.

use std::path::PathBuf;

use dragnet_coordinator::inspect;

use super::Failure;
use crate::terminal;

/// Summarize a recording.
///
/// Prints its times, participants, topics and finds. All intact parts of a truncated or damaged recording are read;
/// `dragnet recover` makes a complete recording of them.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet inspect ice_cream_cone-0.mcap")]
pub(crate) struct Arguments {
    /// The recording (MCAP)
    file: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let inspection = inspect::inspect(&arguments.file).map_err(Failure::input)?;
    Ok(terminal::print(&format!("{inspection}\n"))?)
}
