//! ROS 2 messages over plain Zenoh or in recordings, without an installation of ROS: messages, names and keys, and the
//! inputs and outputs of a robot's own network. The crate opens no socket.
//!
//! - [`wire`], [`cdr`], [`schema`]: messages as structs, as bytes, and their ROS definitions;
//! - [`name`]: names of topics, nodes and namespaces;
//! - [`qos`], [`rmw_zenoh`], [`bridge`]: quality of service, and the keys, tokens and attachments of topics for each of
//!   the two transports;
//! - [`input`]: messages of a robot's sensors and navigation, checked, in meters and radians;
//! - [`output`]: messages that Dragnet publishes there;
//! - [`navigation_goal`]: the state of a waypoint that was sent to Nav2;
//! - [`viewer`]: conversion of a mission to messages for viewers.

pub mod bridge;
pub mod cdr;
pub mod input;
#[cfg(test)]
#[path = "../../tests/mentions/mod.rs"]
mod mentions;
pub mod name;
pub mod navigation_goal;
pub mod output;
pub mod qos;
pub mod rmw_zenoh;
pub mod schema;
pub mod viewer;
pub mod wire;
