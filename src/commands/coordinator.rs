//! `dragnet coordinator`: the mission seen from outside.

use std::path::PathBuf;

use dragnet_link::serve;

use super::Failure;
use crate::VERSION;

/// Watch and record a mission, in the field.
///
/// It declares what is found, says who is alive, and records all that it hears over Zenoh. Robots search on without it.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet coordinator --config coordinator.toml")]
pub(crate) struct Arguments {
    /// What to watch and where to record it (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    Ok(serve::coordinator(&arguments.config, VERSION)?)
}
