//! The name that distinguishes missions on one network.

use std::fmt;
use std::str::FromStr;

use super::{Key, ROOT, Selection, Topic};

/// Name of a mission: 1 to [`Mission::MAX_LENGTH`] of `a-z`, `0-9`, `_` and `-`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Mission(String);

/// An invalid mission name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("mission {0:?}: allowed are 1 to {max} characters of a-z, 0-9, _ and -", max = Mission::MAX_LENGTH)]
pub struct MissionError(String);

impl Mission {
    /// Characters of the longest name.
    pub const MAX_LENGTH: usize = 64;

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The key of a topic in this mission.
    #[must_use]
    pub fn key(&self, topic: Topic) -> Key {
        Key { mission: self.clone(), topic }
    }

    /// The key expression that matches these keys of this mission.
    #[must_use]
    pub fn expression(&self, of: Selection) -> String {
        format!("{ROOT}/{self}/{of}")
    }
}

impl FromStr for Mission {
    type Err = MissionError;

    fn from_str(name: &str) -> Result<Self, MissionError> {
        let allowed = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
        if (1..=Self::MAX_LENGTH).contains(&name.len()) && name.bytes().all(allowed) {
            Ok(Self(name.to_owned()))
        } else {
            Err(MissionError(name.to_owned()))
        }
    }
}

impl fmt::Display for Mission {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}
