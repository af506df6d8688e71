//! MAVLink without sockets: an autopilot of ArduPilot (rovers, boats, copters) or PX4, seen from a companion computer.
//!
//! - [`frames`]: messages from bytes, and bytes from messages;
//! - [`mode`]: who has control, by an autopilot's heartbeat;
//! - [`target`]: where a vehicle is and is to go, with the limits of both;
//! - [`autopilot`]: the state machine: messages and wishes go in, messages, positions and notices come out.
//!
//! The crate has no clock, socket, file, thread or randomness. Messages and their fields are those of the dialect
//! `common` of MAVLink 2, as far as `dialect/common.xml` has them.

pub mod autopilot;
pub mod frames;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub mod mode;
pub mod target;

pub use common::MavMessage;
pub use dialect::common;
pub use mavlink_core::MavHeader;

#[allow(clippy::all, clippy::pedantic, clippy::unwrap_used, missing_docs, unreachable_pub)]
mod dialect {
    include!(concat!(env!("OUT_DIR"), "/mod.rs"));
}
