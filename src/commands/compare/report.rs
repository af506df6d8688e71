//! What a comparison prints.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

use super::row::Row;
use super::seeds::Seeds;
use crate::terminal::counted;
use crate::terminal::table::Table;

/// A comparison that is done.
pub(super) struct Report<'a> {
    pub(super) results: &'a [Row],
    pub(super) seeds: Seeds,
    pub(super) threads: usize,
}

#[derive(Serialize)]
pub(super) struct Json<'a> {
    /// How episodes end, in words.
    note: &'static str,
    rows: &'a [Row],
}

impl Report<'_> {
    pub(super) fn json(&self) -> Json<'_> {
        Json { note: NOTE, rows: self.results }
    }

    pub(super) fn text(&self, elapsed: Duration, written: &[PathBuf]) -> String {
        let episodes: usize = self.results.iter().map(|row| row.seeds).sum();
        let files: Vec<String> =
            written.iter().map(|path| format!("written: {}\n", path.display())).collect();
        format!(
            "{}: {} in {:.1} s on {}\n\n{}\n{}\n{}",
            self.seeds,
            counted(episodes, "episode"),
            elapsed.as_secs_f64(),
            counted(self.threads, "thread"),
            self.table().draw(2),
            NOTE,
            files.concat(),
        )
    }

    fn table(&self) -> Table {
        let mut table = Table::new([
            "scenario",
            "policy",
            "robots",
            "budget",
            "area under F1",
            "full recall",
            "reached by",
            "p50 ms",
            "p99 ms",
        ]);
        for row in self.results {
            let full = &row.cells_to_full_recall;
            table.push([
                row.scenario.clone(),
                row.policy.to_owned(),
                row.robots.to_string(),
                format!("{:.0}", row.budget_cells),
                estimate(Some(row.auc_f1.mean), row.auc_f1.sem, 3),
                estimate(full.mean, full.sem, 1),
                format!("{} of {}", full.reached, row.seeds),
                estimate(row.decision_ms.p50, None, 3),
                estimate(row.decision_ms.p99, None, 3),
            ]);
        }
        table
    }
}

const NOTE: &str = "\
Values are means over the seeds ± their standard error. An episode ends when every object is found: F1 then keeps its
last value up to the budget, over which its area is taken. Full recall is the way of the farthest robot until every
object was found, over those seeds only that reached it. Budget and full recall are in cells; p50 and p99 are times that
half and 99 % of the decisions took no longer than.";

/// `0.912 ± 0.004`, as far as it is known.
fn estimate(mean: Option<f64>, sem: Option<f64>, decimals: usize) -> String {
    match (mean, sem) {
        (Some(mean), Some(sem)) => format!("{mean:.decimals$} ± {sem:.decimals$}"),
        (Some(mean), None) => format!("{mean:.decimals$}"),
        (None, _) => "-".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_says_what_is_known() {
        assert_eq!(estimate(Some(0.25), Some(0.001), 2), "0.25 ± 0.00");
        assert_eq!(estimate(Some(137.0), None, 1), "137.0");
        assert_eq!(estimate(None, None, 1), "-");
    }
}
