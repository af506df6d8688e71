//! A running mission as events of Cursor on Target 2.0, the language of ATAK, WinTAK and iTAK.
//!
//! - [`event`]: one event, and its text;
//! - [`Picture`]: the mission, folded from the coordinator's records, as the events that show it;
//! - `shapes`: drawn areas and no-go zones as shapes.
//!
//! It has no socket and no clock.

pub mod event;
mod picture;
mod shapes;

pub use picture::{Mission, NotOnEarth, Picture, Source};
