//! Runs the detector over the files.

use std::fmt;
use std::path::Path;
use std::time::Instant;

use dragnet_detector::FindError;
use dragnet_detector::network::NetworkError;
use dragnet_runtime::vehicle::detector;

use super::report::{Report, Seen};
use super::{Arguments, Input, Resolution, camera, drawing, photo};
use crate::commands::eyes::YoloDetector;
use crate::commands::{Failure, output};
use crate::terminal;

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let csv = arguments.csv.as_deref().map(|path| output::free("--csv", path, "no table is")).transpose()?;
    let save = arguments.save.as_deref();
    let save = save.map(|path| output::free("--save", path, "no image is")).transpose()?;
    if save.is_some() && arguments.images.len() > 1 {
        return Err(Failure::Input(format!(
            "--save: for one image only, and here are {}",
            arguments.images.len()
        )));
    }
    let table = arguments.camera.as_deref().map(camera::read).transpose()?;
    let eyes = YoloDetector::open(&settings(arguments))
        .map_err(|problem| Failure::Input(problem.with_keys("--")))?;
    let mut report = Report::new(&arguments.module, &eyes.network, &eyes.settings, table);
    for path in &arguments.images {
        let image = photo::read(path)?;
        let start = Instant::now();
        let found = eyes.find(image.width(), image.height(), &image).map_err(|error| failed(path, &error))?;
        let seconds = start.elapsed().as_secs_f64();
        if let Some(save) = &save {
            let drawn = drawing::png(image.clone(), &found).map_err(|error| Failure::run(of(save, error)))?;
            output::write(save, &drawn)?;
        }
        report.push(&Seen {
            path,
            width_pixels: image.width(),
            height_pixels: image.height(),
            found,
            seconds,
        })?;
    }
    if let Some(csv) = &csv {
        output::write(csv, &report.csv().map_err(Failure::run)?)?;
    }
    if arguments.json {
        return Ok(terminal::print_json(&report)?);
    }
    terminal::print(&report.text())?;
    for path in [csv, save].iter().flatten() {
        terminal::print(&format!("written: {}\n", path.display()))?;
    }
    Ok(())
}

fn settings(arguments: &Arguments) -> detector::Settings {
    detector::Settings {
        module: arguments.module.clone(),
        classes: arguments.classes.clone(),
        confidence: arguments.confidence,
        iou: arguments.iou,
        class_agnostic: arguments.class_agnostic,
        resolution: match arguments.resolution {
            Resolution::Half => detector::Resolution::Half,
            Resolution::Full => detector::Resolution::Full,
        },
        input: arguments.input.map(|Input { columns, rows }| [columns, rows]),
        threads: arguments.threads,
        cpu: arguments.cpu,
    }
}

/// A failure of the module is not a mistake in the command line.
fn failed(path: &Path, error: &NetworkError) -> Failure {
    let message = of(path, error);
    match error {
        NetworkError::Run { .. } | NetworkError::Find(FindError::Output(_) | FindError::TooManyBoxes) => {
            Failure::Run(message)
        }
        _ => Failure::Input(message),
    }
}

fn of(path: &Path, message: impl fmt::Display) -> String {
    format!("{}: {message}", path.display())
}
