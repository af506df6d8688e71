//! `dragnet coordinator`: the mission seen from outside.

use std::path::PathBuf;

use dragnet_runtime::serve::{self, Role};

use super::Failure;
use super::settings::Kind;
use crate::{VERSION, terminal};

/// Watch and record a mission in the field.
///
/// It declares finds, tracks which robots are alive, and records all messages. Robots search on without it.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet coordinator --config coordinator.toml")]
pub(crate) struct Arguments {
    /// The coordinator's settings (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "print_config")]
    config: Option<PathBuf>,
    /// Print complete settings with comments, and nothing else
    #[arg(long, exclusive = true)]
    print_config: bool,
    /// Forward messages between robots: for robots that reach the coordinator alone, with `mode = "router"` in their
    /// settings as well
    #[arg(long)]
    router: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Some(config) = &arguments.config else { return Ok(terminal::print(&Kind::Coordinator.template())?) };
    let role = if arguments.router { Role::Router } else { Role::AsSet };
    Ok(serve::coordinator(config, role, VERSION)?)
}
