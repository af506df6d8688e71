//! MCAP files, with errors that name the file: [`write`] writes them, and waits for the disk if it must;
//! [`read`] reads as much of them as is whole.

mod chunk;
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
