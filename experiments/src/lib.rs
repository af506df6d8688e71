//! Experiments: many searches in simulation, with tables, curves and files as results.
//!
//! Reading order:
//!
//! 1. [`seeds`], [`shard`], [`jobs`]: seeds, their division among processes, and parallel jobs;
//! 2. [`comparison`]: comparisons of policies over scenarios and seeds;
//! 3. [`benchmark`]: frozen tracks, and results on them that others can verify;
//! 4. [`forecast`]: what a search is expected to find, and when;
//! 5. [`paper`]: the paper's tables and figures, measured again, as one page;
//! 6. [`demonstrations`]: recording of experts' decisions for training;
//! 7. [`reinforcement`]: searches of a network to learn from;
//! 8. [`plot`]: curves as drawings.
//!
//! This crate reads no command line and writes to no terminal. The caller passes the program's version and receives
//! [`progress`].

pub mod benchmark;
pub mod comparison;
mod cut_off;
pub mod demonstrations;
mod error;
pub mod forecast;
pub mod jobs;
pub mod output;
pub mod paper;
pub mod plot;
pub mod progress;
pub mod reinforcement;
pub mod seeds;
pub mod shard;

pub use error::ExperimentError;
