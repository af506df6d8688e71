//! Errors of journals.

use std::path::{Path, PathBuf};

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// Another process has opened it.
    #[error("{path}: another process writes this journal. Is the robot running already?", path = path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It belongs to another robot, mission or map.
    #[error(
        "{path}: a journal of {what} {found:?}, not {expected:?}; name another journal, or move this one away to begin \
         anew",
        path = path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// The difference.
        what: &'static str,
        /// The value in the file.
        found: String,
        /// The expected value.
        expected: String,
    },
    /// It is not a journal, and is left alone.
    #[error(
        "{path}: no journal, nor what is left of one; name another file, or move this one away to begin anew",
        path = path.display()
    )]
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// It is a folder or a device, and is not changed.
    #[error("{path}: no plain file, as a journal is; name another", path = path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// Its content is invalid.
    #[error("{path}: {reason} stands in this journal; move it away to begin anew", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// The problem.
        reason: String,
    },
    /// It cannot be read or written.
    #[error("journal {path}: {source}", path = path.display())]
    Storage {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: Box<redb::Error>,
    },
}

impl JournalError {
    pub(super) fn of(path: &Path, source: redb::Error) -> Self {
        let path = path.to_owned();
        match source {
            redb::Error::DatabaseAlreadyOpen => Self::InUse { path },
            source => Self::Storage { path, source: Box::new(source) },
        }
    }
}
