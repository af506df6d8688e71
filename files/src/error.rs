//! Why a file cannot be used.

use std::io;
use std::path::{Path, PathBuf};

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// Reading failed.
    #[error("{path}: cannot read the {kind}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Its expected content.
        kind: &'static str,
        /// The cause.
        source: io::Error,
    },
    /// Writing failed; an older file is unchanged, and no part of the new one remains.
    #[error("{path}: cannot write: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Its content is invalid.
    #[error("{path}: {reason}")]
    Content {
        /// The file.
        path: PathBuf,
        /// The error, and the allowed values.
        reason: String,
    },
}

impl FileError {
    /// An error for invalid content.
    #[must_use]
    pub fn content(path: &Path, reason: String) -> Self {
        Self::Content { path: path.to_owned(), reason }
    }
}
