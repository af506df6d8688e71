//! What can go wrong with a recording.

use std::io;
use std::path::PathBuf;

use mcap::McapError;

/// A recording that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// It cannot be created: choose another place.
    #[error("{}: cannot create the recording: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something is there: choose another name, or move it away.
    #[error("{}: exists already, and no recording is ever overwritten", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// It cannot be written on, mostly since the disk is full. What was written before stays readable.
    #[error("{}: cannot write {what}: {}", path.display(), reason(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// What was to be written.
        what: String,
        /// Why.
        source: McapError,
    },
    /// It cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is no MCAP file, or one that ends before it says anything.
    #[error("{}: not a recording: {found}", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        found: String,
    },
    /// It is packed in a way that is unknown here.
    #[error("{}: compressed with {compression}, which is not understood; allowed are zstd, lz4 and none", path.display())]
    Compression {
        /// The file.
        path: PathBuf,
        /// The method, as the file names it.
        compression: String,
    },
    /// Something in it is not what this program records.
    #[error("{}: cannot be played back: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What, and where.
        reason: String,
    },
}

/// The crate's own text says only that input or output failed.
fn reason(error: &McapError) -> String {
    match error {
        McapError::Io(source) => source.to_string(),
        other => other.to_string(),
    }
}
