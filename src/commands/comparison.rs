//! Policies against each other, over scenarios and seeds: what is run, in one process or in shards, and the tables and
//! curves that it comes to.
//!
//! An [`Experiment`] runs, each episode comes to a [`Trial`], and its [`Design`] makes a [`Row`] a case of the trials,
//! wherever and in however many parts they were run.

mod design;
mod experiment;
pub(super) mod files;
pub(super) mod part;
mod report;
mod seeds;

use std::path::PathBuf;

pub(super) use design::Design;
pub(super) use dragnet_sim::comparison::{Estimate, Row, Trial, digest};
pub(super) use experiment::{Case, Experiment};
pub(super) use report::{Origin, estimate};
pub(super) use seeds::Seeds;

use super::{Failure, output};
use crate::terminal;
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
        self.out.as_deref().map_or(Ok(()), output::make_folder)
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
