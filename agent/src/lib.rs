//! One robot of a search team.
//!
//! [`agent`] is the robot's state machine: it handles events and returns effects, and has no clock, socket or thread.
//! [`heartbeat`] schedules its heartbeats, and [`team`] stores what it knows of its teammates.

pub mod agent;
pub mod heartbeat;
mod state_machine;
pub mod team;
