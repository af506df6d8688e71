//! Errors of participants and teams.

use std::path::PathBuf;
use std::time::Duration;

use dragnet_export::cot::NotOnEarth;
use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::participant::Participant;

use crate::source_places::without;

/// Why a participant, or a whole team, cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// A file of settings is invalid.
    #[error("{file}: {reason}", file = file.display(), reason = without(reason))]
    Settings {
        /// The file.
        file: PathBuf,
        /// The problem.
        reason: String,
    },
    /// The text of settings is not TOML, has an unknown key, or a value of the wrong type.
    #[error("{place}: {message}")]
    SettingsText {
        /// The file, and the line where it is known.
        place: String,
        /// The key, the error, and the allowed values.
        message: String,
    },
    /// A session could not be opened, for example because a port is in use.
    #[error("cannot open a Zenoh session that listens on [{listen}]: {reason}", reason = without(reason))]
    Open {
        /// The endpoints to listen on.
        listen: String,
        /// Zenoh's message.
        reason: String,
    },
    /// An operation on an open session failed.
    #[error("Zenoh cannot {what}: {reason}", reason = without(reason))]
    Zenoh {
        /// The operation.
        what: String,
        /// Zenoh's message.
        reason: String,
    },
    /// A participant did not join.
    #[error("waited {seconds:.0} s for {participant}, in vain", seconds = waited.as_secs_f64())]
    Absent {
        /// The participant.
        participant: String,
        /// The waiting time.
        waited: Duration,
    },
    /// A participant failed, or its answer is invalid.
    #[error("{participant}: {reason}")]
    Participant {
        /// The participant.
        participant: Participant,
        /// The reason.
        reason: String,
    },
    /// A robot's process could not be started, or ended too early.
    #[error("the process of {participant}: {reason}")]
    Process {
        /// The participant.
        participant: Participant,
        /// The reason.
        reason: String,
    },
    /// A robot's journal cannot be used.
    #[error(transparent)]
    Journal(#[from] crate::journal::JournalError),
    /// The recording is incomplete.
    #[error(transparent)]
    Recording(#[from] dragnet_coordinator::RecordingError),
    /// The search was stopped by the user; all until then is recorded.
    #[error("stopped before the search was over{}", until_then(recording.as_ref()))]
    Stopped {
        /// Its recording.
        recording: Option<PathBuf>,
    },
    /// The operator did not wait for the robots' return; all until then is recorded.
    #[error("the operator ended the mission before the search was over{}", until_then(recording.as_ref()))]
    Ended {
        /// Its recording.
        recording: Option<PathBuf>,
    },
    /// An address for an autopilot or its detectors cannot be used.
    #[error("{0}")]
    Mavlink(String),
    /// The scenario asks for something that this mode does not support.
    #[error("{0}")]
    Unsupported(String),
}

impl From<ParticipantError> for RuntimeError {
    fn from(ParticipantError { participant, reason }: ParticipantError) -> Self {
        Self::Participant { participant, reason }
    }
}

impl From<NotOnEarth> for RuntimeError {
    fn from(error: NotOnEarth) -> Self {
        Self::Unsupported(error.to_string())
    }
}

impl RuntimeError {
    /// Wraps Zenoh's error, with the operation.
    pub(crate) fn zenoh(what: impl Into<String>) -> impl FnOnce(zenoh::Error) -> Self {
        let what = what.into();
        move |error| Self::Zenoh { what, reason: error.to_string() }
    }

    /// Whether the input is the cause, so that trying again with the same input cannot help.
    #[must_use]
    pub const fn is_bad_input(&self) -> bool {
        use dragnet_coordinator::RecordingError;

        use crate::journal::JournalError;
        matches!(
            self,
            Self::Settings { .. }
                | Self::SettingsText { .. }
                | Self::Open { .. }
                | Self::Mavlink(_)
                | Self::Unsupported(_)
                | Self::Journal(
                    JournalError::Foreign { .. }
                        | JournalError::NotAJournal { .. }
                        | JournalError::NotAFile { .. }
                        | JournalError::Content { .. }
                )
                | Self::Recording(
                    RecordingError::Create { .. }
                        | RecordingError::Exists { .. }
                        | RecordingError::NoPlainFile { .. }
                        | RecordingError::Read { .. }
                        | RecordingError::NotARecording { .. }
                )
        )
    }
}

fn until_then(recording: Option<&PathBuf>) -> String {
    recording.map(|file| format!("; {} holds all until then", file.display())).unwrap_or_default()
}
