//! The paper's experiments in simulation, as one page.
//!
//! [`run`] returns a [`Report`]. Each table and figure of the paper is a section with its own file; `study` runs the
//! comparisons that several sections show, and `page` assembles them.

mod beyond;
mod curves;
mod figure_5;
mod figure_6;
mod figure_7;
mod figure_8;
mod figure_9;
mod map;
mod markup;
mod measure;
mod page;
mod part;
mod picture;
mod published;
mod section;
mod setup;
mod study;
mod table_1;
mod table_2;
mod table_3;
mod trace;

use std::path::{Path, PathBuf};

use crate::progress::Progress;
use crate::seeds::Seeds;
use crate::{ExperimentError, output};
use page::Page;
pub use part::{Choice, Part};
use section::{File, Section};
pub use setup::warning;
use study::{Comparison, Study};

/// The file that holds the report.
const REPORT: &str = "report.html";

/// A request for a report.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// The parts of the paper.
    pub choice: Choice,
    /// The seeds.
    pub seeds: Seeds,
    /// Number of threads, by default one for each core.
    pub threads: Option<u16>,
}

/// The page and its numbers.
pub struct Report {
    page: String,
    files: Vec<File>,
}

/// Runs the experiments. The report names the version of the program.
///
/// # Errors
/// If an experiment fails, or its results cannot be drawn.
pub fn run(order: Order, program: &str, progress: &dyn Progress) -> Result<Report, ExperimentError> {
    let Order { choice, seeds, .. } = order;
    let sections = sections(order, progress)?;
    let page = Page { program, choice, seeds, sections: &sections }.draw();
    Ok(Report { page, files: sections.into_iter().flat_map(|section| section.files).collect() })
}

impl Report {
    /// Writes all files to a folder; returns the path of the page.
    ///
    /// # Errors
    /// If one cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, ExperimentError> {
        // The page last: if it exists, so do its numbers.
        for file in &self.files {
            output::write(&folder.join(&file.name), &file.content)?;
        }
        let report = folder.join(REPORT);
        output::write(&report, self.page.as_bytes())?;
        Ok(report)
    }
}

fn sections(order: Order, progress: &dyn Progress) -> Result<Vec<Section>, ExperimentError> {
    let parts = order.choice.parts();
    let mut studies: Vec<Study> = parts.iter().filter_map(|part| part.study()).collect();
    studies.dedup();
    let comparisons = study::run(&studies, order.seeds, order.threads, progress)?;
    parts.iter().map(|&part| section(part, &comparisons, order, progress)).collect()
}

fn section(
    part: Part,
    comparisons: &[Comparison],
    order: Order,
    progress: &dyn Progress,
) -> Result<Section, ExperimentError> {
    match part {
        Part::Table1 => table_1::section(order.seeds, progress),
        Part::Figure5 => figure_5::section(find(comparisons, Study::Imitation)),
        Part::Figure6 => figure_6::section(find(comparisons, Study::Scale)),
        Part::Figure7 => figure_7::section(find(comparisons, Study::Density)),
        Part::Table2 => table_2::section(find(comparisons, Study::Density)),
        Part::Figure8 => figure_8::section(order.seeds, progress),
        Part::Figure9 => figure_9::section(find(comparisons, Study::PathExpert)),
        Part::Table3 => table_3::section(order.seeds, order.threads, progress),
        Part::Beyond => beyond::section(order.seeds, order.threads, progress),
    }
}

#[expect(clippy::expect_used, reason = "the studies of all parts were run")]
fn find(comparisons: &[Comparison], study: Study) -> &Comparison {
    comparisons.iter().find(|comparison| comparison.study == study).expect("a study that was run")
}

/// Creates the folder and checks that files can be written to it, before experiments that take minutes.
///
/// # Errors
/// If the folder cannot be created, or not written to.
pub fn prepare(folder: &Path) -> Result<(), ExperimentError> {
    output::make_folder(folder)?;
    let failure =
        |what: &dyn std::fmt::Display| ExperimentError::Input(format!("--out {}: {what}", folder.display()));
    tempfile::tempfile_in(folder)
        .map_err(|error| failure(&format!("cannot write to the folder: {error}")))?;
    let report = folder.join(REPORT);
    if report.is_dir() {
        return Err(failure(&format!("{} is a folder; the report has that name", report.display())));
    }
    Ok(())
}
