//! Why a file cannot be used.

use std::io;
use std::path::{Path, PathBuf};

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be read.
    #[error("{path}: cannot read the {kind}: {source}")]
    Read {
        /// Which.
        path: PathBuf,
        /// What it should hold.
        kind: &'static str,
        /// Why.
        source: io::Error,
    },
    /// It cannot be written; an older one is kept, and nothing of the new one.
    #[error("{path}: cannot write: {source}")]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It holds something else.
    #[error("{path}: {reason}")]
    Content {
        /// Which.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        reason: String,
    },
}

impl FileError {
    /// A file that holds something else.
    #[must_use]
    pub fn content(path: &Path, reason: String) -> Self {
        Self::Content { path: path.to_owned(), reason }
    }
}
