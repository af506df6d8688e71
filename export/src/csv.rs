//! Segments as comma-separated values (RFC 4180), a row each, the whole search last.
//!
//! Lengths are in meters, areas in square meters, probabilities from 0 to 1. A value that is not known or has no meaning, such
//! as the area of a place, is empty.

use dragnet_coordinator::segment::SegmentRow;

/// The titles of the columns.
const TITLES: &str = "area,kind,cells,area_square_meters,poa,poa_now,pod,pos,sweep_width_meters,track_meters,\
                      effort_square_meters,coverage";

/// The text of a CSV file.
#[must_use]
pub fn text(segments: &[SegmentRow]) -> String {
    segments.iter().map(row).fold(format!("{TITLES}\r\n"), |text, row| text + &row + "\r\n")
}

fn row(row: &SegmentRow) -> String {
    let number = |value: f64| value.to_string();
    let known = |value: Option<f64>| value.map(number).unwrap_or_default();
    [
        quoted(&row.name),
        row.kind.to_owned(),
        row.cells.to_string(),
        known(row.area_square_meters),
        number(row.poa),
        known(row.poa_now),
        number(row.pod),
        number(row.pos),
        known(row.sweep_width_meters),
        known(row.track_meters),
        known(row.effort_square_meters),
        known(row.coverage),
    ]
    .join(",")
}

/// A name as a value. One that begins as a formula gets an apostrophe, so that no spreadsheet computes it.
fn quoted(name: &str) -> String {
    let guard = if name.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    format!("\"{guard}{}\"", name.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_and_no_formulas() {
        assert_eq!(quoted("Moor, \"north\""), "\"Moor, \"\"north\"\"\"");
        assert_eq!(quoted("=1+1"), "\"'=1+1\"");
    }
}
