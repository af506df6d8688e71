//! The list of a mission's certificates: names, validity and revocations.

use std::fmt;

use dragnet_proto::key::Mission;
use serde::{Deserialize, Serialize};
use time::OffsetDateTime;

use crate::KeysError;
use crate::name::Name;

/// The connections of a mission.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Topology {
    /// Every pair of participants has a connection, so no participant has to trust another to forward messages.
    #[default]
    Mesh,
    /// All participants connect to the coordinator only, which forwards the messages of the others, so all have to
    /// trust it.
    Star,
}

/// All certificates of a mission, in the order in which they were made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Register {
    /// Name of the mission, as in the settings of its processes.
    pub mission: String,
    /// The connections of the mission.
    pub topology: Topology,
    /// The certificates.
    #[serde(default)]
    pub certificates: Vec<Entry>,
}

/// One certificate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// The owner.
    pub name: Name,
    /// Its serial number in the mission, from 2: that of the authority's own certificate is 1.
    pub serial: u64,
    /// When its validity ends, seconds since 1970-01-01 UTC.
    pub valid_until: i64,
    /// Whether it was revoked.
    #[serde(default)]
    pub revoked: bool,
    /// Host names and addresses of its owner; may be empty.
    #[serde(default)]
    pub hosts: Vec<String>,
}

/// The state of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It is valid.
    Valid,
    /// It has expired.
    Expired,
    /// It was revoked.
    Revoked,
}

impl fmt::Display for Standing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Valid => "valid",
            Self::Expired => "expired",
            Self::Revoked => "revoked",
        })
    }
}

impl Entry {
    /// The certificate's common name, by which the others know its owner: `robot-1#2`. A new certificate has a
    /// different one, so that a revoked one stays distinguishable. No public authority signs such a name, since it is
    /// not a host's.
    #[must_use]
    pub fn common_name(&self) -> String {
        format!("{}#{}", self.name, self.serial)
    }

    /// The state of the certificate at a time.
    #[must_use]
    pub fn standing(&self, now: OffsetDateTime) -> Standing {
        if self.revoked {
            Standing::Revoked
        } else if now.unix_timestamp() > self.valid_until {
            Standing::Expired
        } else {
            Standing::Valid
        }
    }

    /// The last day on which it is valid, UTC.
    #[must_use]
    pub fn last_day(&self) -> time::Date {
        OffsetDateTime::from_unix_timestamp(self.valid_until).map_or(time::Date::MAX, OffsetDateTime::date)
    }
}

impl Register {
    /// An empty list.
    #[must_use]
    pub fn new(mission: &Mission, topology: Topology) -> Self {
        Self { mission: mission.to_string(), topology, certificates: Vec::new() }
    }

    /// The mission.
    ///
    /// # Errors
    /// If its name is invalid.
    pub fn mission(&self) -> Result<Mission, KeysError> {
        Ok(self.mission.parse()?)
    }

    /// The serial number of the next certificate; no number is used twice.
    #[must_use]
    pub fn next_serial(&self) -> u64 {
        self.certificates.iter().map(|entry| entry.serial).max().unwrap_or(1) + 1
    }

    /// Certificates that were not revoked, by name: those that the others trust, until they expire.
    #[must_use]
    pub fn holders(&self) -> Vec<&Entry> {
        let mut holders: Vec<&Entry> = self.certificates.iter().filter(|entry| !entry.revoked).collect();
        holders.sort_by_key(|entry| (entry.name, entry.serial));
        holders
    }

    /// A participant's certificate that was not revoked.
    #[must_use]
    pub fn holder(&self, name: Name) -> Option<&Entry> {
        self.certificates.iter().find(|entry| entry.name == name && !entry.revoked)
    }

    /// Certificates that were revoked.
    pub fn revoked(&self) -> impl Iterator<Item = &Entry> {
        self.certificates.iter().filter(|entry| entry.revoked)
    }
}
