//! The seeds of an experiment.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::ExperimentError;

/// The maximum number of seeds, so that their product with the number of cases does not overflow.
const MAX_COUNT: u64 = 1_000_000;

/// A range of consecutive seeds; at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Seeds {
    first: u64,
    count: u64,
}

impl Seeds {
    /// Number of seeds.
    #[must_use]
    pub fn count(self) -> u64 {
        self.count
    }

    /// The seeds of generated scenarios, in order.
    ///
    /// # Errors
    /// If the last one is too large for a mixture.
    pub fn of_mixture(self) -> Result<RangeInclusive<u32>, ExperimentError> {
        let too_large = |seed| {
            let most = u32::MAX;
            ExperimentError::Input(format!("seed {seed}: a mixture has seeds up to {most}"))
        };
        let number = |seed: u64| u32::try_from(seed).map_err(|_| too_large(seed));
        let last = number(self.at(self.count - 1))?;
        Ok(number(self.first)?..=last)
    }

    /// The part of this many seeds, at least one, that begins at an index; both within these.
    #[must_use]
    pub fn part(self, first: u64, count: u64) -> Self {
        Self { first: self.first + first, count }
    }

    /// The seed at an index, `0..count`.
    #[must_use]
    pub fn at(self, place: u64) -> u64 {
        self.first + place
    }
}

impl fmt::Display for Seeds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => write!(formatter, "seed {}", self.first),
            count => write!(formatter, "{count} seeds ({} to {})", self.first, self.first + (count - 1)),
        }
    }
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let bounds = match text.split_once("..") {
            Some((first, end)) => first.parse().ok().zip(end.parse().ok()),
            None => text.parse().ok().map(|count| (0, count)),
        };
        let count = |(first, end): (u64, u64)| end.checked_sub(first).map(|count| Self { first, count });
        bounds.and_then(count).filter(|seeds| (1..=MAX_COUNT).contains(&seeds.count)).ok_or_else(|| {
            format!("allowed is a number of seeds, 1 to {MAX_COUNT}, or a range such as 10..20, which leaves out its end")
        })
    }
}

impl TryFrom<String> for Seeds {
    type Error = String;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse().map_err(|allowed| format!("{text:?}: {allowed}"))
    }
}

/// As a range, `A..B`.
impl From<Seeds> for String {
    fn from(Seeds { first, count }: Seeds) -> Self {
        format!("{first}..{}", first + count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_counts_from_zero_and_a_range_leaves_out_its_end() {
        assert_eq!("3".parse(), Ok(Seeds { first: 0, count: 3 }));
        assert_eq!("5..9".parse(), Ok(Seeds { first: 5, count: 4 }));
        assert_eq!("5..9".parse::<Seeds>().unwrap().to_string(), "4 seeds (5 to 8)");
        assert_eq!(String::from(Seeds { first: 5, count: 4 }), "5..9");
        for wrong in ["", "0", "-1", "9..5", "5..5", "5..", "a", "1.5", "0..9999999999"] {
            assert!(wrong.parse::<Seeds>().is_err(), "{wrong}");
        }
    }
}
