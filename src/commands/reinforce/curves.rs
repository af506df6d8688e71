//! The progress of a reinforcement as a table and as a plot.

use csv::Writer;
use dragnet_experiments::plot::{Figure, Line, LineStyle};
use dragnet_train::Round;

/// A row for each round.
pub(super) fn table(history: &[Round]) -> Result<Vec<u8>, String> {
    let mut writer = Writer::from_writer(Vec::new());
    for round in history {
        writer.serialize(round).map_err(|error| error.to_string())?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

/// Lengths of searches by round.
pub(super) fn draw(history: &[Round]) -> Result<String, String> {
    let points = |cells: fn(&Round) -> Option<f64>| -> (Vec<f64>, Vec<f64>) {
        history.iter().filter_map(|round| Some((f64::from(round.round), cells(round)?))).unzip()
    };
    let (explored, explored_cells) = points(|round| (round.searches > 0).then_some(round.expected_cells));
    let (held_out, held_out_cells) = points(|round| round.held_out_cells);
    let unknown = vec![None; history.len()];
    let most = explored_cells.iter().chain(&held_out_cells).copied().fold(0.0, f64::max);
    let last = history.last().map_or(1.0, |round| f64::from(round.round));
    Figure {
        title: "Reinforcement".to_owned(),
        subtitle: "mean length of searches".to_owned(),
        horizontal: "Round",
        vertical: "Cells",
        length: last.max(1.0),
        height: most * 1.05,
        lines: vec![
            line("explored, expected", 0, (&explored, &explored_cells), &unknown),
            line("held out", 4, (&held_out, &held_out_cells), &unknown),
        ],
    }
    .draw()
}

/// A curve whose errors are not known.
fn line<'a>(
    label: &'a str,
    color: usize,
    (lengths, mean): (&'a [f64], &'a [f64]),
    unknown: &'a [Option<f64>],
) -> Line<'a> {
    let line_style = LineStyle { color, dashes: 0 };
    Line { label, line_style, lengths, mean, standard_error: &unknown[..lengths.len()] }
}
