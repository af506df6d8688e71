//! Behavior cloning with libtorch: a network learns to choose as the expert of demonstrations chose (paper, Eq. 5).
//!
//! The same demonstrations, settings and seed give the same weights, bit for bit, on one thread of one kind of machine.

mod adam;
mod batch;
mod checkpoint;
mod data;
mod model;
mod settings;
mod trainer;

pub use tch::Device;

pub use data::{Data, DataError};
pub use model::Model;
pub use settings::{Epoch, Measured, Settings};
pub use trainer::Trainer;

/// Lets libtorch use so many threads of the CPU. Not more than there are free cores: they wait for each other.
pub fn set_threads(threads: u16) {
    tch::set_num_threads(threads.into());
}
