//! A robot's vehicle behind an autopilot that speaks MAVLink.
//!
//! - [`settings`]: the table `[mavlink]` of a robot's settings;
//! - `vehicle`: the pilot ([`dragnet_vehicle::pilot`]) and the autopilot ([`dragnet_mavlink::autopilot`]), connected;
//! - `detections`: what detectors say, as JSON;
//! - `link`: sockets; `serve`: all of it, driven by the wall clock.
//!
//! The sockets are tokio's: of the crate `mavlink` only the messages are used.

pub mod settings;

pub(crate) mod detections;
pub(crate) mod link;
pub(crate) mod serve;
pub(crate) mod vehicle;
