//! A robot's own side: from what its cameras detect to evidence, and from a waypoint to motion.
//!
//! Nothing here knows a clock, socket, file, thread or unseeded randomness. What a robot sees goes this way:
//!
//! 0. [`detector`]: from a camera's image to boxes, if no other program does that;
//! 1. [`plane`], [`camera`]: from the boxes of a detector to bearings;
//! 2. [`assignment`]: from bearings to the tracks that they belong to;
//! 3. [`tracker`]: from bearings over time to where things are;
//! 4. [`evidence`]: from where things are to what the search believes of its cells;
//! 5. [`calibration`]: how precise such evidence is, from looks of which one knows what was there.
//!
//! And where it goes, [`lattice`] plans, in motions that it can drive.

pub mod assignment;
pub mod calibration;
pub mod camera;
pub mod detector;
pub mod evidence;
pub mod lattice;
pub mod plane;
pub mod tracker;
