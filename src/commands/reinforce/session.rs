//! A reinforcement, from weights to weights.

use std::fs;
use std::time::{Duration, Instant};

use dragnet_experiments::reinforcement::Searches;
use dragnet_experiments::seeds::Seeds;
use dragnet_learn::policy::Shipped;
use dragnet_learn::weights::Weights;
use dragnet_train::{Device, Reinforcement, Reinforcer, Round, set_threads};

use super::{Arguments, curves};
use crate::VERSION;
use crate::commands::training::{
    Files, check_learning_rate, check_positive, check_share, start_anew_with_allocator,
};
use crate::commands::{Failure, complain, output};
use crate::terminal::{self, progress::Bars};

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let files = Files::beside(&arguments.out)?;
    start_anew_with_allocator();
    let start = start(arguments)?;
    let settings = settings(arguments, &start)?;
    set_threads(arguments.threads);
    let device = if arguments.cpu { Device::Cpu } else { Device::cuda_if_available() };
    // One that is too large would end the last round.
    arguments.seeds.of_mixture().map_err(|error| Failure::Input(format!("--seeds: {error}")))?;
    let held_out = Searches::new(arguments.validation_seeds, Some(arguments.threads))
        .map_err(|error| Failure::Input(format!("--validation-seeds: {error}")))?;
    if held_out.is_empty() {
        return Err(Failure::Input(format!(
            "--validation-seeds: none of {} has a search of one robot",
            arguments.validation_seeds
        )));
    }
    let mut reinforcer = if files.checkpoint.exists() {
        complain("note", &format!("going on from {}", files.checkpoint.display()));
        Reinforcer::resume(start, settings, device, VERSION, &files.checkpoint).map_err(Failure::input)?
    } else {
        Reinforcer::new(start, settings, device, VERSION)
    };
    if reinforcer.history().is_empty() {
        let cells = held_out.mean_cells(&reinforcer.network().map_err(Failure::Run)?, &Bars)?;
        reinforcer.start_measured(cells);
        terminal::print(&format!("start: held out {cells:.2} cells in {} searches\n", held_out.len()))?;
    }
    while !reinforcer.is_done() {
        round(&mut reinforcer, arguments, &held_out)?;
        reinforcer.checkpoint(&files.checkpoint).map_err(Failure::run)?;
        files.write_curves(curves::table(reinforcer.history()), curves::draw(reinforcer.history()))?;
    }
    let weights = reinforcer.best().to_bytes().map_err(Failure::Run)?;
    output::write(&arguments.out, &weights)?;
    // Its contents are in the weights now, and a remaining checkpoint would block the next reinforcement.
    let _ = fs::remove_file(&files.checkpoint);
    terminal::print(&format!(
        "best after {} searches of its own\nwritten: {}, {}, {}\n",
        reinforcer.best().recipe().own_searches.unwrap_or(0),
        arguments.out.display(),
        files.metrics.display(),
        files.curves.display(),
    ))?;
    Ok(())
}

fn round(reinforcer: &mut Reinforcer, arguments: &Arguments, held_out: &Searches) -> Result<(), Failure> {
    let begun = Instant::now();
    let number = reinforcer.rounds_done();
    let seeds = of_round(arguments.seeds, number, arguments.rounds);
    let searches = Searches::new(seeds, Some(arguments.threads))?;
    let network = reinforcer.network().map_err(Failure::Run)?;
    let explored = searches.explore(&network, arguments.temperature, &Bars)?;
    let exploring = Duration::as_secs_f64(&begun.elapsed());
    reinforcer.learn(&explored).map_err(Failure::Run)?;
    let is_last = number + 1 == arguments.rounds;
    if is_last || (number + 1).is_multiple_of(arguments.validation_every) {
        let network = reinforcer.network().map_err(Failure::Run)?;
        let cells = held_out.mean_cells(&network, &Bars)?;
        reinforcer.measured(cells).map_err(Failure::Run)?;
    }
    reinforcer.took(begun.elapsed());
    let round = reinforcer.history().last();
    Ok(terminal::print(&round.map(|round| described(round, exploring)).unwrap_or_default())?)
}

fn described(round: &Round, exploring: f64) -> String {
    let held_out =
        round.held_out_cells.map_or_else(String::new, |cells| format!("; held out: {cells:.2} cells"));
    format!(
        "round {}: {} searches, {} decisions, {:.2} cells, {:.3} of tour, advantage {:.2} +- {:.2}, probability {:.3}{held_out} ({:.0} s, {exploring:.0} s of them exploring)\n",
        round.round,
        round.searches,
        round.decisions,
        round.expected_cells,
        round.of_tour,
        round.advantage,
        round.advantage_deviation,
        round.probability,
        round.seconds,
    )
}

/// The seeds of a round: as many for each, and in order.
fn of_round(seeds: Seeds, number: u32, rounds: u32) -> Seeds {
    let (number, rounds) = (u64::from(number), u64::from(rounds));
    let first = seeds.count() * number / rounds;
    seeds.part(first, seeds.count() * (number + 1) / rounds - first)
}

fn start(arguments: &Arguments) -> Result<Weights, Failure> {
    let weights = match &arguments.start {
        Some(path) => Weights::load(path).map_err(Failure::input)?,
        None => Weights::from_bytes(Shipped::Tour.weights()).map_err(Failure::Run)?,
    };
    Ok(weights)
}

fn settings(arguments: &Arguments, start: &Weights) -> Result<Reinforcement, Failure> {
    check_learning_rate(arguments.learning_rate)?;
    check_positive("temperature", arguments.temperature)?;
    check_share("trace", arguments.trace)?;
    if arguments.seeds.count() < u64::from(arguments.rounds) {
        let rounds = arguments.rounds;
        return Err(Failure::Input(format!(
            "--seeds: {}; allowed are at least as many as --rounds, {rounds}",
            arguments.seeds
        )));
    }
    Ok(Reinforcement {
        seed: arguments.seed,
        rounds: arguments.rounds,
        passes: arguments.passes,
        batch: arguments.batch.into(),
        learning_rate: arguments.learning_rate,
        temperature: arguments.temperature,
        trace: arguments.trace,
        seeds: format!("{}, held out {}", arguments.seeds, arguments.validation_seeds),
        start: dragnet_experiments::demonstrations::digest(start).map_err(Failure::Run)?,
    })
}
