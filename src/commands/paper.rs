//! `dragnet paper`: the paper's experiments in simulation, as one page.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use dragnet_experiments::paper::{self, Choice, Order};
use dragnet_experiments::seeds::Seeds;

use super::{Failure, complain};
use crate::VERSION;
use crate::terminal;
use crate::terminal::progress::Bars;

/// The first seed if only a number of seeds is given.
const FIRST_SEED: u64 = 1000;

/// Repeat the paper's experiments in simulation, and compare with its own figures.
///
/// Writes a self-contained page, report.html, with its numbers as CSV files and its curves as SVG files. The page states
/// which claims of the paper hold, and where this setup differs. `beyond` is what goes beyond the paper: tours, their
/// clone, a bound, and a team. The default seeds were not used for tuning or training, which used seeds below 1000 and
/// from 100000 on. With the default seeds, `beyond` takes about four minutes of computing time, `figure-6` and `table-3`
/// about a minute each, and all others together a quarter of a minute; these times are divided among the threads.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet paper --out report
  dragnet paper table-2 --seeds 1000..1050 --out report
  dragnet paper table-3 --seeds 50 --out report")]
pub(crate) struct Arguments {
    /// The table or figure to repeat
    #[arg(value_name = "EXPERIMENT", default_value = "all", value_parser = choices())]
    choice: Choice,
    /// Write the report and its CSV files to this folder, replacing older ones
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seeds: N for 1000 to 999 + N, or A..B for A to B - 1; at most 1000000 of them
    #[arg(
        long,
        value_name = "N | A..B",
        default_value = "1000..1020",
        value_parser = parse_seeds,
        allow_negative_numbers = true
    )]
    seeds: Seeds,
    /// Number of episodes to run in parallel, 1 to 1024 [default: the number of cores]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: Option<u16>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { choice, ref out, seeds, threads } = *arguments;
    paper::prepare(out)?;
    if let Some(warning) = paper::warning(seeds) {
        complain("warning", &format!("--seeds: {warning}"));
    }
    let page = paper::run(Order { choice, seeds, threads }, VERSION, &Bars)?.write(out)?;
    Ok(terminal::print(&format!("written: {}\n", page.display()))?)
}

/// Parses the name of a table, of a figure, or `all`.
fn choices() -> impl TypedValueParser<Value = Choice> {
    PossibleValuesParser::new(Choice::every().map(Choice::as_str))
        .map(|name| Choice::every().find(|choice| choice.as_str() == name).unwrap_or(Choice::All))
}

/// Parses seeds as [`Seeds`] does, except that a single number counts from the first unused seed.
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
