//! `dragnet calibrate`: fits the sensor model to labeled detector scores.

use std::path::{Path, PathBuf};

use csv::Reader;
use dragnet_experiments::plot::{Figure, Line, LineStyle};
use dragnet_files::read_text_at_most;
use dragnet_search::sensor;
use dragnet_vehicle::calibration::{self, AtDistance, Calibration, Estimate, LabeledReading};
use serde::Deserialize;

use super::{Failure, output};
use crate::terminal;
use crate::terminal::table::Table;

/// Fit the sensor model to a detector's scores of labeled cells.
///
/// The file is a CSV table with the columns distance (cells, Manhattan), object (1 if the cell holds an object, else 0)
/// and value (the detector's score: 1 is an object, 0 an empty cell). The model's variance at distance d is v d^2, with
/// the noise variance v.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  dragnet calibrate scores.csv --plot fit.svg")]
pub(crate) struct Arguments {
    /// The table of labeled scores (CSV)
    file: PathBuf,
    /// Draw the variance by distance, measured and fitted, to this file (SVG), which must not exist
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let plot =
        arguments.plot.as_deref().map(|path| output::free("--plot", path, "no drawing is")).transpose()?;
    let readings = read(&arguments.file)?;
    let failed = |error| Failure::Input(format!("{}: {error}", arguments.file.display()));
    let calibration = calibration::calibrate(&readings).map_err(failed)?;
    terminal::print(&tell(&calibration))?;
    if let Some(path) = plot {
        let svg = draw(&calibration).map_err(Failure::run)?;
        output::write(&path, svg.as_bytes())?;
        terminal::print(&format!("written: {}\n", path.display()))?;
    }
    Ok(())
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    distance: u32,
    object: u8,
    value: f32,
}

/// The maximum size of the table, bytes.
const MAX_BYTES: u64 = 1 << 28;

fn read(path: &Path) -> Result<Vec<LabeledReading>, Failure> {
    let failed = |reason: String| Failure::Input(format!("{}: {reason}", path.display()));
    let text = read_text_at_most(path, MAX_BYTES);
    let text = text.map_err(|error| failed(format!("cannot read it: {error}")))?;
    let mut reader = Reader::from_reader(text.as_bytes());
    let rows = reader.deserialize::<Row>().map(|row| {
        let Row { distance, object, value } = row.map_err(|error| failed(error.to_string()))?;
        if object > 1 {
            return Err(failed(format!("object is {object}; allowed are 0 and 1")));
        }
        Ok(LabeledReading { distance, is_object: object == 1, value })
    });
    rows.collect()
}

fn tell(calibration: &Calibration) -> String {
    let model = |distance| sensor::variance(calibration.noise_variance.value, distance);
    let mut table = Table::new(["distance", "readings", "bias", "variance", "model"]);
    for at in &calibration.by_distance {
        let (bias, variance) = (show(at.bias), show(at.variance));
        table.push([
            at.distance.to_string(),
            at.readings.to_string(),
            bias,
            variance,
            format!("{:.5}", model(at.distance)),
        ]);
    }
    let own = calibration.own_cell_variance.map_or_else(
        || "of the own cell there were too few readings for a variance".to_owned(),
        |own| format!("the own cell's variance is {}, the model's {:.5}", show(own), model(0)),
    );
    format!(
        "{}\n[sensor]\nnoise_variance = {:.6} # standard error {:.6}\n\n{own}\n",
        table.draw(0),
        calibration.noise_variance.value,
        calibration.noise_variance.standard_error
    )
}

fn show(estimate: Estimate) -> String {
    format!("{:.5} ± {:.5}", estimate.value, estimate.standard_error)
}

fn draw(calibration: &Calibration) -> Result<String, String> {
    let around: Vec<_> = calibration.by_distance.iter().filter(|at| at.distance > 0).collect();
    let distances: Vec<f64> = around.iter().map(|at| f64::from(at.distance)).collect();
    let measured: Vec<f64> = around.iter().map(|at| at.variance.value).collect();
    let errors: Vec<Option<f64>> = around.iter().map(|at| Some(at.variance.standard_error)).collect();
    let fitted = |noise_variance| {
        let variance = |at: &&AtDistance| f64::from(sensor::variance(noise_variance, at.distance));
        around.iter().map(variance).collect::<Vec<_>>()
    };
    let (model, model_errors) =
        (fitted(calibration.noise_variance.value), fitted(calibration.noise_variance.standard_error));
    let model_errors: Vec<Option<f64>> = model_errors.into_iter().map(Some).collect();
    let length = distances.last().copied().unwrap_or(1.0);
    let line = |label, color, mean, standard_error| Line {
        label,
        line_style: LineStyle { color, dashes: 0 },
        lengths: &distances,
        mean,
        standard_error,
    };
    let most = measured.iter().chain(&model).copied().fold(0.0, f64::max);
    Figure {
        title: "Sensor model".to_owned(),
        subtitle: format!("noise_variance = {}", show(calibration.noise_variance)),
        horizontal: "Distance (cells)",
        vertical: "Variance of a reading",
        length,
        height: most * 1.1,
        lines: vec![line("measured", 6, &measured, &errors), line("fitted", 4, &model, &model_errors)],
    }
    .draw()
}
