//! The table of segments: how thoroughly each was searched, and with which effort.

use dragnet_coordinator::segment::SegmentRow;

use crate::terminal::table::Table;

/// The table of these segments; in a search for subjects of known number with the posterior.
pub(super) fn table(rows: &[SegmentRow]) -> String {
    let is_one = rows.iter().any(|row| row.poa_now.is_some());
    let titles = ["area", "POA", "POD", "POS"].into_iter().chain(is_one.then_some("posterior"));
    let titles = titles.chain(["W", "track", "coverage", "size", "cells"]).map(str::to_owned).collect();
    let rows = rows.iter().map(|row| texts(row, is_one));
    Table::of_rows(std::iter::once(titles).chain(rows).collect()).draw(1)
}

fn texts(row: &SegmentRow, is_one: bool) -> Vec<String> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let known = |value: Option<f64>, text: &dyn Fn(f64) -> String| value.map_or_else(|| "-".to_owned(), text);
    [row.name.escape_debug().to_string(), percent(row.poa), percent(row.pod), percent(row.pos)]
        .into_iter()
        .chain(is_one.then(|| known(row.poa_now, &percent)))
        .chain([
            known(row.sweep_width_meters, &|meters| format!("{meters:.1} m")),
            known(row.track_meters, &|meters| format!("{:.2} km", meters / 1000.0)),
            known(row.coverage, &|coverage| format!("{coverage:.2}")),
            known(row.area_square_meters, &|area| format!("{:.2} ha", area / 10_000.0)),
            row.cells.to_string(),
        ])
        .collect()
}
