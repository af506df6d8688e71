//! `dragnet schema`: for editors that complete and check TOML.

use dragnet_scenario::schema_json;

use super::Failure;
use crate::terminal;

/// Print the JSON Schema of scenario files.
///
/// Editors with TOML support complete and check a scenario whose first line is `#:schema ./scenario.schema.json`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet schema > scenarios/scenario.schema.json")]
pub(crate) struct Arguments {}

pub(super) fn execute(_: &Arguments) -> Result<(), Failure> {
    Ok(terminal::print(&schema_json())?)
}
