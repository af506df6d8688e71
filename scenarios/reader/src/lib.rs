//! What is searched, by whom, when and under which conditions: scenario files, and the map files that they name.
//!
//! - [`Scenario`] and its parts: a search that can be run; [`file`](mod@file): the same as it is written;
//! - [`map_file`]: what others draw, survey or record, as the map that is searched, and where it lies on the earth;
//! - [`shape`]: lists in a file that say more than is read of them;
//! - [`participant`], [`time`]: who takes part, and the mission's time.

pub mod map_file;
pub mod participant;
mod scenario;
pub mod shape;
pub mod time;

pub use scenario::{
    Budget, Drawn, Invalid, Mission, Network, Objects, Partition, Policy, Reason, Recording, Robot, Scenario,
    ScenarioError, Source, Start, Warning, file, schema_json, schema_of,
};
