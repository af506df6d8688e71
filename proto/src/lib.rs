//! What Dragnet's processes say to each other: under which keys, in which bytes, and what of it counts.
//!
//! - [`message`], [`step`], [`dragnet_msgs`], [`convert`]: what is said, as ROS 2 messages in CDR;
//! - [`key`], [`sender`], [`clock`], [`replica`], [`validation`]: under which key, by which process, when, exactly once, and only
//!   if it can be;
//! - [`command`], [`directive`]: what a person asks for, and how it reaches every robot;
//! - [`state_machine`]: the contract of robots and coordinator: events in, effects out.
//!
//! Only this crate and `dragnet-ros2`, which has ROS's own part, know wire bytes and key expressions.

pub mod clock;
pub mod command;
pub mod convert;
pub mod directive;
pub mod dragnet_msgs;
pub mod key;
pub mod message;
pub mod replica;
pub mod sender;
pub mod state_machine;
pub mod step;
pub mod validation;
