//! ROS 2 over plain Zenoh or in a recording, without ROS installed: messages, names and keys, and the inputs and
//! outputs of a robot's own network. No socket.
//!
//! - [`wire`], [`cdr`], [`schema`]: messages as structs, as bytes, and their ROS definitions;
//! - [`name`]: names of topics, nodes and namespaces;
//! - [`qos`], [`rmw_zenoh`], [`bridge`]: quality of service, and the keys, tokens and attachments of topics for either
//!   way into ROS 2;
//! - [`input`]: messages of a robot's sensors and navigation, checked, in meters and radians;
//! - [`output`]: messages that Dragnet publishes there;
//! - [`navigation_goal`]: the state of a waypoint that was sent to Nav2;
//! - [`viewer`]: a mission as messages for viewers.

pub mod bridge;
pub mod cdr;
pub mod input;
pub mod name;
pub mod navigation_goal;
pub mod output;
pub mod qos;
pub mod rmw_zenoh;
pub mod schema;
pub mod viewer;
pub mod wire;
