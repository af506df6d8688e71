//! `dragnet coordinator`: watches and records a mission.

use std::path::PathBuf;

use dragnet_runtime::serve::{self, Role};

use super::Failure;
use super::settings::Kind;
use crate::{VERSION, terminal};

/// Monitor and record a mission in the field.
///
/// The coordinator declares finds, tracks which robots are alive, and records all messages. Robots continue to search
/// without it.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet coordinator --config coordinator.toml")]
pub(crate) struct Arguments {
    /// File with the settings of the coordinator (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "print_config")]
    config: Option<PathBuf>,
    /// Print a complete file of settings with comments, and exit
    #[arg(long, exclusive = true)]
    print_config: bool,
    /// Forward messages between robots that can reach only the coordinator; needs `mode = "router"` in their settings
    /// too
    #[arg(long)]
    router: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Some(config) = &arguments.config else { return Ok(terminal::print(&Kind::Coordinator.template())?) };
    let role = if arguments.router { Role::Router } else { Role::AsSet };
    Ok(serve::coordinator(config, role, VERSION)?)
}
