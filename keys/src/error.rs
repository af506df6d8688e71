//! Errors of certificates.

use std::path::{Path, PathBuf};

use dragnet_proto::key::MissionError;

use crate::name::NameError;

/// Why certificates could not be created, listed or revoked.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// Reading or writing a file or folder failed.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// The path.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The path exists, and nothing is overwritten.
    #[error("{path} exists: no key is ever overwritten; name a folder that does not", path = path.display())]
    Exists {
        /// The path.
        path: PathBuf,
    },
    /// The list of certificates is invalid.
    #[error("{path}: {reason}", path = path.display())]
    Register {
        /// The list.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// An invalid mission name.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// An invalid participant name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// An invalid host.
    #[error("host {0:?}: allowed are names such as robot-1.local and addresses such as 192.168.1.11")]
    Host(String),
    /// An invalid validity period.
    #[error("{0} days: allowed are 1 to {max}", max = crate::certificate::MAX_DAYS)]
    Days(u32),
    /// The participant already has a valid certificate.
    #[error("{name} has a certificate that holds until {until}: revoke it first, then add {name} again")]
    Holds {
        /// The participant.
        name: String,
        /// Its last valid day.
        until: time::Date,
    },
    /// The participant has no certificate that could be revoked.
    #[error("{name} has no valid certificate; participants with one: {holders}")]
    Unknown {
        /// The participant.
        name: String,
        /// The participants that have one, in words.
        holders: String,
    },
    /// The certificate could not be created.
    #[error("cannot make the certificate of {name}: {reason}")]
    Certificate {
        /// The participant.
        name: String,
        /// The library's message.
        reason: String,
    },
}

impl KeysError {
    pub(crate) fn file(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| match source.kind() {
            std::io::ErrorKind::AlreadyExists => Self::Exists { path },
            _ => Self::File { path, source },
        }
    }

    pub(crate) fn certificate(name: &str) -> impl FnOnce(rcgen::Error) -> Self {
        let name = name.to_string();
        move |error| Self::Certificate { name, reason: error.to_string() }
    }
}
