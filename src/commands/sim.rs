//! `dragnet sim`: the world, for agents in processes of their own.

use std::path::PathBuf;

use dragnet_runtime::serve;

use super::search::{self, Ended, Style};
use super::{Failure, scenario};

/// Simulate the world for robots that run elsewhere.
///
/// It knows where the objects are, moves the robots, and tells them over Zenoh what they see. `dragnet run` does all of this by itself.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet sim scenarios/team.toml --config sim.toml")]
pub(crate) struct Arguments {
    /// What is searched (TOML)
    scenario: PathBuf,
    /// How to reach the others (TOML)
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Print one JSON object and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = scenario::load(&arguments.scenario)?;
    let style = if arguments.json { Style::Json } else { Style::Text };
    search::tell(&scenario, style, |spectator| {
        let (episode, seed) = serve::world(&scenario, &arguments.config, spectator)?;
        Ok(Ended { seed, episode, observations_merged: None, recording: None })
    })
}
