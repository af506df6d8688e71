//! Zenoh: the only crate that speaks it, and all sockets but those of the live page.
//!
//! Minds ([`dragnet_proto::state_machine::StateMachine`]) know no network; here they get one.
//!
//! - [`session`], [`link`]: how a session is opened, and what a participant says and hears on it;
//! - [`refusals`]: whom Zenoh turns away, told in plain words; [`source_places`]: and without folders of other machines;
//! - [`wall_clock`], [`clock`]: a participant driven by the wall clock, as in the field, in the mission's time; [`journal`]: what
//!   it remembers if it starts again;
//! - [`lockstep`], [`remote_participants`]: participants driven by the simulator, event by event, over the same messages;
//! - [`ros`], [`vehicle`]: a robot's own ROS 2 network, and its vehicle on it;
//! - [`dry_run`]: a robot that lives through a recording of its vehicle's network;
//! - [`doctor`]: whether all is there that a robot's settings name;
//! - [`stop`]: when a process is to end;
//! - [`relay`]: a slow link, to try a team on;
//! - [`world`]: the simulated world for participants driven by the wall clock;
//! - [`team`]: a whole team in one call; [`config`], [`serve`]: each part as a process of its own.

pub mod clock;
pub mod config;
pub mod doctor;
pub mod dry_run;
pub mod journal;
pub mod link;
pub mod lockstep;
pub mod refusals;
pub mod relay;
pub mod remote_participants;
pub mod ros;
pub mod serve;
pub mod session;
pub mod source_places;
pub mod stop;
pub mod team;
pub mod vehicle;
pub mod wall_clock;
pub mod world;

mod doubles;
mod endpoint;
mod error;
mod log_limit;
mod narrator;
mod unix_time;
mod waiting;
mod watchdog;

pub use error::RuntimeError;
