//! `dragnet agent`: one robot.

use std::path::PathBuf;

use dragnet_link::serve;

use super::{Failure, latency};

/// Run one robot of a team, in the field.
///
/// It decides where to go, tells the others over Zenoh what it saw, and hears them. It needs no coordinator, and goes on when the network does not.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet agent --config robot_1.toml")]
pub(crate) struct Arguments {
    /// What this robot is told before it starts (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    latency::warm_up();
    Ok(serve::agent(&arguments.config)?)
}
