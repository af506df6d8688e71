//! A comparison on the page: its curves, the table of its measures, and its numbers as files.

use dragnet_learn::policy::PolicyName;

use super::map::Map;
use super::markup::{Markup, Table};
use super::measure::{self, Gap};
use super::part::Part;
use super::section::File;
use super::study::{Comparison, Panel};
use crate::ExperimentError;
use crate::comparison::{Row, estimate, files};
use crate::plot::Figure;

/// Curves are drawn up to this multiple of the path length at which the expert's is settled; tables cover the rest.
const DRAWN: f64 = 2.0;

/// The curves of all four maps, on the page and as files.
pub(super) struct Curves {
    pub(super) figure: Markup,
    pub(super) files: Vec<File>,
}

/// The curves of all four maps, up to a multiple of the path length at which the expert's is settled.
pub(super) fn figure(comparison: &Comparison, part: Part, caption: &str) -> Result<Curves, ExperimentError> {
    let drawings = comparison.panels().map(|panel| {
        let mut figure = files::figure(panel.rows, comparison.seeds);
        figure.length = figure.length.min(DRAWN * files::settled(&panel.expert().curve));
        (panel.map, figure)
    });
    drawn(part, caption, drawings)
}

/// Figures of maps, drawn.
pub(super) fn drawn<'a>(
    part: Part,
    caption: &str,
    figures: impl Iterator<Item = (Map, Figure<'a>)>,
) -> Result<Curves, ExperimentError> {
    let (mut drawings, mut files) = (Vec::new(), Vec::new());
    for (map, mut figure) in figures {
        figure.title = format!("{} ({})", map.title(), map.short());
        figure.horizontal = "Path length (cells)";
        let svg = figure.draw().map_err(ExperimentError::run)?;
        let description = format!("F1 against path length on the map {}", map.title());
        drawings.push(Markup::drawing(&description, &svg));
        let name = format!("{}-{}.svg", part.as_str(), map.short().to_lowercase());
        files.push(File { name, content: svg.into_bytes() });
    }
    Ok(Curves { figure: Markup::new().figure("curves", caption, &drawings), files })
}

/// Area under F1, full recall, the gap to the expert, and where the curves are farthest apart, by map.
pub(super) fn table(comparison: &Comparison) -> Table {
    let expert = comparison.study.expert();
    let caption = format!(
        "Measures of the same episodes. The area under F1 is its mean over the way from 0 to the budget. Full recall is \
         the path length in cells until every object was found, over those seeds only that reached it. The gap is the share of \
         the difference in area between `random` and `{expert}` that a policy closes. The last column is where its mean \
         F1 is farthest from that of `{expert}`, in points of a hundred, and after how many cells. All with their \
         standard error over {}.",
        comparison.seeds
    );
    let distance = format!("F1 against `{expert}`");
    let titles = ["policy", "area under F1", "cells to full recall", "reached by", "gap closed", &distance];
    let mut table = Table::of_numbers(&caption, &titles);
    for panel in comparison.panels() {
        table.group(&format!("{} ({})", panel.map.title(), panel.map.short()));
        for row in panel.experts_first() {
            table.row(measures(panel, row));
        }
    }
    table
}

fn measures(panel: Panel<'_>, row: &Row) -> Vec<String> {
    let (full, expert) = (&row.cells_to_full_recall, panel.expert());
    let distance = (row.policy != expert.policy).then(|| measure::largest_difference(row, expert));
    vec![
        format!("`{}`", row.policy),
        estimate(Some(row.auc_f1.mean), row.auc_f1.sem, 3),
        estimate(full.mean, full.sem, 1),
        format!("{} of {}", full.reached, row.seeds),
        measure::percent(measure::share_closed(row, panel.random(), expert)),
        distance.as_ref().map_or_else(|| "-".to_owned(), Gap::to_string),
    ]
}

/// One measure of all policies that are compared on every map: a row for each policy, a column for each map.
pub(super) fn by_policy(
    comparison: &Comparison,
    caption: &str,
    label: impl Fn(Panel<'_>, &Row) -> String,
) -> Table {
    let maps = Map::ALL.map(Map::short);
    let titles: Vec<&str> = ["policy"].into_iter().chain(maps).collect();
    let mut table = Table::of_numbers(caption, &titles);
    let panels: Vec<Panel<'_>> = comparison.panels().collect();
    let rows: Vec<Vec<&Row>> = panels.iter().map(|panel| panel.experts_first().collect()).collect();
    for place in 0..rows[0].len() {
        let mut cells = vec![format!("`{}`", rows[0][place].policy)];
        cells.extend(panels.iter().zip(&rows).map(|(&panel, rows)| label(panel, rows[place])));
        table.row(cells);
    }
    table
}

/// The difference of the area under F1 to the expert's.
pub(super) fn against_expert(comparison: &Comparison) -> Table {
    let caption = format!(
        "How far the area under F1 is above that of `{}`, in points of a hundred. Clones are named after the map that \
         they were trained on: `gnn-greedy` on ICC, `-oa` on OA, `-four` on Four, `-at` on AT.",
        comparison.study.expert()
    );
    by_policy(comparison, &caption, |panel, row| {
        measure::signed(measure::area_points(row, panel.expert()), 2)
    })
}

/// The path length until every object was found.
pub(super) fn full_recall(comparison: &Comparison) -> Table {
    let caption = "Cells to full recall: the path length until every object was found, over those seeds only that reached it (in \
                   brackets, how many).";
    by_policy(comparison, caption, |_, row| {
        let full = &row.cells_to_full_recall;
        format!("{} ({})", estimate(full.mean, full.sem, 1), full.reached)
    })
}

/// The share of the gap to the expert that is closed.
pub(super) fn gap_closed(comparison: &Comparison) -> Table {
    let caption = format!(
        "Gap closed: the share of the difference in area under F1 between `random` and `{}`.",
        comparison.study.expert()
    );
    by_policy(comparison, &caption, |panel, row| {
        measure::percent(measure::share_closed(row, panel.random(), panel.expert()))
    })
}

/// Summary and episodes.
pub(super) fn tables(comparison: &Comparison, part: Part) -> Result<Vec<File>, ExperimentError> {
    let rows = &comparison.rows;
    Ok(vec![file(part, "summary", files::summary(rows))?, file(part, "episodes", files::episodes(rows))?])
}

/// Summary, episodes, curves and drawings.
pub(super) fn files(
    comparison: &Comparison,
    part: Part,
    drawings: Vec<File>,
) -> Result<Vec<File>, ExperimentError> {
    let mut all = tables(comparison, part)?;
    all.push(file(part, "curves", files::curves(&comparison.rows))?);
    all.extend(drawings);
    Ok(all)
}

/// A table of a part, as a file.
pub(super) fn file(
    part: Part,
    name: &str,
    table: Result<Vec<u8>, csv::Error>,
) -> Result<File, ExperimentError> {
    Ok(File { name: format!("{}-{name}.csv", part.as_str()), content: table.map_err(ExperimentError::run)? })
}

/// `ICC +0.1 ± 0.2, OA ...`: a measure of every map.
pub(super) fn by_map(comparison: &Comparison, label: impl Fn(Panel<'_>) -> String) -> String {
    let each = comparison.panels().map(|panel| format!("{} {}", panel.map.short(), label(panel)));
    each.collect::<Vec<_>>().join(", ")
}

/// The clones of `greedy`, and the map that each was trained on.
pub(super) fn greedy_clones() -> [(Map, PolicyName); 4] {
    Map::ALL.map(|map| (map, PolicyName::Learned(map.greedy_clone())))
}
