//! The contracts: what travels between processes, under which keys, in which bytes; and the files that describe a
//! search.
//!
//! - [`message`], [`step`], [`wire`], [`cdr`], [`convert`], [`schema`]: what is said, as ROS 2 messages in CDR;
//! - [`key`], [`sender`], [`time`], [`clock`], [`inbox`], [`plausible`]: under which key, by which process, when, exactly once,
//!   and only if it can be;
//! - [`command`], [`directive`]: what a person asks for, and how it reaches every robot;
//! - [`participant`]: what drives a participant, and what it answers;
//! - [`ros`]: a robot's own ROS 2 network, its names, keys and messages;
//! - [`scenario`], [`map_file`]: what is searched, by whom, under which conditions.
//! - [`file`](mod@file): files that people name, read no further than they may be long.
//!
//! Only this crate knows wire bytes and key expressions.

pub mod cdr;
pub mod clock;
pub mod command;
pub mod convert;
pub mod directive;
pub mod inbox;
pub mod key;
pub mod message;
pub mod participant;
pub mod plausible;
pub mod ros;
pub mod schema;
pub mod sender;
pub mod step;
pub mod wire;
