//! `dragnet sim`: simulates the world for agents in other processes.

use std::path::PathBuf;

use dragnet_runtime::serve;
use dragnet_runtime::team::Medium;

use super::search::{self, Ended, Style};
use super::settings::Kind;
use super::{Failure, scenario};
use crate::terminal;

/// Simulate the world for robots that run in other processes.
///
/// Places the objects, moves the robots along their plans, and sends them their readings. `dragnet run` does all of
/// this in one process.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet sim scenarios/team.toml --config sim.toml")]
pub(crate) struct Arguments {
    /// Scenario file (TOML), or a name that `dragnet scenarios` lists
    #[arg(required_unless_present = "print_config")]
    scenario: Option<PathBuf>,
    /// File with the settings of the simulator (TOML)
    #[arg(long, value_name = "FILE", required_unless_present = "print_config")]
    config: Option<PathBuf>,
    /// Print a complete file of settings with comments, and exit
    #[arg(long, exclusive = true)]
    print_config: bool,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (Some(scenario), Some(config)) = (&arguments.scenario, &arguments.config) else {
        return Ok(terminal::print(&Kind::Sim.template())?);
    };
    let scenario = scenario::load(scenario)?;
    let style = if arguments.json { Style::Json } else { Style::Text };
    search::tell(&scenario, style, |spectator| {
        let (episode, seed) = serve::world(&scenario, config, spectator)?;
        Ok(Ended {
            seed,
            episode,
            observations_merged: None,
            medium: Medium::Zenoh,
            recording: None,
            failure: None,
        })
    })
}
