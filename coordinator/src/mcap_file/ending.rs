//! How a recording ends, and what of it is lost.

use std::fmt;

use serde::Serialize;

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Ending {
    /// It was finished.
    Complete,
    /// Whoever wrote it was stopped, or the end is lost.
    CutOff,
    /// Parts of it cannot be right. All that is whole is read, also behind them.
    Damaged {
        /// What is wrong at the first of them, and where.
        reason: String,
        /// How many parts.
        places: u64,
        /// Their bytes, together.
        lost_bytes: u64,
        /// Messages that were written and not read, if the file's index is left to tell.
        lost_messages: Option<u64>,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => formatter.write_str("complete"),
            Self::CutOff => formatter.write_str("cut off"),
            Self::Damaged { reason, places, lost_bytes, lost_messages } => {
                let places = if *places == 1 { "one place".to_owned() } else { format!("{places} places") };
                let messages =
                    lost_messages.map_or("an unknown number of".to_owned(), |number| number.to_string());
                write!(
                    formatter,
                    "damaged in {places}: {lost_bytes} bytes are lost, with {messages} messages; first {reason}"
                )
            }
        }
    }
}
