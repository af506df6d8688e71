//! How a recording ends, and which parts of it are lost.

use std::fmt;

use serde::Serialize;

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Ending {
    /// It was finished.
    Complete,
    /// It was finished, and other data follow in the same file, such as a second recording. They are not read.
    Followed {
        /// Where they begin.
        at_byte: u64,
        /// Their length.
        bytes: u64,
    },
    /// It ends early: its writer was stopped, or its end was lost.
    CutOff,
    /// Parts of it are damaged. All intact parts are read, also those behind.
    Damaged {
        /// The first damage, and where.
        reason: String,
        /// Number of damaged parts.
        places: u64,
        /// Their bytes, together.
        lost_bytes: u64,
        /// Messages that were written and could not be read, if the file's index is intact.
        lost_messages: Option<u64>,
        /// Messages that are whole, but of topics whose definition is lost.
        messages_without_topic: u64,
        /// Whether its end is lost too.
        is_cut_off: bool,
    },
}

impl fmt::Display for Ending {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Complete => formatter.write_str("complete"),
            Self::CutOff => formatter.write_str("cut off"),
            Self::Followed { at_byte, bytes } => write!(
                formatter,
                "complete, but {bytes} bytes follow its end and are not read; if they are another recording, \
                 `tail -c +{} FILE > OTHER` makes a file of it",
                at_byte + 1
            ),
            Self::Damaged {
                reason,
                places,
                lost_bytes,
                lost_messages,
                messages_without_topic,
                is_cut_off,
            } => {
                let places = if *places == 1 { "one place".to_owned() } else { format!("{places} places") };
                let messages =
                    lost_messages.map_or("an unknown number of".to_owned(), |number| number.to_string());
                write!(
                    formatter,
                    "damaged in {places}: {lost_bytes} bytes are lost, with {messages} messages; first {reason}"
                )?;
                if *messages_without_topic > 0 {
                    write!(
                        formatter,
                        "; {messages_without_topic} more messages cannot be read, because the lost bytes define their topics"
                    )?;
                }
                if *is_cut_off { formatter.write_str("; its end is cut off too") } else { Ok(()) }
            }
        }
    }
}
