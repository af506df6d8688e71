//! Comparisons of policies over scenarios and seeds: their episodes, in one process or in shards, and the resulting
//! tables and curves.
//!
//! An [`Experiment`] runs, each episode gives a [`Trial`], and its [`Design`] makes a [`Row`] for each case of the
//! trials, independently of how they were divided into shards.

mod design;
mod estimate;
mod experiment;
pub mod files;
pub mod part;

pub use design::Design;
pub use dragnet_sim::comparison::bound::Gap;
pub use dragnet_sim::comparison::{Difference, Estimate, Interval, Row, Trial, differences};
pub use estimate::estimate;
pub use experiment::{Case, Experiment, run_episodes};
