//! The coordinator: declares finds, tracks which robots are alive, and records the mission.
//!
//! - [`mission`]: the state machine, made of [`declaration`], [`liveness`], [`track`], [`standstill`] and [`ending`];
//! - [`record`]: the recording, an MCAP file that ROS 2 tools and viewers read; [`record::encoder`]: its messages, which
//!   viewers of a running mission get too; [`recording`]: recording that tolerates a full disk;
//! - [`inspect`], [`recover`]: inspection and repair of recordings;
//! - [`playback`]: reads a recording as a list of records; [`fold`]: computes the state of a mission from records;
//! - [`segment`]: how thoroughly each area was searched, and with which effort; [`visits`]: where robots have observed;
//! - [`news`]: finds, orders and verdicts that are of now, or were before;
//! - [`bag`]: recordings made by ROS 2.
//!
//! Robots continue to search without a coordinator.

pub mod bag;
pub mod declaration;
pub mod ending;
pub mod finds;
pub mod fold;
pub mod inspect;
pub mod liveness;
mod mcap_file;
pub mod mission;
pub mod news;
pub mod node;
pub mod playback;
pub mod record;
pub mod recording;
pub mod recover;
pub mod segment;
pub mod standstill;
pub mod track;
pub mod visits;

pub use mcap_file::{Ending, RecordingError};
