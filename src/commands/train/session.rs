//! A training run, from demonstrations to weights.

use std::fs;

use dragnet_learn::demonstration::Folder;
use dragnet_learn::shape::Shape;
use dragnet_train::{Data, DataError, Device, Settings, Spread, Trainer, set_threads};

use super::{Arguments, curves};
use crate::VERSION;
use crate::commands::training::{
    Files, check, check_learning_rate, check_positive, check_share, start_anew_with_allocator,
};
use crate::commands::{Failure, complain, output};
use crate::terminal::{self, progress};

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let settings = settings(arguments)?;
    let files = Files::beside(&arguments.out)?;
    start_anew_with_allocator();
    set_threads(arguments.threads);
    let device = if arguments.cpu { Device::Cpu } else { Device::cuda_if_available() };
    let folder = Folder::open(&arguments.demonstrations).map_err(Failure::input)?;
    let spread = match arguments.score_temperature {
        Some(temperature) => Spread::Temperature(temperature),
        None => Spread::Power(arguments.target_exponent),
    };
    let data =
        Data::load(&folder, arguments.validation_every.into(), spread, settings.shape).map_err(|error| {
            match error {
                DataError::Memory { .. } => Failure::run(error),
                _ => Failure::input(error),
            }
        })?;
    let mut trainer = if files.checkpoint.exists() {
        complain("note", &format!("going on from {}", files.checkpoint.display()));
        Trainer::resume(&data, settings, device, VERSION, &files.checkpoint).map_err(Failure::input)?
    } else {
        Trainer::new(&data, settings, device, VERSION).map_err(Failure::Input)?
    };
    terminal::print(&format!(
        "{} decisions of {} to learn from, {} held out, on {}\n",
        data.len(),
        data.source().expert,
        data.held_out_len(),
        if device == Device::Cpu { "the CPU" } else { "a GPU" },
    ))?;
    while !trainer.is_done() {
        epoch(&mut trainer)?;
        trainer.checkpoint(&files.checkpoint).map_err(Failure::run)?;
        files.write_curves(curves::table(trainer.history()), curves::draw(trainer.history()))?;
    }
    let weights = trainer.best().to_bytes().map_err(Failure::Run)?;
    output::write(&arguments.out, &weights)?;
    // Its contents are in the weights now, and a remaining checkpoint would block the next training.
    let _ = fs::remove_file(&files.checkpoint);
    let best = trainer.best().recipe();
    terminal::print(&format!(
        "best at epoch {}, held-out loss {:.4}\nwritten: {}, {}, {}\n",
        best.epochs,
        best.held_out_loss,
        arguments.out.display(),
        files.metrics.display(),
        files.curves.display(),
    ))?;
    Ok(())
}

fn epoch(trainer: &mut Trainer<'_>) -> Result<(), Failure> {
    let bar = progress::alone(trainer.decisions() as u64, "decisions");
    let epoch = trainer.epoch(|decisions| bar.inc(decisions as u64)).map_err(Failure::Run)?;
    bar.finish_and_clear();
    let held_out = epoch.held_out;
    Ok(terminal::print(&format!(
        "epoch {}: loss {:.4}; held out: loss {:.4}, same choice {:.1} %, regret {:.2} % ({:.0} s)\n",
        epoch.epoch,
        epoch.loss,
        held_out.loss,
        held_out.accuracy * 100.0,
        held_out.regret * 100.0,
        epoch.seconds,
    ))?)
}

fn settings(arguments: &Arguments) -> Result<Settings, Failure> {
    let shape = Shape {
        hidden: arguments.hidden,
        layers: arguments.layers,
        decay_channels: arguments.decay_channels,
        sum_channels: arguments.sum_channels,
        levels: arguments.levels,
        coarse_channels: if arguments.levels > 0 { arguments.coarse_channels } else { 0 },
        coarse_layers: if arguments.levels > 0 { arguments.coarse_layers } else { 0 },
    };
    if !shape.is_valid() {
        let allowed = "--hidden is a multiple of 32 up to 1024, --layers 1 to 64, --decay-channels up to 1024, --sum-channels up to 256, \
                       --levels up to 8, --coarse-channels as --hidden, --coarse-layers 1 to 64";
        return Err(Failure::Input(format!("no network has these sizes: {allowed}")));
    }
    check_learning_rate(arguments.learning_rate)?;
    check_share("choice-weight", arguments.choice_weight)?;
    let exponent = arguments.target_exponent;
    check("target-exponent", exponent, (1.0..=10_000.0).contains(&exponent), "a number from 1 to 10000")?;
    if let Some(temperature) = arguments.score_temperature {
        check_positive("score-temperature", temperature)?;
    }
    Ok(Settings {
        shape,
        seed: arguments.seed,
        batch: arguments.batch.into(),
        epochs: arguments.epochs,
        learning_rate: arguments.learning_rate,
        patience: arguments.patience,
        choice_weight: arguments.choice_weight,
    })
}
