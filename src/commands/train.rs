//! `dragnet train`: trains a network on demonstrations.

#[cfg(feature = "train")]
mod curves;
#[cfg(feature = "train")]
mod session;

use std::path::PathBuf;

use super::{Failure, scenario};

/// Train a network to imitate an expert policy.
///
/// Trains on the files of `dragnet demonstrate`, and validates on some trajectories that are not trained on. Beside the
/// weights it writes FILE.metrics.csv and FILE.svg, with a row and a point for each epoch, and, until training is done,
/// FILE.checkpoint: the same command continues from there if it was interrupted. On the same kind of computer the same
/// demonstrations, options and seed give the same weights, to the bit.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dragnet train --demonstrations demonstrations --out path.safetensors
  dragnet run scenarios/ice_cream_cone.toml --policy gnn --weights path.safetensors")]
pub(crate) struct Arguments {
    /// A folder of trajectories of one expert
    #[arg(long, value_name = "DIR")]
    demonstrations: PathBuf,
    /// Write the weights to this file, which must not exist
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Seed of the initial weights and of the order of decisions: a whole number from 0
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = scenario::parse_seed, allow_negative_numbers = true)]
    seed: u64,
    /// Maximum number of epochs (passes over the demonstrations), 1 to 60000
    #[arg(long, value_name = "N", default_value_t = 14, value_parser = clap::value_parser!(u32).range(1..=60_000), allow_negative_numbers = true)]
    epochs: u32,
    /// Number of epochs without a lower validation loss after which training stops, at least 1
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    patience: u32,
    /// Number of decisions per training step, 1 to 65535
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    batch: u16,
    /// Initial learning rate of Adam, above 0 to 1; it falls to 0 along half a cosine
    #[arg(long, value_name = "R", default_value_t = 3e-3, allow_negative_numbers = true)]
    learning_rate: f64,
    /// Use every N-th trajectory for validation instead of training, 2 to 65535
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(2..), allow_negative_numbers = true)]
    validation_every: u16,
    /// Weight of the expert's choice in the training target, 0 to 1 (1 in the paper's Eq. 5). The rest is spread over
    /// cells in proportion to a power of the expert's scores, which distinguish near ties from mistakes
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, allow_negative_numbers = true)]
    choice_weight: f64,
    /// The power of the expert's scores by which the rest of the training target is spread, 1 to 10000
    #[arg(long, value_name = "P", default_value_t = 60.0, allow_negative_numbers = true)]
    target_exponent: f64,
    /// Spread the rest of the training target by `exp(score / T)` instead, T above 0 in the unit of the scores: for an
    /// expert whose scores differ by how much better a choice is, such as `tour`, whose scores are cells
    #[arg(long, value_name = "T", conflicts_with = "target_exponent", allow_negative_numbers = true)]
    score_temperature: Option<f64>,
    /// Number of channels of a node, a multiple of 32 up to 1024
    #[arg(long, value_name = "N", default_value_t = 32, allow_negative_numbers = true)]
    hidden: usize,
    /// Number of attention layers, 1 to 64
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true)]
    layers: usize,
    /// Number of channels that decay along the path, 0 to 1024
    #[arg(long, value_name = "N", default_value_t = 16, allow_negative_numbers = true)]
    decay_channels: usize,
    /// Number of channels that are summed along the path, 0 to 256
    #[arg(long, value_name = "N", default_value_t = 4, allow_negative_numbers = true)]
    sum_channels: usize,
    /// Number of levels of coarser graphs, of 3, 9, 27 .. cells a node, through which a network sees the whole map, 0 to 8
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    levels: usize,
    /// Number of channels of a node of the coarser graphs, a multiple of 32 up to 1024
    #[arg(long, value_name = "N", default_value_t = 64, allow_negative_numbers = true)]
    coarse_channels: usize,
    /// Number of attention layers of each coarser graph on the way up, and as many on the way down, 1 to 64
    #[arg(long, value_name = "N", default_value_t = 2, allow_negative_numbers = true)]
    coarse_layers: usize,
    /// Number of libtorch's threads on the CPU, 1 to 1024. With more than one, the last bits of the weights may differ
    /// from run to run
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
    Err(built_without())
}

#[cfg(not(feature = "train"))]
pub(super) fn built_without() -> Failure {
    Failure::Input(
        "this program was built without training, which needs libtorch: build it from a checkout with \
         `train/libtorch.sh && cargo build --release --features train`"
            .to_owned(),
    )
}
