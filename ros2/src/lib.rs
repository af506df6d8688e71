//! ROS 2 over plain Zenoh or in a recording, without ROS installed: its messages, its names and keys, and what a robot's own
//! network says and is told. No socket.
//!
//! - [`wire`], [`cdr`], [`schema`]: messages as structs, as bytes, and as ROS defines them;
//! - [`name`]: names of topics, nodes and namespaces, as ROS has them;
//! - [`qos`], [`rmw_zenoh`], [`bridge`]: under which key each topic travels by either way in, and what goes with it;
//! - [`input`]: what a robot's sensors and its navigation say, checked, in meters and radians;
//! - [`output`]: what Dragnet says to them;
//! - [`navigation_goal`]: the state of a waypoint that was handed to Nav2;
//! - [`viewer`]: a mission as viewers draw it.

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
