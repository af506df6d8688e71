//! Checks that a TOML text has the shape of the values read from it. Serde accepts a list in place of a table, and
//! ignores the rest of a list that is too long; both are most likely mistakes.

use serde::Serialize;
use toml::{Table, Value};

/// A list in a text that is longer than, or different from, the values read from it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} is {found}; allowed is {allowed}")]
pub(super) struct WrongShape {
    /// Path of the key, such as `objects.cells[1]`.
    pub(super) key: String,
    /// The value.
    pub(super) found: String,
    /// The allowed values.
    pub(super) allowed: String,
}

/// Compares a text with the values read from it, serialized under the same names.
///
/// # Errors
/// The first list that was read as a table, or is longer than the values read from it.
pub(super) fn check(text: &str, read: &impl Serialize) -> Result<(), WrongShape> {
    let (Ok(written), Ok(read)) = (text.parse::<Table>(), Table::try_from(read)) else { return Ok(()) };
    tables("", &written, &read)
}

fn tables(place: &str, written: &Table, read: &Table) -> Result<(), WrongShape> {
    let dot = if place.is_empty() { "" } else { "." };
    let mut both = written.iter().filter_map(|(key, value)| Some((key, value, read.get(key)?)));
    both.try_for_each(|(key, written, read)| values(&format!("{place}{dot}{key}"), written, read))
}

fn values(key: &str, written: &Value, read: &Value) -> Result<(), WrongShape> {
    let wrong = |found: String, allowed: String| Err(WrongShape { key: key.to_owned(), found, allowed });
    match (written, read) {
        (Value::Table(written), Value::Table(read)) => tables(key, written, read),
        (Value::Array(written), Value::Array(read)) if written.len() > read.len() => {
            let found = format!("a list of {} values", written.len());
            wrong(found, format!("a list of {}", read.len()))
        }
        (Value::Array(written), Value::Array(read)) => {
            (0..).zip(written.iter().zip(read)).try_for_each(|(index, (written, read)): (usize, _)| {
                values(&format!("{key}[{index}]"), written, read)
            })
        }
        (Value::Array(_), Value::Table(read)) => {
            let keys: Vec<&str> = read.keys().map(String::as_str).collect();
            wrong("a list".to_owned(), format!("a table with keys such as {}", keys.join(", ")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::mentions::assert_mentions;

    #[derive(Serialize, Deserialize)]
    struct Drawn {
        corners: Vec<(f64, f64)>,
        origin: Option<Origin>,
    }

    #[derive(Serialize, Deserialize)]
    struct Origin {
        north: i64,
        east: i64,
    }

    #[test]
    fn a_list_is_no_longer_than_what_is_read_of_it() {
        let reported = |text: &str| {
            let read: Drawn = toml::from_str(text).unwrap();
            check(text, &read).map_err(|error| error.to_string())
        };
        assert_eq!(reported("corners = [[1, 2], [3, 4]]\norigin = { north = 1, east = 2 }"), Ok(()));
        let long = reported("corners = [[1, 2], [3, 4, 5]]").unwrap_err();
        assert_mentions(&long, "corners[1] .. 3 .. a list of 2");
        let list = reported("corners = []\norigin = [1, 2]").unwrap_err();
        assert_mentions(&list, "origin .. a list .. a table .. east, north");
    }
}
