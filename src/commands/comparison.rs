//! The output of a comparison, whether it ran here or was merged from shards.

mod report;

use std::path::PathBuf;

use dragnet_experiments::comparison::{Design, Trial, files};
use dragnet_experiments::output;

use super::Failure;
use crate::terminal;
pub(super) use report::Origin;
use report::Report;

/// Where the results of a comparison go.
#[derive(clap::Args)]
pub(super) struct Output {
    /// Write tables (CSV) and the curves of each scenario (SVG) to this folder, replacing older ones
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

impl Output {
    /// Creates the folder before the episodes run.
    pub(super) fn prepare(&self) -> Result<(), Failure> {
        Ok(self.out.as_deref().map_or(Ok(()), output::make_folder)?)
    }

    /// Writes and prints the results of a complete experiment.
    pub(super) fn tell(&self, design: &Design, trials: Vec<Trial>, origin: Origin) -> Result<(), Failure> {
        let rows = design.rows(trials);
        let written = match &self.out {
            Some(folder) => files::write(folder, &rows, design.seeds)?,
            None => Vec::new(),
        };
        let report = Report { rows: &rows, seeds: design.seeds, origin };
        if self.json {
            return Ok(terminal::print_json(&report.json())?);
        }
        Ok(terminal::print(&report.text(&written))?)
    }
}
