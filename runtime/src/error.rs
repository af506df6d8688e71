//! What can go wrong on the network.

use std::path::PathBuf;
use std::time::Duration;

use dragnet_scenario::participant::Participant;

use crate::source_places::without;

/// Why a participant, or a whole team, cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RuntimeError {
    /// A file of settings is not what it should be.
    #[error("{file}: {reason}", file = file.display(), reason = without(reason))]
    Settings {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A session could not be opened, as when a port is in use.
    #[error("cannot open a Zenoh session that listens on [{listen}]: {reason}", reason = without(reason))]
    Open {
        /// Where it was to listen.
        listen: String,
        /// What Zenoh says.
        reason: String,
    },
    /// Zenoh refused something on an open session.
    #[error("Zenoh cannot {what}: {reason}", reason = without(reason))]
    Zenoh {
        /// What was tried.
        what: String,
        /// What Zenoh says.
        reason: String,
    },
    /// Somebody is not there.
    #[error("waited {seconds:.0} s for {who}, in vain", seconds = waited.as_secs_f64())]
    Absent {
        /// Who.
        who: String,
        /// How long.
        waited: Duration,
    },
    /// A participant says that it cannot go on, or says what makes no sense.
    #[error("{who}: {reason}")]
    Participant {
        /// Who.
        who: Participant,
        /// What is wrong.
        reason: String,
    },
    /// A robot's process could not be started, or ended before its time.
    #[error("the process of {who}: {reason}")]
    Process {
        /// Who.
        who: Participant,
        /// What is wrong.
        reason: String,
    },
    /// A robot's journal is not to be had.
    #[error(transparent)]
    Journal(#[from] crate::journal::JournalError),
    /// The recording is not whole.
    #[error(transparent)]
    Recording(#[from] dragnet_coordinator::RecordingError),
    /// Somebody stopped a search; all until then is recorded.
    #[error("stopped before the search was over{}", recording.as_ref().map(|file| format!("; {} holds all until then", file.display())).unwrap_or_default())]
    Stopped {
        /// Its recording.
        recording: Option<PathBuf>,
    },
    /// This mode cannot do what the scenario asks for.
    #[error("{0}")]
    Unsupported(String),
}

impl RuntimeError {
    /// Zenoh's own error, and what was tried.
    pub(crate) fn zenoh(what: impl Into<String>) -> impl FnOnce(zenoh::Error) -> Self {
        let what = what.into();
        move |error| Self::Zenoh { what, reason: error.to_string() }
    }

    /// Whether the user can mend it by other input, rather than by trying again.
    #[must_use]
    pub const fn is_bad_input(&self) -> bool {
        use dragnet_coordinator::RecordingError;

        use crate::journal::JournalError;
        matches!(
            self,
            Self::Settings { .. }
                | Self::Open { .. }
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
                        | RecordingError::Read { .. }
                        | RecordingError::NotARecording { .. }
                )
        )
    }
}
