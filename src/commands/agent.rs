//! `dragnet agent`: one robot.

use std::path::PathBuf;

use dragnet_runtime::serve::{self, Precedence};
use dragnet_search::utility::UtilityTable;

use super::settings::Kind;
use super::{Failure, dry_run, eyes};
use crate::terminal;

/// Run one robot of a team in the field.
///
/// The robot decides where to go and exchanges observations and plans with its teammates over Zenoh. It needs no
/// coordinator, and continues without a network.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet agent --config robot_1.toml
  dragnet agent --config robot_1.toml --dry-run yesterday.mcap")]
pub(crate) struct Arguments {
    /// File with the settings of the robot (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "print_config")]
    config: Option<PathBuf>,
    /// Print a complete file of settings with comments, and exit
    #[arg(long, exclusive = true)]
    print_config: bool,
    /// Replay a ROS 2 bag (MCAP, recorded by `ros2 bag record --storage mcap`) through the agent without publishing
    /// anything, and print the observations, finds and decisions that the robot would have made
    #[arg(long, value_name = "RECORDING")]
    dry_run: Option<PathBuf>,
    /// Stop any other process with this robot's number, and take its place
    #[arg(long, conflicts_with = "dry_run")]
    take_over: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Some(config) = &arguments.config else { return Ok(terminal::print(&Kind::Agent.template())?) };
    UtilityTable::warm_up();
    if let Some(recording) = &arguments.dry_run {
        return dry_run::execute(config, recording);
    }
    let precedence = if arguments.take_over { Precedence::First } else { Precedence::ByAge };
    Ok(serve::agent(config, precedence, &eyes::make)?)
}
