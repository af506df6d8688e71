//! Output for people: text on a terminal, or on any other stdout.

pub(crate) mod map;
pub(crate) mod progress;
pub(crate) mod table;

use std::io::{self, Write};

use console::Term;
use dragnet_experiments::jobs::Effort;
use serde::Serialize;

/// Columns if the width of the terminal is unknown.
const USUAL_COLUMNS: usize = 80;

/// Writes text to stdout, to the last byte.
pub(crate) fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// Writes one JSON object, on one line, to stdout.
pub(crate) fn print_json(object: &impl Serialize) -> io::Result<()> {
    print(&format!("{}\n", serde_json::to_string(object)?))
}

/// Columns of the terminal, or [`USUAL_COLUMNS`] if stdout is none.
pub(crate) fn columns() -> usize {
    Term::stdout().size_checked().map_or(USUAL_COLUMNS, |(_, columns)| usize::from(columns))
}

/// `in 1.5 s on 2 threads`
pub(crate) fn effort(effort: Effort) -> String {
    format!("in {:.1} s on {}", effort.elapsed.as_secs_f64(), counted(effort.threads, "thread"))
}

/// `1 robot`, `2 robots`, `2 trajectories`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    match noun.strip_suffix('y') {
        _ if count == 1 => format!("1 {noun}"),
        Some(stem) => format!("{count} {stem}ies"),
        None => format!("{count} {noun}s"),
    }
}
