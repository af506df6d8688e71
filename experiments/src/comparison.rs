//! Policies against each other, over scenarios and seeds: what is run, in one process or in shards, and the tables and
//! curves that it comes to.
//!
//! An [`Experiment`] runs, each episode comes to a [`Trial`], and its [`Design`] makes a [`Row`] a case of the trials,
//! wherever and in however many parts they were run.

mod design;
mod estimate;
mod experiment;
pub mod files;
pub mod part;

pub use design::Design;
pub use dragnet_sim::comparison::{Estimate, Row, Trial};
pub use estimate::estimate;
pub use experiment::{Case, Experiment};
