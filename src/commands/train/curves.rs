//! The progress of a training as a table and as a plot.

use csv::Writer;
use dragnet_experiments::plot::{Figure, Line, LineStyle};
use dragnet_train::Epoch;

/// A row for each epoch.
pub(super) fn table(history: &[Epoch]) -> Result<Vec<u8>, String> {
    let mut writer = Writer::from_writer(Vec::new());
    let titles = ["epoch", "loss", "held_out_loss", "held_out_accuracy", "held_out_regret", "seconds"];
    writer.write_record(titles).map_err(|error| error.to_string())?;
    for epoch in history {
        let held_out = epoch.held_out;
        let row = (epoch.epoch, epoch.loss, held_out.loss, held_out.accuracy, held_out.regret, epoch.seconds);
        writer.serialize(row).map_err(|error| error.to_string())?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

/// Losses by epoch.
pub(super) fn draw(history: &[Epoch]) -> Result<String, String> {
    let epochs: Vec<f64> = history.iter().map(|epoch| f64::from(epoch.epoch)).collect();
    let learned: Vec<f64> = history.iter().map(|epoch| epoch.loss).collect();
    let held_out: Vec<f64> = history.iter().map(|epoch| epoch.held_out.loss).collect();
    let unknown = vec![None; history.len()];
    let line = |label, color, mean| Line {
        label,
        line_style: LineStyle { color, dashes: 0 },
        lengths: &epochs,
        mean,
        standard_error: &unknown,
    };
    let most = learned.iter().chain(&held_out).copied().fold(0.0, f64::max);
    Figure {
        title: "Behavior cloning".to_owned(),
        subtitle: "cross-entropy against the expert".to_owned(),
        horizontal: "Epoch",
        vertical: "Loss (nats)",
        length: epochs.last().copied().unwrap_or(1.0).max(1.0),
        height: most * 1.05,
        lines: vec![line("learned", 0, &learned), line("held out", 4, &held_out)],
    }
    .draw()
}
