//! A robot's own side: from what its cameras detect to evidence, and from a waypoint to motion.
//!
//! [`lattice`] plans motions that the vehicle can drive.

pub mod lattice;
