//! Why a scenario cannot be run.

use std::io;
use std::path::PathBuf;

use dragnet_files::FileError;

use super::Source;
use super::check::{Invalid, shortened};
use super::locate::{line_at, line_of_key, line_of_longest_key};
use crate::map_file::MapFileError;

/// A scenario that cannot be run. Each message names the file, the place, what is there and what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file is missing or unreadable.
    #[error("{}: {source}", file.display())]
    Read {
        /// Which file.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It is no TOML, has a key that no scenario has, or a value of the wrong type.
    #[error("{place}: {message}")]
    Syntax {
        /// File and line.
        place: String,
        /// The key, what is wrong, and what is allowed.
        message: String,
    },
    /// A value that is out of range, or contradicts another.
    #[error("{place}: {invalid}")]
    Value {
        /// File, and line where it stands in one.
        place: String,
        /// What is wrong.
        invalid: Invalid,
    },
    /// A file that the scenario names.
    #[error("{place}: {source}")]
    MapFile {
        /// File and line.
        place: String,
        /// What is wrong with it.
        source: Box<MapFileError>,
    },
    /// A weights file that the scenario names.
    #[error("{place}: {key}: {source}")]
    Weights {
        /// File, and line where it stands in one.
        place: String,
        /// Path of the key, such as `robots.policy.weights`.
        key: String,
        /// What is wrong with it.
        source: FileError,
    },
    /// A value of the command line that the scenario cannot take.
    #[error("{}, changed on the command line: {invalid}", file.display())]
    Override {
        /// The scenario.
        file: PathBuf,
        /// What is wrong; the key is that of the scenario.
        invalid: Invalid,
    },
}

/// What is wrong with a part, before it is known where the part came from.
#[derive(Debug)]
pub(super) enum Fault {
    Value(Invalid),
    MapFile { key: &'static str, source: MapFileError },
    Weights { key: String, source: FileError },
}

impl From<Invalid> for Fault {
    fn from(invalid: Invalid) -> Self {
        Self::Value(invalid)
    }
}

impl Source {
    pub(super) fn toml_error(
        &self,
        error: &toml::de::Error,
        key: Option<&serde_path_to_error::Path>,
    ) -> ScenarioError {
        let line = error.span().map(|span| line_at(&self.text, span.start));
        let message = error.message().trim_end();
        let (line, message) = match (line, key.map(ToString::to_string).filter(|key| key != ".")) {
            (line, Some(key)) => (line, format!("{key}: {message}")),
            // Of a key that has too many parts the parser says neither that nor where.
            (None, None) => {
                (Some(line_of_longest_key(&self.text)), format!("a key of too many parts: {message}"))
            }
            (line, None) => (line, message.to_owned()),
        };
        ScenarioError::Syntax { place: self.place(line), message: shortened(&message) }
    }

    pub(super) fn error(&self, fault: Fault) -> ScenarioError {
        match fault {
            Fault::Value(invalid) => {
                let place = self.place(line_of_key(&self.text, &invalid.key));
                ScenarioError::Value { place, invalid }
            }
            Fault::MapFile { key, source } => {
                let place = self.place(line_of_key(&self.text, key));
                ScenarioError::MapFile { place, source: Box::new(source) }
            }
            Fault::Weights { key, source } => {
                let place = self.place(line_of_key(&self.text, &key));
                ScenarioError::Weights { place, key, source }
            }
        }
    }

    pub(super) fn override_error(&self, fault: Fault) -> ScenarioError {
        match fault {
            Fault::Value(invalid) => ScenarioError::Override { file: self.path.clone(), invalid },
            Fault::MapFile { .. } => self.error(fault),
            Fault::Weights { key, source } => {
                let place = format!("{}, changed on the command line", self.path.display());
                ScenarioError::Weights { place, key, source }
            }
        }
    }

    fn place(&self, line: Option<usize>) -> String {
        let file = self.path.display();
        line.map_or_else(|| file.to_string(), |line| format!("{file}, line {line}"))
    }
}
