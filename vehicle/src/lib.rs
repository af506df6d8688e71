//! A robot's own side: from what its cameras detect to evidence, and from a waypoint to motion.
//!
//! Nothing here knows a clock, socket, file, thread or unseeded randomness. What a robot sees goes this way:
//!
//! 1. [`dragnet_lattice::plane`], [`camera`]: from the boxes of a detector to bearings;
//! 2. [`assignment`]: from bearings to the tracks that they belong to;
//! 3. [`tracker`]: from bearings over time to where things are;
//! 4. [`evidence`]: from where things are to what the search believes of its cells;
//! 5. [`calibration`]: how precise such evidence is, from looks of which one knows what was there.
//!
//! Where it goes, [`dragnet_lattice`] plans, in motions that it can drive. [`pilot`] is all of this together,
//! between the vehicle's sensors and its agent, by its [`settings`].

pub mod assignment;
pub mod calibration;
pub mod camera;
pub mod evidence;
pub mod pilot;
pub mod settings;
pub mod tracker;
