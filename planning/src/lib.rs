//! A mission that is being planned, as data.
//!
//! - [`plan`]: the [`MissionPlan`], areas and a scenario's settings, which may still be wrong;
//! - [`review`]: what is wrong with it, where, and what comes of its areas;
//! - [`written`]: the two files that it becomes, which `dragnet run` and `dragnet check` read.
//!
//! No file is read or written here. The readers of areas and scenarios, and their messages, are those of
//! [`dragnet_scenario`].

pub mod plan;
pub mod review;
pub mod written;

pub use plan::{MissionPlan, PlanError};
pub use review::{Place, Problem, Review};
