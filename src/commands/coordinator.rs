//! `dragnet coordinator`: the mission seen from outside.

use std::path::PathBuf;

use dragnet_runtime::serve::{self, Role};

use super::Failure;
use crate::VERSION;

/// Watch and record a mission in the field.
///
/// It declares what is found, says who is alive, and records all that it hears over Zenoh. Robots search on without it.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet coordinator --config coordinator.toml")]
pub(crate) struct Arguments {
    /// What to watch and where to record it (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Pass on what robots say to each other: for robots that can reach the coordinator alone, with `mode = "router"`
    /// in their settings as well
    #[arg(long)]
    router: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let role = if arguments.router { Role::Router } else { Role::AsSet };
    Ok(serve::coordinator(&arguments.config, role, VERSION)?)
}
