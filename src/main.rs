//! The command line of Dragnet.
//!
//! [`commands`] has one file a subcommand; what they do is in the crates below this one. [`terminal`] and [`plot`] turn
//! what comes out into text and pictures.

mod commands;
mod plot;
mod terminal;

use std::process::ExitCode;

use clap::Parser;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::{Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

use commands::Command;

/// musl's own has one lock for all threads: with it, `run scenarios/team.toml` took 1.34 times as long as with glibc, with
/// this 1.06 times, and 149 MB instead of 121 (medians of three, in turns, beside others on two cores).
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Version and commit of this program.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("DRAGNET_COMMIT"), ")");

/// Searches a mapped area with one robot or many until every object of interest is found.
///
/// A scenario file says what is searched, by whom and with what. Start with `dragnet run`, which searches in simulation
/// and draws what was found; `dragnet compare` measures policies against each other; `dragnet agent` and `dragnet
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

Exit codes: 0 done, 1 a run failed, 2 bad input.";

fn main() -> ExitCode {
    let command = CommandLine::parse().command;
    keep_log(&command);
    match commands::execute(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// What happens beside the command's own output goes to stderr: what `RUST_LOG` asks for or, without, warnings, and
/// who comes and goes where a process serves a mission, and whom it turns away.
fn keep_log(command: &Command) {
    let usual = if command.serves() { "warn,dragnet_link=info,zenoh=error" } else { "warn,zenoh=error" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(usual));
    let lines = tracing_subscriber::fmt::layer().with_target(false).with_writer(std::io::stderr);
    let refusals = command.serves().then(dragnet_link::refusals::layer);
    tracing_subscriber::registry().with(lines.with_filter(filter)).with(refusals).init();
}
