//! MCAP files, with errors that name the file: [`write`] writes them, [`read`] reads as much of them as is whole.

mod error;
pub(crate) mod foreign;
pub(crate) mod read;
pub(crate) mod write;

pub use error::RecordingError;
pub use read::Ending;
