//! `dragnet inspect`: summarizes a recording.

use std::path::PathBuf;

use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::{inspect, segment};

use super::{Failure, segments};
use crate::terminal;

/// Summarize a recording.
///
/// Prints its times, participants, topics and finds, and how thoroughly each area was searched. All intact parts of a truncated or damaged recording are read;
/// `dragnet recover` makes a complete recording of them.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet inspect ice_cream_cone-0.mcap")]
pub(crate) struct Arguments {
    /// The recording (MCAP)
    file: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let inspection = inspect::inspect(&arguments.file).map_err(Failure::input)?;
    // Of what is no mission, or has lost its start, there is nothing more to say.
    let searched = Playback::read(&arguments.file).map(|playback| segment::rows_of(&playback, None));
    let searched = searched.map_or_else(|_| String::new(), |rows| format!("\n{}", segments::table(&rows)));
    Ok(terminal::print(&format!("{inspection}\n{searched}"))?)
}
