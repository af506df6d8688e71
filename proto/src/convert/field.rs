//! The position of a field in a message.

use std::fmt;

/// A field of a message, printed like `dragnet_msgs/msg/SyncReply: observations[3].cells[0]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    pub(super) message: &'static str,
    pub(super) place: Place,
    pub(super) name: &'static str,
    pub(super) index: Option<usize>,
}

impl fmt::Display for Field {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}{}", self.message, self.place, self.name)?;
        match self.index {
            Some(index) => write!(formatter, "[{index}]"),
            None => Ok(()),
        }
    }
}

/// The part of a message that is being checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The message itself.
    Message,
    /// A heartbeat's intent.
    Intent,
    /// One observation of a sync reply.
    Observation(usize),
    /// One detection of a mission status.
    Declared(usize),
    /// An entry of `version_vector`.
    Known(usize),
    /// The operator's directive.
    Directive,
    /// One of the operator's marks.
    Mark(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Message => Ok(()),
            Self::Intent => write!(formatter, "intent."),
            Self::Observation(index) => write!(formatter, "observations[{index}]."),
            Self::Declared(index) => write!(formatter, "declared[{index}]."),
            Self::Known(index) => write!(formatter, "version_vector[{index}]."),
            Self::Directive => write!(formatter, "directive."),
            Self::Mark(index) => write!(formatter, "marks[{index}]."),
        }
    }
}
