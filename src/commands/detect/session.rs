//! From files to what is found in them.

use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;
use std::time::Instant;

use dragnet_detector::network::{Device, Network, NetworkError, set_threads};
use dragnet_detector::picture::{Picture, PixelFormat, Size};
use dragnet_detector::settings::{Classes, Resolution, Settings, Suppression};
use dragnet_detector::{FindError, Found};
use dragnet_learn::file;

use super::report::{Report, Seen};
use super::{Arguments, camera, drawing, photo};
use crate::commands::{Failure, output};
use crate::terminal;

/// The largest networks of the family have a quarter of it.
const MOST_BYTES: u64 = 1 << 30;

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
    let rig = arguments.camera.as_deref().map(camera::Rig::read).transpose()?;
    let network = network(arguments)?;
    let settings = settings(arguments, &network)?;
    let mut report = Report::new(&arguments.module, &network, &settings, rig);
    for path in &arguments.images {
        let image = photo::read(path)?;
        let start = Instant::now();
        let found = detect(&network, &image, &settings).map_err(|error| failed(path, &error))?;
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

fn network(arguments: &Arguments) -> Result<Network, Failure> {
    set_threads(arguments.threads);
    let device = if arguments.cpu { Device::Cpu } else { Device::cuda_if_available() };
    let path = &arguments.module;
    let bytes = file::read_at_most(path, MOST_BYTES)
        .map_err(|error| Failure::Input(of(path, format!("cannot read it: {error}"))))?;
    let input = arguments.input.map(|input| Size { width_pixels: input.columns, height_pixels: input.rows });
    Network::load(&bytes, input, device).map_err(|error| {
        let hint = if matches!(error, NetworkError::NoInput) { " by --input" } else { "" };
        Failure::Input(of(path, format!("{error}{hint}")))
    })
}

fn settings(arguments: &Arguments, network: &Network) -> Result<Settings, Failure> {
    let classes: BTreeSet<u32> =
        arguments.classes.iter().map(|class| self::class(class, network)).collect::<Result<_, _>>()?;
    let classes = if classes.is_empty() { Classes::All } else { Classes::Only(classes) };
    let suppression = if arguments.agnostic { Suppression::Agnostic } else { Suppression::ByClass };
    let resolution = match arguments.resolution {
        super::Resolution::Half => Resolution::Half,
        super::Resolution::Full => Resolution::Full,
    };
    let (confidence, overlap) = (arguments.confidence, arguments.overlap);
    Ok(Settings { confidence, overlap, classes, suppression, resolution })
}

/// By its name in the module's file or, where no class is called that, by its number.
fn class(text: &str, network: &Network) -> Result<u32, Failure> {
    let number = || text.parse().ok().filter(|class| *class < network.classes());
    network.class_named(text).or_else(number).ok_or_else(|| {
        const MOST_NAMES: u32 = 20;
        let names: Vec<&str> =
            (0..network.classes().min(MOST_NAMES)).filter_map(|class| network.name(class)).collect();
        let and = if names.is_empty() { "" } else { ", or " };
        let more = if names.len() < network.classes() as usize && !names.is_empty() { ", .." } else { "" };
        let last = network.classes() - 1;
        Failure::Input(format!("--classes {text}: allowed are 0 to {last}{and}{}{more}", names.join(", ")))
    })
}

fn detect(network: &Network, image: &image::RgbImage, settings: &Settings) -> Result<Found, NetworkError> {
    let size = Size { width_pixels: image.width(), height_pixels: image.height() };
    let picture =
        Picture::new(size, PixelFormat::Rgb8, image).map_err(|error| NetworkError::Prepare(error.into()))?;
    network.detect(&picture, settings)
}

/// What the module did is no fault of the command line.
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
