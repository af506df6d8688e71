//! `dragnet completions`: shell completions.

use clap::CommandFactory;
use clap_complete::Shell;

use super::Failure;
use crate::CommandLine;
use crate::terminal;

/// Print a script of shell completions.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet completions bash > ~/.local/share/bash-completion/completions/dragnet
  dragnet completions fish > ~/.config/fish/completions/dragnet.fish")]
pub(crate) struct Arguments {
    /// The shell to print them for
    shell: Shell,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut CommandLine::command(), "dragnet", &mut script);
    Ok(terminal::print(&String::from_utf8_lossy(&script))?)
}
