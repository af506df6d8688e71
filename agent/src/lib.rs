//! One robot of a search team.
//!
//! [`agent`] is the robot's state machine: it handles events and returns effects, and has no clock, socket or thread.
//! [`heartbeat`] schedules its heartbeats, [`team`] stores what it knows of its teammates, `sightings` where vehicles have
//! seen objects that they could not assign to a cell yet, `blind_spots` which cells its own vehicle does not see, `barred`
//! which it could not enter, `home` the way back to its base, and `clearance` which part of a path keeps it apart from others.

pub mod agent;
mod barred;
mod blind_spots;
mod clearance;
pub mod heartbeat;
mod home;
mod sightings;
mod state_machine;
pub mod team;
