//! A recorded mission as files for maps, GPS receivers and ground stations, and a running one as events for TAK.
//!
//! - [`account`]: the state of a recorded mission at a time: finds, tracks, plans and the probability of detection of
//!   each cell;
//! - [`geojson`], [`kml`], [`gpx`], [`plan`]: an account as the text of a file. The same account gives the same bytes;
//! - [`csv`]: the table of its segments, for which the mission need not be on the earth;
//! - [`cot`]: a running mission as events of Cursor on Target;
//! - [`belief`]: what a recorded mission believed, as the prior of the next one.

pub mod account;
mod bands;
pub mod belief;
pub mod cot;
pub mod csv;
mod error;
pub mod geojson;
pub mod gpx;
pub mod kml;
pub mod plan;
mod time;
mod xml;

pub use account::Account;
pub use error::ExportError;
