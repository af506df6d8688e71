//! `dragnet schema`: JSON Schemas for editors that complete and check TOML.

use super::Failure;
use super::settings::Kind;
use crate::terminal;

/// Print the JSON Schema of scenarios or settings.
///
/// Editors with TOML support complete and check a file whose first line names its schema, such as
/// `#:schema ./scenario.schema.json`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet schema > scenarios/scenario.schema.json
  dragnet schema agent > deploy/agent.schema.json")]
pub(crate) struct Arguments {
    /// The kind of file
    #[arg(value_enum, default_value = "scenario", value_name = "KIND")]
    kind: Kind,
    /// Print a table of all keys (Markdown) instead of the schema
    #[arg(long)]
    markdown: bool,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { kind, markdown } = *arguments;
    Ok(terminal::print(&if markdown { kind.reference() } else { kind.schema() })?)
}
