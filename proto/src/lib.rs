//! Messages between Dragnet's processes: their keys, their bytes, and the rules for accepting them.
//!
//! - [`message`], [`step`], [`dragnet_msgs`], [`convert`]: the content, as ROS 2 messages in CDR;
//! - [`key`], [`sender`], [`clock`]: keys, sending processes, and mission time;
//! - [`scenario_digest`]: what the scenarios of all participants must have in common;
//! - [`replica`], [`validation`], [`knowledge`]: each observation counts exactly once, and only if it is physically possible;
//! - [`picture`]: pictures of finds, which the coordinator asks robots for;
//! - [`radio`]: which message a radio with a limited rate sends next;
//! - [`command`], [`directive`], [`orders`], [`zones`], [`verdict`], [`marks`], [`newest`], [`runs`]: the operator's commands, and how they reach every robot;
//! - [`state_machine`]: the contract of robots and coordinator: events in, effects out.
//!
//! Only this crate and `dragnet-ros2`, for ROS 2, contain wire formats and key expressions.

pub mod clock;
pub mod command;
pub mod convert;
pub mod directive;
pub mod dragnet_msgs;
pub mod instructions;
pub mod key;
pub mod knowledge;
pub mod marks;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub mod message;
pub mod newest;
pub mod orders;
pub mod picture;
pub mod radio;
pub mod replica;
pub mod runs;
pub mod scenario_digest;
pub mod sender;
pub mod state_machine;
pub mod step;
pub mod validation;
pub mod verdict;
pub mod zones;
