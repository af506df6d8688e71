//! A robot's perception and motion: from camera detections to evidence, and from a waypoint to motion.
//!
//! The crate has no clock, socket, file, thread or unseeded randomness. Perception, in order:
//!
//! 1. [`dragnet_lattice::plane`], [`camera`]: from the boxes of a detector to bearings;
//! 2. [`assignment`]: the assignment of bearings to tracks;
//! 3. [`tracker`]: from bearings over time to positions of objects;
//! 4. [`evidence`]: from positions of objects to readings of cells;
//! 5. [`calibration`]: the precision of readings, from readings with known truth.
//!
//! [`frames`] says how parts of the vehicle, and the vehicle on the map, stand to each other over time.
//!
//! [`dragnet_lattice`] plans paths that the vehicle can drive. [`pilot`] combines all of this, between the vehicle's
//! sensors and its agent, by its [`settings`].

pub mod assignment;
pub mod calibration;
pub mod camera;
pub mod evidence;
pub mod frames;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub mod pilot;
pub mod settings;
pub mod tracker;
