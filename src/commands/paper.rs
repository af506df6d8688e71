//! `dragnet paper`: the paper's experiments, run again in simulation, as one page.
//!
//! Each table and figure is a [`section::Section`] of a file of its own; [`study`] runs the comparisons that several of
//! them show, [`page`] puts them together.

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

use super::comparison::Seeds;
use super::{Failure, complain, output};
use crate::terminal;
use page::Page;
use part::{Choice, Part};
use section::Section;
use study::{Comparison, Study};

/// Numbers of seeds are counted from here on.
const FIRST_SEED: u64 = 1000;

/// The file that holds the report.
const REPORT: &str = "report.html";

/// Repeat the paper's experiments in simulation, beside its own figures.
///
/// Writes one page, report.html, which needs neither script nor network, and the numbers behind it as CSV files. It says
/// which claims of the paper hold, and where this set-up differs. The default seeds are none that anything was tuned or
/// trained on: that was done with seeds below 1000 and from 100000 on. All experiments take a few minutes.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet paper --out report
  dragnet paper table-2 --seeds 1000..1050 --out report
  dragnet paper table-3 --seeds 50 --out report")]
pub(crate) struct Arguments {
    /// The table or figure to repeat
    #[arg(value_name = "EXPERIMENT", default_value = "all", value_parser = Choice::parser())]
    choice: Choice,
    /// Write the report and its CSV files to this folder, over older ones
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seeds: N for 1000 to 999 + N, or A..B for A to B - 1
    #[arg(
        long,
        value_name = "N | A..B",
        default_value = "1000..1020",
        value_parser = parse_seeds,
        allow_negative_numbers = true
    )]
    seeds: Seeds,
    /// Episodes that run at a time [default: as many as there are cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { choice, ref out, seeds, threads } = *arguments;
    prepare(out)?;
    if let Some(warning) = setup::warning(seeds) {
        complain("warning", &format!("--seeds: {warning}"));
    }
    let sections = sections(&choice.parts(), seeds, threads)?;
    let page = Page { choice, seeds, sections: &sections }.draw();
    // The page last: where it is, its numbers are.
    for file in sections.iter().flat_map(|section| &section.files) {
        output::write(&out.join(&file.name), &file.content)?;
    }
    let report = out.join(REPORT);
    output::write(&report, page.as_bytes())?;
    Ok(terminal::print(&format!("written: {}\n", report.display()))?)
}

fn sections(parts: &[Part], seeds: Seeds, threads: Option<u16>) -> Result<Vec<Section>, Failure> {
    let mut studies: Vec<Study> = parts.iter().filter_map(|part| part.study()).collect();
    studies.dedup();
    let comparisons = study::run(&studies, seeds, threads)?;
    parts.iter().map(|&part| section(part, &comparisons, seeds, threads)).collect()
}

fn section(
    part: Part,
    comparisons: &[Comparison],
    seeds: Seeds,
    threads: Option<u16>,
) -> Result<Section, Failure> {
    match part {
        Part::Table1 => table_1::section(seeds),
        Part::Figure5 => figure_5::section(find(comparisons, Study::Imitation)),
        Part::Figure6 => figure_6::section(find(comparisons, Study::Scale)),
        Part::Figure7 => figure_7::section(find(comparisons, Study::Density)),
        Part::Table2 => table_2::section(find(comparisons, Study::Density)),
        Part::Figure8 => figure_8::section(seeds),
        Part::Figure9 => figure_9::section(find(comparisons, Study::PathExpert)),
        Part::Table3 => table_3::section(seeds, threads),
    }
}

#[expect(clippy::expect_used, reason = "the studies of all parts were run")]
fn find(comparisons: &[Comparison], study: Study) -> &Comparison {
    comparisons.iter().find(|comparison| comparison.study == study).expect("a study that was run")
}

/// Makes the folder and sees that files can be written to it, before minutes of work.
fn prepare(folder: &Path) -> Result<(), Failure> {
    output::make_folder(folder)?;
    let failure =
        |what: &dyn std::fmt::Display| Failure::Input(format!("--out {}: {what}", folder.display()));
    tempfile::tempfile_in(folder)
        .map_err(|error| failure(&format!("cannot write to the folder: {error}")))?;
    let report = folder.join(REPORT);
    if report.is_dir() {
        return Err(failure(&format!("{} is a folder; the report has that name", report.display())));
    }
    Ok(())
}

/// As [`Seeds`], but for a number, which counts from seeds on that were not used before.
fn parse_seeds(text: &str) -> Result<Seeds, String> {
    let end = text.parse::<u64>().ok().and_then(|count| FIRST_SEED.checked_add(count));
    end.map_or_else(|| text.parse(), |end| format!("{FIRST_SEED}..{end}").parse())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_seeds_counts_from_those_that_were_not_used() {
        assert_eq!(parse_seeds("2"), "1000..1002".parse());
        assert_eq!(parse_seeds("3..5"), "3..5".parse());
        for wrong in ["0", "-1", "5..3", "a"] {
            assert!(parse_seeds(wrong).is_err(), "{wrong}");
        }
    }
}
