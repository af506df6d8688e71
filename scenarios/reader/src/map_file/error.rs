//! Why a map file cannot be read.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use dragnet_search::terrain::TerrainError;

/// A map file that cannot be read. Each message names the file, the place in it, what is there and what is
/// allowed.
#[derive(Debug, thiserror::Error)]
pub enum MapFileError {
    /// The file is missing or unreadable.
    #[error("{}: {source}", file.display())]
    Read {
        /// Which file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The extension tells no format.
    #[error("{}: unknown extension; allowed are {allowed}", file.display())]
    Extension {
        /// Which file.
        file: PathBuf,
        /// Extensions and what they mean.
        allowed: &'static str,
    },
    /// It is not the format that its extension promises.
    #[error("{}: {message}", file.display())]
    Syntax {
        /// Which file.
        file: PathBuf,
        /// What the parser says, with line and column where it knows them.
        message: String,
    },
    /// A value that is out of range, or contradicts another.
    #[error("{}: {place} is {found}; allowed is {allowed}", file.display())]
    Value {
        /// Which file.
        file: PathBuf,
        /// Key, line, or ring and position.
        place: String,
        /// What is there.
        found: String,
        /// What could be.
        allowed: String,
    },
    /// A drawing that is no terrain, or a size that no grid has.
    #[error("{}: {source}", file.display())]
    Terrain {
        /// Which file.
        file: PathBuf,
        /// What is wrong.
        source: TerrainError,
    },
}

impl MapFileError {
    pub(super) fn syntax(file: &Path, message: impl Display) -> Self {
        Self::Syntax { file: file.to_owned(), message: message.to_string() }
    }

    pub(super) fn value(
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
