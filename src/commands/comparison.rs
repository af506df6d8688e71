//! What a comparison prints and writes, whether it ran here or is merged from shards.

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
    /// Write tables (CSV) and the curves of each scenario (SVG) to this folder, over older ones
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Print one JSON object and nothing else
    #[arg(long)]
    json: bool,
}

impl Output {
    /// Makes the folder, so that it is not missing after hours of work.
    pub(super) fn prepare(&self) -> Result<(), Failure> {
        Ok(self.out.as_deref().map_or(Ok(()), output::make_folder)?)
    }

    /// Writes and prints what the trials of a whole experiment come to.
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
