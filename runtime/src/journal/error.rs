//! What can be wrong with a journal.

use std::path::{Path, PathBuf};

/// Why a robot cannot have its journal.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// Another process has it open.
    #[error("{path}: another process writes this journal. Is the robot running already?", path = path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It is about something else.
    #[error(
        "{path}: a journal of {what} {found:?}, not {expected:?}; name another journal, or move this one away to begin \
         anew",
        path = path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
        /// In what it differs.
        what: &'static str,
        /// What it says.
        found: String,
        /// What it should.
        expected: String,
    },
    /// It is something else, and nothing is done to it.
    #[error(
        "{path}: no journal, nor what is left of one; name another file, or move this one away to begin anew",
        path = path.display()
    )]
    NotAJournal {
        /// The file.
        path: PathBuf,
    },
    /// It is a folder or a device, and nothing is done to it.
    #[error("{path}: no plain file, as a journal is; name another", path = path.display())]
    NotAFile {
        /// What was named.
        path: PathBuf,
    },
    /// What stands in it makes no sense.
    #[error("{path}: {reason} stands in this journal; move it away to begin anew", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What stands there.
        reason: String,
    },
    /// It cannot be read or written.
    #[error("journal {path}: {source}", path = path.display())]
    Storage {
        /// The file.
        path: PathBuf,
        /// Why.
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
