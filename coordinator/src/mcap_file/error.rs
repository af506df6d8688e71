//! Errors of recordings.

use std::io;
use std::path::PathBuf;

use mcap::McapError;

/// Why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be created: choose another place.
    #[error("{}: cannot create the recording: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The path is that of a folder or a device: choose another place.
    #[error("{}: no plain file; allowed is the path of a recording", path.display())]
    NoPlainFile {
        /// The path.
        path: PathBuf,
    },
    /// The path exists: choose another name, or move it away.
    #[error("{}: exists already, and no recording is ever overwritten", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Writing failed, usually because the disk is full. What was written before stays readable.
    #[error("{}: cannot write {what}: {}", path.display(), reason(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// What was to be written.
        what: String,
        /// The cause.
        source: McapError,
    },
    /// The file cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is not MCAP, or ends before its first record.
    #[error("{}: not a recording: {found}", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
    /// Unsupported compression.
    #[error("{}: compressed with {compression}, which is not understood; allowed are zstd, lz4 and none", path.display())]
    Compression {
        /// The file.
        path: PathBuf,
        /// The method, as the file names it.
        compression: String,
    },
    /// The contents are not a recording of this program.
    #[error("{}: cannot be played back: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        reason: String,
    },
}

/// The crate's own message names only the operation that failed.
fn reason(error: &McapError) -> String {
    match error {
        McapError::Io(source) => source.to_string(),
        other => other.to_string(),
    }
}
