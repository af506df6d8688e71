//! MCAP files, with errors that name the file: [`write`] writes them, [`read`] reads as much of them as is whole.

mod chunk;
mod ending;
mod error;
pub(crate) mod foreign;
mod layout;
pub(crate) mod read;
mod resume;
mod summary;
pub(crate) mod write;

pub use ending::Ending;
pub use error::RecordingError;
