//! A recorded mission as files that maps, receivers and ground stations read.
//!
//! - [`account`]: what a recording comes to at a time: finds, tracks, plans and how well each cell was searched;
//! - [`detection`]: how well, as a probability;
//! - [`geojson`], [`kml`], [`gpx`], [`plan`]: an account as the text of a file. The same account makes the same bytes.

pub mod account;
mod bands;
pub mod detection;
mod error;
pub mod geojson;
pub mod gpx;
pub mod kml;
pub mod plan;
mod time;
mod xml;

pub use account::Account;
pub use error::ExportError;
