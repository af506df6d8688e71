//! Scenario files, and the map files that they name.
//!
//! - [`Scenario`] and its parts: a checked search that can be run; [`file`](mod@file): the scenario file as it is
//!   written;
//! - [`map_file`]: reads drawn, surveyed or recorded maps, and their position on the earth;
//! - [`shipped`]: the scenarios that come with the program;
//! - [`Places`]: where cells are, as people read it;
//! - [`toml_text`]: reads TOML texts, with errors in words;
//! - [`participant`], [`time`]: participants, and the mission's time.

pub mod map_file;
#[cfg(test)]
#[path = "../../../tests/mentions/mod.rs"]
mod mentions;
pub mod participant;
mod places;
mod scenario;
pub mod shipped;
pub mod time;
pub mod toml_text;

pub use places::{Places, accuracy, located};
pub use scenario::{
    Budget, Class, Drawn, EarlierBelief, Invalid, Mission, Network, Objects, Partition, Policy,
    PolicyTextError, Reason, Recording, Robot, Scenario, ScenarioError, Source, Start, Warning, file,
    policies, schema_json, schema_of,
};
