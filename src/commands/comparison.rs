//! The output of a comparison, whether it ran here or was merged from shards.

mod report;

use std::path::PathBuf;

use dragnet_experiments::comparison::{self, Design, Gap, Row, Trial, files};
use dragnet_experiments::output;
use dragnet_scenario::file::PolicyField;

use super::{Failure, scenario};
use crate::terminal;
pub(super) use report::Origin;
use report::Report;

/// Where the results of a comparison go.
#[derive(clap::Args)]
pub(super) struct Output {
    /// Write tables (CSV) and the curves of each scenario (SVG) to this folder, replacing older ones
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// The policy that the others are compared with, written as in --policies [default: the first]
    #[arg(long, value_name = "POLICY", value_parser = scenario::POLICY)]
    baseline: Option<PolicyField>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

impl Output {
    /// Checks the baseline and creates the folder before the episodes run.
    pub(super) fn prepare(&self, design: &Design) -> Result<(), Failure> {
        self.baseline(design)?;
        Ok(self.out.as_deref().map_or(Ok(()), output::make_folder)?)
    }

    fn baseline(&self, design: &Design) -> Result<String, Failure> {
        let wanted = self.baseline.as_ref().map(PolicyField::to_string);
        Ok(design.baseline(wanted.as_deref())?.to_owned())
    }

    /// Writes and prints the results of a complete experiment, with the bounds of its scenarios if there are any.
    pub(super) fn tell(
        &self,
        design: &Design,
        trials: Vec<Trial>,
        bounds: &[(String, f64)],
        origin: Origin,
    ) -> Result<(), Failure> {
        let rows = design.rows(trials);
        let differences = comparison::differences(&rows, &self.baseline(design)?);
        let of_scenario = |row: &Row, (scenario, cells): &(String, f64)| {
            (row.scenario == *scenario).then(|| Gap::of(row, *cells))
        };
        let gaps: Vec<Gap> =
            rows.iter().filter_map(|row| bounds.iter().find_map(|bound| of_scenario(row, bound))).collect();
        let written = match &self.out {
            Some(folder) => files::write(folder, &rows, &differences, &gaps, design.seeds)?,
            None => Vec::new(),
        };
        let report =
            Report { rows: &rows, differences: &differences, gaps: &gaps, seeds: design.seeds, origin };
        if self.json {
            return Ok(terminal::print_json(&report.json())?);
        }
        Ok(terminal::print(&report.text(&written))?)
    }
}
