//! Why a scenario cannot be run.

use std::io;
use std::path::PathBuf;

use dragnet_files::FileError;

use super::check::Invalid;
use super::{Source, of_map};
use crate::map_file::MapFileError;
use crate::shipped::ShippedScenario;
use crate::toml_text::{TextError, line_of_key};

/// Why a scenario cannot be run. Each message names the file, the place, the value and the allowed values.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is no such file, and no shipped scenario has this name.
    #[error("{}: {source}; scenarios that need no file: {}", file.display(), names())]
    Missing {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is unreadable.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The text is not TOML, has an unknown key, or a value of the wrong type.
    #[error("{place}: {message}")]
    Syntax {
        /// File and line.
        place: String,
        /// The key, the error, and the allowed values.
        message: String,
    },
    /// A value that is out of range, or contradicts another.
    #[error("{place}: {invalid}")]
    Value {
        /// The file, and the line if the value has one.
        place: String,
        /// The invalid value.
        invalid: Invalid,
    },
    /// A file that the scenario names is invalid.
    #[error("{place}: {source}")]
    MapFile {
        /// File and line.
        place: String,
        /// The cause.
        source: Box<MapFileError>,
    },
    /// A map that is searched without a scenario is invalid.
    #[error(transparent)]
    Map(Box<MapFileError>),
    /// A weights file that the scenario names is invalid.
    #[error("{place}: {key}: {source}")]
    Weights {
        /// The file, and the line if the value has one.
        place: String,
        /// Path of the key, such as `robots.policy.weights`.
        key: String,
        /// The cause.
        source: FileError,
    },
    /// An invalid value on the command line.
    #[error("{}, changed on the command line: {invalid}", file.display())]
    Override {
        /// The scenario.
        file: PathBuf,
        /// The invalid value; its key is that of the scenario.
        invalid: Invalid,
    },
}

/// An error of a part, before the place of the part is known.
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
    pub(super) fn text_error(&self, TextError { line, message }: TextError) -> ScenarioError {
        ScenarioError::Syntax { place: self.place(line), message }
    }

    pub(super) fn error(&self, fault: Fault) -> ScenarioError {
        match fault {
            Fault::Value(invalid) => {
                let place = self.place(line_of_key(&self.text, &invalid.key));
                ScenarioError::Value { place, invalid }
            }
            // Nobody has written the text of a scenario that is made for a map.
            Fault::MapFile { source, .. } if of_map::is_map(&self.path) => {
                ScenarioError::Map(Box::new(source))
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
        let line = line.filter(|_| !of_map::is_map(&self.path));
        line.map_or_else(|| file.to_string(), |line| format!("{file}, line {line}"))
    }
}
/// Names of the shipped scenarios; the paper's are the same search on other maps.
fn names() -> String {
    let names = ShippedScenario::all().map(|scenario| scenario.name());
    names.filter(|name| !name.contains('/')).collect::<Vec<_>>().join(", ")
}
