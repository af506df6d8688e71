//! One robot of a search team.
//!
//! [`agent`] is the robot's state machine: it takes events and returns actions, and has no clock, socket or thread.
//! [`heartbeat`] schedules its heartbeats, and [`team`] keeps its knowledge of its teammates.

pub mod agent;
pub mod heartbeat;
mod state_machine;
pub mod team;
