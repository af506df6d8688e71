//! The command line of Dragnet.
//!
//! [`commands`] has one file for each subcommand; their work is done by the crates below this one. [`terminal`] formats
//! results as text.

mod commands;
mod help;
mod log;
mod terminal;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};

use commands::Command;

/// musl's own has one lock for all threads: with it, `run scenarios/team.toml` took 1.34 times as long as with glibc, with
/// this 1.06 times, and 149 MB instead of 121 (medians of three, in turns, beside others on two cores).
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Version and commit of this program.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("DRAGNET_COMMIT"), ")");

/// Search a mapped area with one robot or a team until every object of interest is found.
///
/// A scenario file describes the map, the sensor, the objects and the robots. Start with `dragnet run`, which searches in
/// simulation and draws the result. `dragnet compare` measures policies against each other. `dragnet agent` and `dragnet
/// coordinator` run on vehicles.
#[derive(Parser)]
#[command(name = "dragnet", version = VERSION, after_help = EXAMPLES, arg_required_else_help = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  dragnet run scenarios/ice_cream_cone.toml
  dragnet compare scenarios/paper/figure_four.toml --policies greedy,path --seeds 10
  dragnet check scenarios/*.toml

Exit codes: 0 success, 1 a run failed, 2 invalid input.";

fn main() -> ExitCode {
    let matches = help::grouped(CommandLine::command()).get_matches();
    let command = match CommandLine::from_arg_matches(&matches) {
        Ok(line) => line.command,
        Err(error) => error.exit(),
    };
    log::keep(&command);
    match commands::execute(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
