//! What Dragnet's processes say to each other: under which keys, in which bytes, and what of it counts.
//!
//! - [`message`], [`step`], [`dragnet_msgs`], [`convert`]: what is said, as ROS 2 messages in CDR;
//! - [`key`], [`sender`], [`clock`], [`inbox`], [`plausible`]: under which key, by which process, when, exactly once, and only
//!   if it can be;
//! - [`command`], [`directive`]: what a person asks for, and how it reaches every robot;
//! - [`participant`]: what drives a participant, and what it answers.
//!
//! Only this crate and `dragnet-ros2`, which has ROS's own part, know wire bytes and key expressions.

pub mod clock;
pub mod command;
pub mod convert;
pub mod directive;
pub mod dragnet_msgs;
pub mod inbox;
pub mod key;
pub mod message;
pub mod participant;
pub mod plausible;
pub mod sender;
pub mod step;
