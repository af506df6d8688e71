//! Names of policies in scenarios and on the command line.

use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

use dragnet_search::policy::PolicyName as Exact;

use super::Shipped;

/// A policy, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PolicyName {
    /// A policy that is computed, not learned.
    Exact(Exact),
    /// A built-in network that imitates a computed policy.
    Learned(Shipped),
}

impl PolicyName {
    /// All policies.
    pub fn all() -> impl Iterator<Item = Self> {
        let learned = Shipped::ALL.into_iter().map(Self::Learned);
        Exact::ALL.into_iter().map(Self::Exact).chain(learned)
    }

    /// Number of cells after which a robot decides again by default; `None`: at the waypoint.
    #[must_use]
    pub const fn replan_after_cells(self) -> Option<NonZeroU32> {
        match self {
            Self::Exact(name) => name.replan_after_cells(),
            Self::Learned(_) => None,
        }
    }

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Exact(name) => name.as_str(),
            Self::Learned(shipped) => shipped.as_str(),
        }
    }
}

impl From<Exact> for PolicyName {
    fn from(name: Exact) -> Self {
        Self::Exact(name)
    }
}

impl fmt::Display for PolicyName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

/// The text is not the name of a policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown policy {0:?}; allowed are {allowed}", allowed = allowed())]
pub struct UnknownPolicy(pub String);

fn allowed() -> String {
    PolicyName::all().map(PolicyName::as_str).collect::<Vec<_>>().join(", ")
}

impl FromStr for PolicyName {
    type Err = UnknownPolicy;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::all().find(|policy| policy.as_str() == name).ok_or_else(|| UnknownPolicy(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_back_as_it_is_written() {
        for name in PolicyName::all() {
            assert_eq!(name.as_str().parse(), Ok(name));
        }
        let error = "gnm".parse::<PolicyName>().unwrap_err().to_string();
        assert!(
            error.contains("\"gnm\"") && error.contains("path") && error.contains("gnn-greedy"),
            "{error}"
        );
    }
}
