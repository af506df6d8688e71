//! The files of a comparison: tables as CSV, curves as SVG.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use csv::Writer;
use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_search::policy::PolicyName as Exact;
use dragnet_sim::comparison::bound::Gap;
use dragnet_sim::comparison::{Difference, Interval, MeanCurve, Row};

use crate::plot::{Figure, Line, LineStyle};
use crate::seeds::Seeds;
use crate::{ExperimentError, output};

/// Difference in F1 to its last value at which a curve counts as settled.
const SETTLED: f64 = 0.005;

/// Writes all files; returns their paths.
///
/// # Errors
/// If one cannot be drawn or written.
pub fn write(
    folder: &Path,
    rows: &[Row],
    differences: &[Difference],
    gaps: &[Gap],
    seeds: Seeds,
) -> Result<Vec<PathBuf>, ExperimentError> {
    let mut written = Vec::new();
    let mut keep = |name: String, content: Vec<u8>| {
        let path = folder.join(name);
        output::write(&path, &content)?;
        written.push(path);
        Ok::<(), ExperimentError>(())
    };
    for (name, table) in [
        ("summary.csv", summary(rows)),
        ("differences.csv", differences_table(differences)),
        ("episodes.csv", episodes(rows)),
        ("curves.csv", curves(rows)),
    ] {
        keep(name.to_owned(), table.map_err(|error| failure(&folder.join(name), error))?)?;
    }
    if !gaps.is_empty() {
        let table = gaps_table(gaps).map_err(|error| failure(&folder.join("bounds.csv"), error))?;
        keep("bounds.csv".to_owned(), table)?;
    }
    for rows in rows.chunk_by(|a, b| a.scenario == b.scenario) {
        let name = format!("{}.svg", rows[0].scenario);
        let drawing = figure(rows, seeds).draw().map_err(|error| failure(&folder.join(&name), error))?;
        keep(name, drawing.into_bytes())?;
    }
    Ok(written)
}

fn failure(path: &Path, error: impl Display) -> ExperimentError {
    ExperimentError::Run(format!("{}: cannot write: {error}", path.display()))
}

/// A row for each scenario and policy.
pub(crate) fn summary(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "scenario",
        "map",
        "policy",
        "robots",
        "seeds",
        "budget_cells",
        "auc_f1_mean",
        "auc_f1_sem",
        "average_recall_mean",
        "average_recall_sem",
        "cells_to_full_recall_mean",
        "cells_to_full_recall_sem",
        "cells_to_full_recall_reached",
        "cells_to_full_recall_restricted_mean",
        "cells_to_full_recall_restricted_sem",
        "cells_to_50_recall_restricted_mean",
        "cells_to_80_recall_restricted_mean",
        "cells_to_95_recall_restricted_mean",
        "remaining_mean",
        "remaining_sem",
        "expected_remaining_mean",
        "expected_remaining_sem",
        "seeds_with_remaining",
        "seeds_without_object",
        "tail_s_mean",
        "tail_s_sem",
        "decision_ms_p50",
        "decision_ms_p99",
    ];
    table(titles, |writer| {
        rows.iter().try_for_each(|row| {
            let (f1, recall, full) = (row.auc_f1, row.average_recall, &row.cells_to_full_recall);
            writer.serialize((
                (&row.scenario, &row.map, &row.policy, row.robots, row.seeds, row.budget_cells),
                (f1.mean, f1.sem, recall.mean, recall.sem),
                (full.mean, full.sem, full.reached, full.restricted_mean, full.restricted_sem),
                row.cells_to_recall.iter().map(|it| it.restricted_mean).collect::<Vec<_>>(),
                (row.remaining.mean, row.remaining.sem),
                (row.expected_remaining.mean, row.expected_remaining.sem),
                (row.seeds_with_remaining, row.seeds_without_object),
                (row.tail_s.mean, row.tail_s.sem),
                (row.decision_ms.p50, row.decision_ms.p99),
            ))
        })
    })
}

/// A row for each policy and scenario beside the baseline.
fn differences_table(differences: &[Difference]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "scenario",
        "policy",
        "baseline",
        "cells_to_full_recall_mean",
        "cells_to_full_recall_low",
        "cells_to_full_recall_high",
        "cells_to_full_recall_verdict",
        "average_recall_mean",
        "average_recall_low",
        "average_recall_high",
        "average_recall_verdict",
        "auc_f1_mean",
        "auc_f1_low",
        "auc_f1_high",
        "auc_f1_verdict",
    ];
    let columns = |interval: Interval| (interval.mean, interval.low, interval.high, interval.verdict);
    table(titles, |writer| {
        differences.iter().try_for_each(|it| {
            writer.serialize((
                (&it.scenario, &it.policy, &it.baseline),
                (columns(it.cells_to_full_recall), columns(it.average_recall), columns(it.auc_f1)),
            ))
        })
    })
}

/// A row for each policy and scenario beside the bound of the scenario.
fn gaps_table(gaps: &[Gap]) -> Result<Vec<u8>, csv::Error> {
    let titles = ["scenario", "policy", "bound_cells", "cells", "above_percent"];
    table(titles, |writer| {
        gaps.iter().try_for_each(|it| {
            writer.serialize((&it.scenario, &it.policy, it.bound_cells, it.cells, it.above_percent))
        })
    })
}

/// A row for each episode.
pub(crate) fn episodes(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "scenario",
        "policy",
        "robots",
        "seed",
        "auc_f1",
        "average_recall",
        "cells_to_full_recall",
        "cells_to_50_recall",
        "cells_to_80_recall",
        "cells_to_95_recall",
        "f1_at_end",
        "recall_at_end",
        "cells_at_end",
        "remaining",
        "expected_remaining",
        "tail_s",
    ];
    table(titles, |writer| {
        rows.iter().flat_map(|row| row.trials.iter().map(move |trial| (row, trial))).try_for_each(
            |(row, trial)| {
                writer.serialize((
                    (&row.scenario, &row.policy, row.robots, trial.seed, trial.auc_f1, trial.average_recall),
                    (trial.cells_to_full_recall, trial.cells_to_recall),
                    (trial.f1, trial.recall, trial.farthest_cells),
                    (trial.remaining, trial.expected_remaining, trial.tail_seconds),
                ))
            },
        )
    })
}

/// A row for each point of a curve.
pub(crate) fn curves(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    table(["scenario", "policy", "cells", "f1_mean", "f1_sem"], |writer| {
        for row in rows {
            let curve = &row.curve;
            for ((cells, mean), sem) in curve.cells.iter().zip(&curve.mean).zip(&curve.sem) {
                writer.serialize((&row.scenario, &row.policy, cells, mean, sem))?;
            }
        }
        Ok(())
    })
}

/// A table with these titles.
pub(crate) fn table<const COLUMNS: usize>(
    titles: [&str; COLUMNS],
    fill: impl FnOnce(&mut Writer<Vec<u8>>) -> Result<(), csv::Error>,
) -> Result<Vec<u8>, csv::Error> {
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record(titles)?;
    fill(&mut writer)?;
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// The curves of one scenario.
pub(crate) fn figure(rows: &[Row], seeds: Seeds) -> Figure<'_> {
    let lines = rows.iter().zip(line_styles(rows)).map(|(row, line_style)| Line {
        label: &row.policy,
        line_style,
        lengths: &row.curve.cells,
        mean: &row.curve.mean,
        standard_error: &row.curve.sem,
    });
    let robots = match rows[0].robots {
        1 => "1 robot".to_owned(),
        count => format!("{count} robots"),
    };
    Figure {
        title: rows[0].scenario.replace('_', " "),
        subtitle: format!("{}, {robots}; mean and standard error of {seeds}", rows[0].objects),
        horizontal: "Path length of the farthest robot (cells)",
        vertical: "F1",
        length: rows.iter().map(|row| settled(&row.curve)).fold(0.0, f64::max),
        height: 1.0,
        lines: lines.collect(),
    }
}

/// The style of each row's policy. Of one policy with several parameters the later ones have the next dashes.
fn line_styles(rows: &[Row]) -> Vec<LineStyle> {
    let mut styles: Vec<LineStyle> = Vec::new();
    for row in rows {
        let name = row.policy.split('(').next().unwrap_or_default();
        let mut style = name.parse().map_or(LineStyle::default(), line_style);
        while styles.contains(&style) && style.dashes + 1 < LineStyle::DASHES {
            style.dashes += 1;
        }
        styles.push(style);
    }
    styles
}

/// A learned policy has the color of its expert, with its own dashes; the general one has its own color.
fn line_style(policy: PolicyName) -> LineStyle {
    let of = |name: Exact| Exact::ALL.iter().position(|&other| other == name).unwrap_or(0);
    let (color, dashes) = match policy {
        PolicyName::Exact(name) => (of(name), 0),
        PolicyName::Learned(Shipped::General) => (Exact::ALL.len(), 1),
        PolicyName::Learned(Shipped::GreedyIceCreamCone) => (of(Exact::Greedy), 1),
        PolicyName::Learned(Shipped::GreedyAllTraversable) => (of(Exact::Greedy), 2),
        PolicyName::Learned(Shipped::GreedyOpenAsterisk) => (of(Exact::Greedy), 3),
        PolicyName::Learned(Shipped::GreedyFigureFour) => (of(Exact::Greedy), 4),
        PolicyName::Learned(Shipped::PathIceCreamCone) => (of(Exact::Path), 1),
        PolicyName::Learned(Shipped::PathAllTraversable) => (of(Exact::Path), 2),
        PolicyName::Learned(Shipped::Tour) => (of(Exact::Tour), 1),
    };
    LineStyle { color, dashes }
}

/// A length somewhat beyond that from which on a curve stays near its last value.
pub(crate) fn settled(curve: &MeanCurve) -> f64 {
    let last = curve.mean.len() - 1;
    let is_near = |mean: &f64| (mean - curve.mean[last]).abs() < SETTLED;
    let moving = curve.mean.iter().rposition(|mean| !is_near(mean)).unwrap_or(0);
    curve.cells[(moving + moving / 5 + 1).min(last)]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_two_policies_have_the_same_line_style() {
        let styles: BTreeSet<(usize, usize)> =
            PolicyName::all().map(line_style).map(|LineStyle { color, dashes }| (color, dashes)).collect();
        assert_eq!(styles.len(), PolicyName::all().count());
        assert!(
            styles.iter().all(|&(color, dashes)| color < LineStyle::COLORS && dashes < LineStyle::DASHES)
        );
    }
}
