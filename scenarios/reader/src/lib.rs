//! Scenario files, and the map files that they name.
//!
//! - [`Scenario`] and its parts: a search that can be run; [`file`](mod@file): the same as written;
//! - [`map_file`]: drawn, surveyed or recorded maps, as the terrain that is searched, and their position on the earth;
//! - [`shape`]: lists in a file that are longer than what is read of them;
//! - [`shipped`]: the scenarios that come with the program;
//! - [`participant`], [`time`]: participants, and the mission's time.

pub mod map_file;
pub mod participant;
mod scenario;
pub mod shape;
pub mod shipped;
pub mod time;

pub use scenario::{
    Budget, Drawn, Invalid, Mission, Network, Objects, Partition, Policy, PolicyTextError, Reason, Recording,
    Robot, Scenario, ScenarioError, Source, Start, Warning, file, policies, schema_json, schema_of,
};
