//! What a comparison writes: tables as CSV, curves as SVG.

use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};

use csv::Writer;
use dragnet_search::policy::PolicyName;

use super::row::{MeanCurve, Row};
use super::seeds::Seeds;
use crate::commands::Failure;
use crate::plot::{Figure, Line};
use crate::terminal::counted;

/// F1 that a curve may be off its last value where it is settled.
const SETTLED: f64 = 0.005;

/// Makes the folder, so that it is not missing after hours of work.
pub(super) fn prepare(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| {
        Failure::Input(format!("--out {}: cannot make the folder: {error}", folder.display()))
    })
}

/// Writes all files; returns which.
pub(super) fn write(folder: &Path, rows: &[Row], seeds: Seeds) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    let mut keep = |name: String, content: Vec<u8>| {
        let path = folder.join(name);
        fs::write(&path, content).map_err(|error| failure(&path, error))?;
        written.push(path);
        Ok::<(), Failure>(())
    };
    for (name, table) in
        [("summary.csv", summary(rows)), ("episodes.csv", episodes(rows)), ("curves.csv", curves(rows))]
    {
        keep(name.to_owned(), table.map_err(|error| failure(&folder.join(name), error))?)?;
    }
    for rows in rows.chunk_by(|a, b| a.scenario == b.scenario) {
        let name = format!("{}.svg", rows[0].scenario);
        let drawing = figure(rows, seeds).draw().map_err(|error| failure(&folder.join(&name), error))?;
        keep(name, drawing.into_bytes())?;
    }
    Ok(written)
}

fn failure(path: &Path, error: impl Display) -> Failure {
    Failure::Run(format!("{}: cannot write: {error}", path.display()))
}

/// A row a scenario and policy.
fn summary(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "scenario",
        "map",
        "policy",
        "robots",
        "seeds",
        "budget_cells",
        "auc_f1_mean",
        "auc_f1_sem",
        "cells_to_full_recall_mean",
        "cells_to_full_recall_sem",
        "cells_to_full_recall_reached",
        "decision_ms_p50",
        "decision_ms_p99",
    ];
    table(titles, |writer| {
        rows.iter().try_for_each(|row| {
            let full = &row.cells_to_full_recall;
            writer.serialize((
                (&row.scenario, &row.map, row.policy, row.robots, row.seeds, row.budget_cells),
                (row.auc_f1.mean, row.auc_f1.sem, full.mean, full.sem, full.reached),
                (row.decision_ms.p50, row.decision_ms.p99),
            ))
        })
    })
}

/// A row an episode.
fn episodes(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let titles = [
        "scenario",
        "policy",
        "robots",
        "seed",
        "auc_f1",
        "cells_to_full_recall",
        "f1_at_end",
        "recall_at_end",
        "cells_at_end",
    ];
    table(titles, |writer| {
        rows.iter().flat_map(|row| row.trials.iter().map(move |trial| (row, trial))).try_for_each(
            |(row, trial)| {
                writer.serialize((
                    (&row.scenario, row.policy, row.robots, trial.seed),
                    (trial.auc_f1, trial.cells_to_full_recall, trial.f1, trial.recall, trial.farthest_cells),
                ))
            },
        )
    })
}

/// A row a point of a curve.
fn curves(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    table(["scenario", "policy", "cells", "f1_mean", "f1_sem"], |writer| {
        for row in rows {
            let curve = &row.curve;
            for ((cells, mean), sem) in curve.cells.iter().zip(&curve.mean).zip(&curve.sem) {
                writer.serialize((&row.scenario, row.policy, cells, mean, sem))?;
            }
        }
        Ok(())
    })
}

fn table<const COLUMNS: usize>(
    titles: [&str; COLUMNS],
    fill: impl FnOnce(&mut Writer<Vec<u8>>) -> Result<(), csv::Error>,
) -> Result<Vec<u8>, csv::Error> {
    let mut writer = Writer::from_writer(Vec::new());
    writer.write_record(titles)?;
    fill(&mut writer)?;
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

/// The curves of one scenario.
fn figure(rows: &[Row], seeds: Seeds) -> Figure<'_> {
    let lines = rows.iter().map(|row| Line {
        label: row.policy,
        color: PolicyName::ALL.iter().position(|policy| policy.as_str() == row.policy).unwrap_or(0),
        lengths: &row.curve.cells,
        mean: &row.curve.mean,
        standard_error: &row.curve.sem,
    });
    let robots = counted(rows[0].robots, "robot");
    Figure {
        title: rows[0].scenario.replace('_', " "),
        subtitle: format!("{}, {robots}; mean and standard error of {seeds}", rows[0].objects),
        horizontal: "Path length of the farthest robot (cells)",
        vertical: "F1",
        length: rows.iter().map(|row| settled(&row.curve)).fold(0.0, f64::max),
        lines: lines.collect(),
    }
}

/// The length somewhat beyond that from which on a curve stays near its last value: what is left is not worth drawing.
fn settled(curve: &MeanCurve) -> f64 {
    let last = curve.mean.len() - 1;
    let is_near = |mean: &f64| (mean - curve.mean[last]).abs() < SETTLED;
    let moving = curve.mean.iter().rposition(|mean| !is_near(mean)).unwrap_or(0);
    curve.cells[(moving + moving / 5 + 1).min(last)]
}
