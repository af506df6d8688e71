//! Training with libtorch: a [`Trainer`] teaches a network to choose as the expert of demonstrations does (paper, Eq. 5),
//! a [`Reinforcer`] to choose what made its own searches shorter.
//!
//! The same demonstrations or searches, settings and seed give the same weights, bit for bit, on one thread of one kind of
//! computer.

mod adam;
mod batch;
mod checkpoint;
mod data;
mod model;
mod reinforcer;
mod settings;
mod trainer;

pub use tch::Device;

pub use data::{Data, DataError, Spread};
pub use model::Model;
pub use reinforcer::{Reinforcement, Reinforcer, Round};
pub use settings::{Epoch, Measured, Settings};
pub use trainer::Trainer;

/// Sets the number of CPU threads of libtorch. It should not exceed the free cores: threads wait for each other.
pub fn set_threads(threads: u16) {
    tch::set_num_threads(threads.into());
}
