//! A node on a robot's own ROS 2 network, over plain Zenoh: ROS is not needed to build it or to run it.
//!
//! Two ways lead in, [`settings::Transport`]: nodes of `rmw_zenoh` are met on their own keys, with the tokens and
//! attachments that they expect; nodes of any other middleware behind a `zenoh-bridge-ros2dds`. The network is the
//! robot's own: its session is another one than the team's, and no message of the team passes through it.
//!
//! - [`settings`]: the table `[ros]` of a robot's settings, and what of it is heard and said;
//! - [`incoming`]: what is heard, whether it comes from the network or from a recording of it;
//! - [`node`]: the [`node::Node`] itself.
//!
//! What messages say, and under which key, is [`dragnet_ros2`]'s to know.

pub mod incoming;
pub mod node;
pub mod settings;

mod inbox;
mod publisher;
mod session;

#[cfg(test)]
mod tests;
