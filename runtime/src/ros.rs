//! A node on a robot's own ROS 2 network, over plain Zenoh: neither building nor running it needs ROS.
//!
//! There are two transports, [`settings::Transport`]: nodes of `rmw_zenoh` use their own keys, with the tokens and
//! attachments that they expect; nodes of any other middleware are reached through a `zenoh-bridge-ros2dds`. The
//! network is the robot's own: its session is separate from the team's, and no message of the team passes through it.
//!
//! - [`settings`]: the table `[ros]` of a robot's settings, and the resulting subscriptions and publishers;
//! - [`incoming`]: received messages, from the network or from a recording of it;
//! - [`node`]: the [`node::Node`] itself.
//!
//! The content and the keys of messages are defined in [`dragnet_ros2`].

pub mod incoming;
pub mod node;
pub mod settings;

mod inbox;
mod publisher;
mod session;

#[cfg(test)]
mod tests;
