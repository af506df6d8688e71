//! MCAP files, with errors that name the file: [`write`] writes them, and buffers while the disk is full; [`read`]
//! reads their intact parts.

pub(crate) mod chunk;
mod ending;
mod error;
pub(crate) mod foreign;
mod layout;
mod patient;
pub(crate) mod read;
mod resume;
mod summary;
pub(crate) mod write;

pub use ending::Ending;
pub use error::RecordingError;
