//! The printed report of a comparison.

use std::fmt::{self, Write as _};
use std::path::PathBuf;

use dragnet_experiments::comparison::{Difference, Gap, Interval, Row, estimate};
use dragnet_experiments::jobs::Effort;
use dragnet_experiments::seeds::Seeds;
use serde::Serialize;

use crate::terminal::table::Table;
use crate::terminal::{self, counted};

/// A completed comparison; at least one row.
pub(super) struct Report<'a> {
    pub(super) rows: &'a [Row],
    pub(super) differences: &'a [Difference],
    pub(super) gaps: &'a [Gap],
    pub(super) seeds: Seeds,
    pub(super) origin: Origin,
}

/// Where its episodes ran.
pub(crate) enum Origin {
    /// In this process.
    Here(Effort),
    /// In this many shards.
    Parts(usize),
}

#[derive(Serialize)]
pub(super) struct Json<'a> {
    /// When episodes end, in words.
    note: &'static str,
    rows: &'a [Row],
    /// Of the policies other than the baseline.
    differences: &'a [Difference],
    /// With `--bound` only.
    #[serde(skip_serializing_if = "<[Gap]>::is_empty")]
    bounds: &'a [Gap],
}

impl Report<'_> {
    pub(super) fn json(&self) -> Json<'_> {
        Json { note: NOTE, rows: self.rows, differences: self.differences, bounds: self.gaps }
    }

    pub(super) fn text(&self, written: &[PathBuf]) -> String {
        let episodes: usize = self.rows.iter().map(|row| row.seeds).sum();
        let files: Vec<String> =
            written.iter().map(|path| format!("written: {}\n", path.display())).collect();
        let scenarios: Vec<String> =
            self.rows.chunk_by(|a, b| a.scenario == b.scenario).map(|rows| self.scenario(rows)).collect();
        format!(
            "{}: {} {}\n\n{}\n{NOTE}\n{}",
            self.seeds,
            counted(episodes, "episode"),
            self.origin,
            scenarios.join("\n"),
            files.concat(),
        )
    }

    /// The tables of one scenario, of at least one row.
    fn scenario(&self, rows: &[Row]) -> String {
        let row = &rows[0];
        let mut text = format!(
            "{}: {}, {}, budget {:.0} cells\n\n{}\n{}",
            row.scenario,
            counted(row.robots, "robot"),
            row.objects,
            row.budget_cells,
            lengths(rows).draw(1),
            measures(rows).draw(1),
        );
        if row.seeds_without_object > 0 {
            let (void, seeds) = (row.seeds_without_object, row.seeds);
            let _ = writeln!(
                text,
                "\nNo object is in reach of a robot with {void} of {seeds} seeds. They say nothing about a policy, and\n\
                 count in the means of all policies as if every object had been found at once."
            );
        }
        let differences: Vec<&Difference> =
            self.differences.iter().filter(|difference| difference.scenario == row.scenario).collect();
        if !differences.is_empty() {
            text.push('\n');
            text.push_str(&compared(&differences).draw(1));
        }
        let gaps: Vec<&Gap> = self.gaps.iter().filter(|gap| gap.scenario == row.scenario).collect();
        if let Some(gap) = gaps.first() {
            let cells = gap.bound_cells;
            let _ = writeln!(
                text,
                "\nProven: no policy needs fewer than {cells:.1} cells in the mean, the budget for a\n\
                 search that misses. The mean of few seeds may be below it by chance.\n"
            );
            text.push_str(&above(&gaps).draw(1));
        }
        text
    }
}

/// Path lengths until shares of the objects were found.
fn lengths(rows: &[Row]) -> Table {
    let mut table =
        Table::new(["policy", "full recall", "reached", "50 %", "80 %", "95 %", "average recall"]);
    for row in rows {
        let full = &row.cells_to_full_recall;
        let part = |place: usize| estimate(Some(row.cells_to_recall[place].restricted_mean), None, 1);
        table.push([
            row.policy.clone(),
            estimate(Some(full.restricted_mean), full.restricted_sem, 1),
            format!("{} of {}", full.reached, row.seeds),
            part(0),
            part(1),
            part(2),
            estimate(Some(row.average_recall.mean), row.average_recall.sem, 3),
        ]);
    }
    table
}

/// What else was measured.
fn measures(rows: &[Row]) -> Table {
    let mut table =
        Table::new(["policy", "area under F1", "remaining", "expected", "tail s", "p50 ms", "p99 ms"]);
    for row in rows {
        table.push([
            row.policy.clone(),
            estimate(Some(row.auc_f1.mean), row.auc_f1.sem, 3),
            estimate(Some(row.remaining.mean), row.remaining.sem, 3),
            estimate(Some(row.expected_remaining.mean), None, 3),
            estimate(Some(row.tail_s.mean), row.tail_s.sem, 0),
            estimate(row.decision_ms.p50, None, 2),
            estimate(row.decision_ms.p99, None, 2),
        ]);
    }
    table
}

/// Differences to the baseline; at least one.
fn compared(differences: &[&Difference]) -> Table {
    let title = format!("less {}", differences[0].baseline);
    let mut table = Table::new([title.as_str(), "full recall", "", "average recall", ""]);
    for it in differences {
        table.push([
            it.policy.clone(),
            interval(it.cells_to_full_recall, 1),
            verdict(it.cells_to_full_recall),
            interval(it.average_recall, 3),
            verdict(it.average_recall),
        ]);
    }
    table
}

/// Distances to the bound.
fn above(gaps: &[&Gap]) -> Table {
    let mut table = Table::new(["policy", "full recall", "above the bound"]);
    for gap in gaps {
        let above = gap.above_percent.map_or_else(|| "-".to_owned(), |percent| format!("{percent:.0} %"));
        table.push([gap.policy.clone(), format!("{:.1}", gap.cells), above]);
    }
    table
}

/// `-12.3 [-15.0, -9.9]`
fn interval(interval: Interval, decimals: usize) -> String {
    let Interval { mean, low, high, .. } = interval;
    match (low, high) {
        (Some(low), Some(high)) => format!("{mean:+.decimals$} [{low:+.decimals$}, {high:+.decimals$}]"),
        _ => format!("{mean:+.decimals$}"),
    }
}

fn verdict(interval: Interval) -> String {
    interval.verdict.map_or_else(String::new, |verdict| verdict.as_str().to_owned())
}

const NOTE: &str = "\
Values are means over the seeds ± their standard error. An episode ends when
every object is found, or when the robots rest; with --end resting only then.
Recall and F1 then keep their last values up to the budget. Full recall, and 50,
80 and 95 %, are the path length in cells of the farthest robot until so much
was found; a search that does not get there counts as the budget, so that these
are lower bounds. Average recall and area under F1 are means over path lengths
up to the budget. Remaining is the number of objects not found at the end,
expected what the belief says it is (the two agree with --end resting only). The
tail is the mission time from the last find to the end. Half of the decisions
took no longer than p50, 99 % no longer than p99. Differences are paired by
seed, with their 95 % bootstrap interval; better and worse are those that do
not hold 0.";

impl fmt::Display for Origin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Here(effort) => formatter.write_str(&terminal::effort(*effort)),
            Self::Parts(count) => write!(formatter, "in {}", counted(*count, "part")),
        }
    }
}
