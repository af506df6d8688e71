//! The mission seen from outside: what is found, who is alive, and the recording of it all.
//!
//! - [`mission`]: the state machine, made of [`declaration`], [`liveness`] and [`track`];
//! - [`record`]: the recording, an MCAP file that ROS 2 tools and viewers read; [`recording`]: how it outlives a full disk;
//! - [`inspect`], [`recover`]: what a recording holds, and how one that was cut off is mended;
//! - [`playback`]: a recording as the records that made it; [`fold`]: what records amount to;
//! - [`bag`]: recordings that ROS 2 made.
//!
//! Robots search on without any of this.

pub mod bag;
pub mod declaration;
pub mod fold;
pub mod inspect;
pub mod liveness;
mod mcap_file;
pub mod mission;
pub mod node;
pub mod playback;
pub mod record;
pub mod recording;
pub mod recover;
pub mod track;

pub use mcap_file::{Ending, RecordingError};
