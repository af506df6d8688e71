//! Why a map file cannot be read.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use dragnet_search::terrain::TerrainError;

/// Why a map file cannot be read. Each message names the file, the place in it, the value and the allowed values.
#[derive(Debug, thiserror::Error)]
pub enum MapFileError {
    /// The file is missing or unreadable.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Unknown extension.
    #[error("{}: unknown extension; allowed are {allowed}", file.display())]
    Extension {
        /// The file.
        file: PathBuf,
        /// Known extensions and their formats.
        allowed: &'static str,
    },
    /// The file does not have the format of its extension.
    #[error("{}: {message}", file.display())]
    Syntax {
        /// The file.
        file: PathBuf,
        /// The parser's message, with line and column if known.
        message: String,
    },
    /// A value that is out of range, or contradicts another.
    #[error("{}: {place} is {found}; allowed is {allowed}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Key, line, or ring and position.
        place: String,
        /// The value.
        found: String,
        /// The allowed values.
        allowed: String,
    },
    /// An invalid drawing, or an invalid size of the grid.
    #[error("{}: {source}", file.display())]
    Terrain {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: TerrainError,
    },
}

impl MapFileError {
    pub(super) fn syntax(file: &Path, message: impl Display) -> Self {
        Self::Syntax { file: file.to_owned(), message: message.to_string() }
    }

    pub(crate) fn value(
        file: &Path,
        place: impl Display,
        found: impl Display,
        allowed: impl Display,
    ) -> Self {
        Self::Value {
            file: file.to_owned(),
            place: place.to_string(),
            found: found.to_string(),
            allowed: allowed.to_string(),
        }
    }
}
