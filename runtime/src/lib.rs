//! Participants on Zenoh. This is the only crate that uses Zenoh, and it opens all sockets except those of the live
//! page.
//!
//! State machines ([`dragnet_proto::state_machine::StateMachine`]) have no network; this crate connects them to one.
//!
//! - [`session`], [`link`]: opening of sessions, and a participant's publications and subscriptions;
//! - [`refusals`]: logs connections that Zenoh rejects; [`source_places`]: removes paths of the build machine from
//!   messages;
//! - [`wall_clock`], [`clock`]: a participant driven by the wall clock, as in the field, and its mission time;
//!   [`journal`]: its stored state for a restart;
//! - [`progress`]: warnings of a robot that nothing moves;
//! - [`lockstep`], [`remote_participants`]: participants driven by the simulator, event by event, over the same messages;
//! - [`ros`], [`vehicle`]: a robot's ROS 2 network, and its vehicle on it; [`dry_run`]: the same on a recording;
//! - [`mavlink`]: a vehicle behind an autopilot that speaks MAVLink;
//! - [`doctor`]: checks of a robot's settings and surroundings;
//! - [`tak`]: the mission on the maps of TAK;
//! - [`stop`]: signals that end a process; [`relay`]: emulates a bad link, for tests;
//! - [`world`]: the simulator for participants driven by the wall clock;
//! - [`team`]: a whole team in one call; [`config`], [`serve`]: each part as a process of its own.

pub mod clock;
pub mod config;
pub mod doctor;
pub mod dry_run;
pub mod earlier;
pub mod journal;
pub mod link;
pub mod lockstep;
pub mod mavlink;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub(crate) mod pictures;
pub mod progress;
pub mod refusals;
pub mod relay;
pub mod remote_participants;
pub mod ros;
pub mod serve;
pub mod session;
pub mod source_places;
pub mod stop;
pub mod tak;
pub mod team;
pub mod vehicle;
pub mod wall_clock;
pub mod world;

mod contender;
mod doubles;
mod endpoint;
mod error;
mod log_limit;
mod narrator;
mod tokens;
mod unix_time;
mod waiting;
mod watchdog;

pub use error::RuntimeError;
