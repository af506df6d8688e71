//! Motion planning on a state lattice: paths between poses from motions that the vehicle can drive.
//!
//! A state is a cell of the cost map and one of the primitives' headings; a [`primitives::Primitive`] leads from one
//! state to another. [`planner::Planner`] finds the cheapest chain of them that the footprint can follow, by ARA*
//! (Likhachev, Gordon and Thrun 2003). Primitives come from SBPL's `.mprim` text ([`mprim`]) or are made for a turning
//! radius ([`maneuvers`]).
//!
//! Memory: about 8 bytes for each cell of the map, and 8 more for each state near visited ones: 60 to 135 MB on 3000 x
//! 3000 cells.
//!
//! The library reads no clock and no file: the caller passes the text, and decides before each batch of work whether to
//! continue.

mod ara;
mod bits;
mod buckets;
pub mod costmap;
pub mod footprint;
mod goal;
mod guidance;
mod guide;
mod heuristic;
mod layers;
pub mod maneuvers;
#[cfg(test)]
#[path = "../../../tests/mentions/mod.rs"]
mod mentions;
mod metric;
mod motions;
pub mod mprim;
pub mod plan;
pub mod plane;
pub mod planner;
pub mod primitives;
mod queue;
mod run;
mod states;
mod stopped;
#[cfg(test)]
mod tests;

pub use metric::UNITS_PER_CELL;
