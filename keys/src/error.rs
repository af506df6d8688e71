//! What can go wrong with certificates.

use std::path::{Path, PathBuf};

use dragnet_proto::key::MissionError;

use crate::name::NameError;

/// Why certificates could not be made, listed or revoked.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// A file or folder cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It is there already, and nothing is ever overwritten.
    #[error("{path} exists: no key is ever overwritten; name a folder that does not", path = path.display())]
    Exists {
        /// What is there.
        path: PathBuf,
    },
    /// The list of certificates is not what it should be.
    #[error("{path}: {reason}", path = path.display())]
    Register {
        /// The list.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A mission that cannot be.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// A participant that cannot be.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A host that cannot stand in a certificate.
    #[error("host {0:?}: allowed are names such as robot-1.local and addresses such as 192.168.1.11")]
    Host(String),
    /// Certificates for no time at all, or for too long.
    #[error("{0} days: allowed are 1 to {max}", max = crate::certificate::MAX_DAYS)]
    Days(u32),
    /// Somebody has a certificate already.
    #[error("{name} has a certificate that holds until {until}: revoke it first, then add {name} again")]
    Holds {
        /// Who.
        name: String,
        /// The last day.
        until: time::Date,
    },
    /// Somebody has none that could be revoked.
    #[error("{name} has no certificate that holds; those who have: {holders}")]
    Unknown {
        /// Who.
        name: String,
        /// Who has, in words.
        holders: String,
    },
    /// The certificate itself could not be made.
    #[error("cannot make the certificate of {name}: {reason}")]
    Certificate {
        /// Whose.
        name: String,
        /// What the library says.
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
