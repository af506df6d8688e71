//! `dragnet merge`: joins the results of shards.

use std::path::PathBuf;

use dragnet_experiments::demonstrations::part::Joined;
use dragnet_experiments::{comparison, demonstrations, shard};

use super::Failure;
use super::comparison::{Origin, Output};
use crate::terminal::{self, counted};

/// Join the parts of a command that ran in shards.
///
/// Prints and writes what the command would have printed and written without shards. Every shard must be present
/// exactly once, and all must come from the same experiment and the same version of this program.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet merge parts --out results
  dragnet merge part-1-of-2.json part-2-of-2.json")]
pub(crate) struct Arguments {
    /// Part files, or folders of which all parts are joined
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mut files = Vec::new();
    for path in &arguments.parts {
        files.extend(shard::part_files(path)?);
    }
    if demonstrations::part::are_demonstrations(&files) {
        return tell(&demonstrations::part::join(&files, arguments.output.out.as_deref())?);
    }
    let joined = comparison::part::join(&files)?;
    arguments.output.prepare(&joined.design)?;
    arguments.output.tell(&joined.design, joined.trials, &[], Origin::Parts(joined.parts))
}

/// Prints the totals of joined demonstrations.
fn tell(joined: &Joined) -> Result<(), Failure> {
    Ok(terminal::print(&format!(
        "{} complete: {}, {} decisions of {}; {} copied to {}\n",
        counted(joined.parts, "part"),
        counted(joined.trajectories, "trajectory"),
        joined.decisions,
        joined.expert,
        joined.copied,
        joined.folder.display(),
    ))?)
}
