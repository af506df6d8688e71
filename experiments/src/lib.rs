//! Experiments: many searches in simulation, and the tables, curves and files that they come to.
//!
//! Reading order:
//!
//! 1. [`seeds`], [`shard`], [`jobs`]: what is run, which process runs which part of it, and many jobs side by side;
//! 2. [`comparison`]: policies against each other, over scenarios and seeds;
//! 3. [`paper`]: the paper's tables and figures, measured again, as one page;
//! 4. [`demonstrations`]: an expert at work, as files that a network learns from;
//! 5. [`plot`]: curves as drawings.
//!
//! This crate reads no command line and writes to no terminal. Whoever calls it says which version of the program runs and
//! hears about [`progress`].

pub mod comparison;
pub mod demonstrations;
mod error;
pub mod jobs;
pub mod output;
pub mod paper;
pub mod plot;
pub mod progress;
pub mod seeds;
pub mod shard;

pub use error::ExperimentError;
