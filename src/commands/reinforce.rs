//! `dragnet reinforce`: trains a network on its own searches.

#[cfg(feature = "train")]
mod curves;
#[cfg(feature = "train")]
mod session;

use std::path::PathBuf;

use dragnet_experiments::seeds::Seeds;

use super::{Failure, scenario};

/// Train a network further, on its own searches.
///
/// In rounds: the network searches generated scenarios, with choices that it draws, and learns from those that made its
/// searches shorter or longer. Start from a network that imitates `tour`, whose expectation each decision is compared
/// with. Beside the weights of the best round it writes FILE.metrics.csv and FILE.svg, and, until it is done,
/// FILE.checkpoint: the same command continues from there if it was interrupted. On the same kind of computer the same
/// options and weights give the same weights, to the bit.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet reinforce --out tour.safetensors
  dragnet reinforce --start first.safetensors --rounds 50 --out second.safetensors
  dragnet compare open_asterisk --policies gnn-tour,gnn --weights tour.safetensors")]
pub(crate) struct Arguments {
    /// Weights file of the network to start from [default: the built-in gnn-tour]
    #[arg(long, value_name = "FILE")]
    start: Option<PathBuf>,
    /// Write the weights to this file, which must not exist
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Seeds of the generated scenarios, those of `demonstrate --mixture`: divided among the rounds, and those with a
    /// team are passed over; N for 0 to N - 1, or A..B for A to B - 1
    #[arg(long, value_name = "N | A..B", default_value = "3000000..3010000", allow_negative_numbers = true)]
    seeds: Seeds,
    /// Seeds of the scenarios that only measure what has been learned
    #[arg(long, value_name = "N | A..B", default_value = "6000..6300", allow_negative_numbers = true)]
    validation_seeds: Seeds,
    /// Number of rounds between two measurements, at least 1
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    validation_every: u32,
    /// Number of rounds, 1 to 60000
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=60_000), allow_negative_numbers = true)]
    rounds: u32,
    /// Number of passes over the decisions of a round, at least 1
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    passes: u32,
    /// Number of decisions per training step, 1 to 65535
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    batch: u16,
    /// Initial learning rate of Adam, above 0 to 1; it falls to 0 along half a cosine
    #[arg(long, value_name = "R", default_value_t = 3e-4, allow_negative_numbers = true)]
    learning_rate: f64,
    /// Temperature at which choices are drawn, above 0: the lower, the rarer are others than the best
    #[arg(long, value_name = "T", default_value_t = 0.1, allow_negative_numbers = true)]
    temperature: f64,
    /// How far a decision answers for what follows it, 0 to 1: 0 for the path to its own waypoint, which is to
    /// imitate `tour`, 1 for all of the search
    #[arg(long, value_name = "SHARE", default_value_t = 0.8, allow_negative_numbers = true)]
    trace: f64,
    /// Seed of the order of decisions: a whole number from 0
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = scenario::parse_seed, allow_negative_numbers = true)]
    seed: u64,
    /// Number of searches to run in parallel, and of libtorch's threads, 1 to 1024. With more than one, the last bits of
    /// the weights may differ from run to run
    #[arg(long, value_name = "T", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Train on the CPU even if libtorch finds a GPU
    #[arg(long)]
    cpu: bool,
}

#[cfg(feature = "train")]
pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    session::run(arguments)
}

#[cfg(not(feature = "train"))]
pub(super) fn execute(_: &Arguments) -> Result<(), Failure> {
    Err(super::train::built_without())
}
