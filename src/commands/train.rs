//! `dragnet train`: a network learns from demonstrations.

#[cfg(feature = "train")]
mod curves;
#[cfg(feature = "train")]
mod session;

use std::path::PathBuf;

use super::Failure;

/// Train a network to imitate an expert policy.
///
/// Learns from the files of `dragnet demonstrate`, and holds some trajectories out to see how well it imitates what it
/// has not seen. Beside the weights it writes FILE.metrics.csv and FILE.svg, a row and a point an epoch, and, until it
/// is done, FILE.checkpoint: the same command goes on from there after it was stopped. On the same kind of machine the
/// same demonstrations, options and seed give the same weights, to the bit.
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
    /// Of the first weights, and of the order in which decisions are seen
    #[arg(long, value_name = "S", default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,
    /// Passes over the demonstrations, at most
    #[arg(long, value_name = "N", default_value_t = 14, value_parser = clap::value_parser!(u32).range(1..=60_000), allow_negative_numbers = true)]
    epochs: u32,
    /// Stop after so many epochs that did not imitate better what was held out
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    patience: u32,
    /// Decisions a step
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    batch: u16,
    /// Of Adam at the start; it falls to 0 along half a cosine
    #[arg(long, value_name = "R", default_value_t = 3e-3, allow_negative_numbers = true)]
    learning_rate: f64,
    /// Every N-th trajectory is held out
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(2..), allow_negative_numbers = true)]
    validation_every: u16,
    /// Weight of the expert's choice in what is learned (the paper's Eq. 5 has 1); the rest goes to its scores, which
    /// tell a near tie from a mistake
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, allow_negative_numbers = true)]
    choice_weight: f64,
    /// Power of the expert's scores by which its wishes are spread over cells
    #[arg(long, value_name = "P", default_value_t = 60.0, allow_negative_numbers = true)]
    target_exponent: f64,
    /// Channels of a node, a multiple of 32
    #[arg(long, value_name = "N", default_value_t = 32, allow_negative_numbers = true)]
    hidden: usize,
    /// Attention layers
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true)]
    layers: usize,
    /// Channels that fade along the route; 0 for none
    #[arg(long, value_name = "N", default_value_t = 16, allow_negative_numbers = true)]
    decay_channels: usize,
    /// Channels that are summed along the route; 0 for none
    #[arg(long, value_name = "N", default_value_t = 4, allow_negative_numbers = true)]
    sum_channels: usize,
    /// Threads of libtorch on the CPU; with more than one, the last bits of the weights may differ from run to run
    #[arg(long, value_name = "T", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Learn on the CPU even if libtorch finds a GPU
    #[arg(long)]
    cpu: bool,
}

#[cfg(feature = "train")]
pub(super) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    session::run(arguments)
}

#[cfg(not(feature = "train"))]
pub(super) fn execute(_: &Arguments) -> Result<(), Failure> {
    Err(Failure::Input(
        "this program was built without training, which needs libtorch: build it from a checkout with \
         `train/libtorch.sh && cargo build --release --features train`"
            .to_owned(),
    ))
}
