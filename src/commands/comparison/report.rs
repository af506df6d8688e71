//! The printed report of a comparison.

use std::fmt;
use std::path::PathBuf;

use dragnet_experiments::comparison::{Row, estimate};
use dragnet_experiments::jobs::Effort;
use dragnet_experiments::seeds::Seeds;
use serde::Serialize;

use crate::terminal::table::Table;
use crate::terminal::{self, counted};

/// A completed comparison; at least one row.
pub(super) struct Report<'a> {
    pub(super) rows: &'a [Row],
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
}

impl Report<'_> {
    pub(super) fn json(&self) -> Json<'_> {
        Json { note: NOTE, rows: self.rows }
    }

    pub(super) fn text(&self, written: &[PathBuf]) -> String {
        let episodes: usize = self.rows.iter().map(|row| row.seeds).sum();
        let files: Vec<String> =
            written.iter().map(|path| format!("written: {}\n", path.display())).collect();
        format!(
            "{}: {} {}\nrobots: {}; budget: {} cells\n\n{}\n{}\n{}",
            self.seeds,
            counted(episodes, "episode"),
            self.origin,
            range(self.rows.iter().map(|row| row.robots as f64)),
            range(self.rows.iter().map(|row| row.budget_cells)),
            self.table().draw(2),
            NOTE,
            files.concat(),
        )
    }

    fn table(&self) -> Table {
        let mut table = Table::new([
            "scenario",
            "policy",
            "area under F1",
            "average recall",
            "full recall",
            "reached",
            "missed",
            "remaining",
            "expected",
            "tail s",
            "p50 ms",
            "p99 ms",
        ]);
        for row in self.rows {
            let full = &row.cells_to_full_recall;
            table.push([
                row.scenario.clone(),
                row.policy.clone(),
                estimate(Some(row.auc_f1.mean), row.auc_f1.sem, 3),
                estimate(Some(row.average_recall.mean), row.average_recall.sem, 3),
                estimate(full.mean, full.sem, 1),
                format!("{} of {}", full.reached, row.seeds),
                format!("{} of {}", row.seeds_with_remaining, row.seeds),
                estimate(Some(row.remaining.mean), row.remaining.sem, 3),
                estimate(Some(row.expected_remaining.mean), None, 3),
                estimate(Some(row.tail_s.mean), row.tail_s.sem, 0),
                estimate(row.decision_ms.p50, None, 3),
                estimate(row.decision_ms.p99, None, 3),
            ]);
        }
        table
    }
}

const NOTE: &str = "\
Values are means over the seeds ± their standard error. An episode ends when every object is found, or when the robots
rest; with --end resting only then. F1 and recall then keep their last values up to the budget, over which the area under
F1 and the average recall are taken. Full recall is the way of the farthest robot until every object was found, in cells,
over those seeds only that reached it. Missed are episodes that ended with an object not found; so many objects remained,
and so many the belief expected, in the mean (the two agree with --end resting only). The tail is the mission time from
the last find to the end. p50 and p99 are times that half and 99 % of the decisions took no longer than.";

impl fmt::Display for Origin {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Here(effort) => formatter.write_str(&terminal::effort(*effort)),
            Self::Parts(count) => write!(formatter, "in {}", counted(*count, "part")),
        }
    }
}

/// `300`, or `300 to 1200` where values differ.
fn range(values: impl Iterator<Item = f64> + Clone) -> String {
    let least = format!("{:.0}", values.clone().fold(f64::INFINITY, f64::min));
    let greatest = format!("{:.0}", values.fold(0.0, f64::max));
    if least == greatest { least } else { format!("{least} to {greatest}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_one_number_where_all_are_equal() {
        assert_eq!(range([300.0, 300.0].into_iter()), "300");
        assert_eq!(range([300.0, 60.0, 90.0].into_iter()), "60 to 300");
    }
}
