//! Reads TOML texts that people write: scenarios, and the settings of processes. An error names the line and the key,
//! and says in words what is allowed.

mod locate;
mod shape;

use dragnet_files::in_words;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_path_to_error::{Path, Track};
use toml::de::DeTable;

pub(crate) use locate::line_of_key;
use locate::{line_at, line_of_longest_key};

/// Why a text is not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct TextError {
    /// The line, from 1, where it is known.
    pub line: Option<usize>,
    /// The key, the error, and the allowed values.
    pub message: String,
}

/// Reads a TOML text. Values are serialized under the names by which they are read.
///
/// # Errors
/// If the text is not TOML, has an unknown key, a value of the wrong type, or a list where a table belongs.
pub fn read<T: DeserializeOwned + Serialize>(text: &str) -> Result<T, TextError> {
    let table = DeTable::parse(text).map_err(|error| TextError::of_syntax(text, &error))?;
    let mut path = Track::new();
    let values = serde_path_to_error::Deserializer::new(toml::Deserializer::from(table), &mut path);
    let read = erased_serde::deserialize(&mut <dyn erased_serde::Deserializer>::erase(values))
        .map_err(|error| TextError::of_value(text, &error, &path.path()))?;
    shape::check(text, &read).map_err(|wrong| TextError {
        line: line_of_key(text, &wrong.key),
        message: shortened(&wrong.to_string()),
    })?;
    Ok(read)
}

/// Whether a TOML text has a key at the top level: one that only a certain kind of file has tells of which kind it is.
#[must_use]
pub fn has_key(text: &str, key: &str) -> bool {
    DeTable::parse(text).is_ok_and(|table| table.get_ref().contains_key(key))
}

impl TextError {
    /// The same error with what else is to be known of the file.
    #[must_use]
    pub fn with(self, note: &str) -> Self {
        Self { message: format!("{}; {note}", self.message), ..self }
    }

    /// The text is not TOML.
    fn of_syntax(text: &str, error: &toml::de::Error) -> Self {
        let message = in_words(error.message().trim_end());
        let (line, message) = match error.span() {
            Some(span) if message == "duplicate key" => {
                let key = text.get(span.clone()).unwrap_or_default();
                (line_at(text, span.start), format!("{key} is given twice"))
            }
            Some(span) => (line_at(text, span.start), message),
            // For a key with too many parts the parser reports neither the key nor its place.
            None => (line_of_longest_key(text), format!("a key of too many parts: {message}")),
        };
        Self { line: Some(line), message: shortened(&message) }
    }

    /// A value is not what it should be.
    fn of_value(text: &str, error: &erased_serde::Error, path: &Path) -> Self {
        let error = error.to_string();
        // The lines after the first are TOML's: the keys around the value, which the path has too.
        let message = in_words(error.lines().next().unwrap_or_default());
        let path = path.to_string();
        if path == "." {
            return Self { line: Some(1), message: shortened(&message) };
        }
        Self { line: line_of_key(text, &path), message: shortened(&format!("{path}: {message}")) }
    }
}

/// The most characters of a message about one value.
const MOST_CHARACTERS: usize = 400;

/// The beginning and the end of a text that is too long to display.
pub(crate) fn shortened(text: &str) -> String {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() <= MOST_CHARACTERS {
        return text.to_owned();
    }
    let (beginning, rest) = characters.split_at(MOST_CHARACTERS / 2);
    let end = &rest[rest.len() - MOST_CHARACTERS / 2..];
    format!("{} ... {}", beginning.iter().collect::<String>(), end.iter().collect::<String>())
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Settings {
        robot: u16,
        start: Option<(u32, u32)>,
    }

    #[test]
    fn an_error_names_the_line_and_the_key_in_words() {
        let error = |text: &str| {
            let error = read::<Settings>(text).unwrap_err();
            (error.line, error.message)
        };
        let at = |line: usize, message: &str| (Some(line), message.to_owned());
        assert_eq!(read("robot = 3"), Ok(Settings { robot: 3, start: None }));
        assert_eq!(error("robot = 3\nrobot = 4"), at(2, "robot is given twice"));
        assert_eq!(
            error("\nrobot = -1"),
            at(2, "robot: invalid value: integer `-1`, expected a whole number from 0 to 65535")
        );
        assert_eq!(
            error("robot = [1]"),
            at(1, "robot: invalid type: a list, expected a whole number from 0 to 65535")
        );
        assert_eq!(
            error("robot = 1\nstart = [1, 2, 3]"),
            at(2, "start is a list of 3 values; allowed is a list of 2")
        );
    }
}
