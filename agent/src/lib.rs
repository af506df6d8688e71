//! One robot of a search team.
//!
//! [`agent`] is the robot's mind: a state machine that is told what happened and returns what to do, and knows no
//! clock, socket or thread. [`heartbeat`] is when it gives a sign of life, [`team`] what it knows of its teammates.

pub mod agent;
pub mod heartbeat;
mod state_machine;
pub mod team;
