//! `dragnet agent`: one robot.

use std::path::PathBuf;

use dragnet_runtime::serve::{self, Precedence};
use dragnet_search::information::InformationTable;

use super::{Failure, dry_run, eyes};

/// Run one robot of a team in the field.
///
/// It decides where to go, tells the others over Zenoh what it saw, and hears them. It needs no coordinator, and goes on when the network does not.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet agent --config robot_1.toml
  dragnet agent --config robot_1.toml --dry-run yesterday.mcap")]
pub(crate) struct Arguments {
    /// What this robot is told before it starts (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Send nothing: live through what the vehicle's ROS 2 network said (MCAP, of `ros2 bag record --storage mcap`), and
    /// print what the robot would have seen, believed and decided
    #[arg(long, value_name = "RECORDING")]
    dry_run: Option<PathBuf>,
    /// Go on even if another process of this robot's number is in the mission already: that one stands then, and not this
    #[arg(long, conflicts_with = "dry_run")]
    take_over: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    InformationTable::warm_up();
    if let Some(recording) = &arguments.dry_run {
        return dry_run::execute(&arguments.config, recording);
    }
    let precedence = if arguments.take_over { Precedence::First } else { Precedence::ByAge };
    Ok(serve::agent(&arguments.config, precedence, &eyes::make)?)
}
