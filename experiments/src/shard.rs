//! Shards: the division of a command's jobs among processes, and the files with their results.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::ExperimentError;

/// The maximum number of missing shards that are listed.
const MAX_NAMED: usize = 20;

/// One of a number of shards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Shard {
    /// Its number, from 1 to the number of shards.
    number: u32,
    count: u32,
}

impl Shard {
    /// The maximum number of shards.
    pub(crate) const MAX_COUNT: u32 = 100_000;

    /// The only shard of an undivided command: all jobs.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// Whether a job, by its index from 0, belongs to this shard.
    pub(crate) fn holds(self, place: u64) -> bool {
        place % u64::from(self.count) == self.seat(place / u64::from(self.count))
    }

    /// The indices of this shard's jobs, ascending.
    pub(crate) fn places(self, jobs: u64) -> impl Iterator<Item = u64> {
        let count = u64::from(self.count);
        let rounds = 0..jobs.div_ceil(count);
        rounds.map(move |round| round * count + self.seat(round)).filter(move |&place| place < jobs)
    }

    /// Jobs are dealt in rounds, one to each shard: the position of this shard in a round, from 0.
    ///
    /// A round begins a golden section of the shards after the one before it: jobs that lie whole rounds apart are
    /// often similar (slow ones of the same map), and so fall to different shards.
    fn seat(self, round: u64) -> u64 {
        /// 2^64 by the golden ratio.
        const GOLDEN_SECTION: u64 = 0x9E37_79B9_7F4A_7C15;
        let count = u128::from(self.count);
        let turn = (u128::from(round.wrapping_mul(GOLDEN_SECTION)) * count) >> u64::BITS;
        let seat = (u128::from(self.number - 1) + count - turn) % count;
        u64::try_from(seat).unwrap_or(u64::MAX)
    }

    /// Name of the file with the shard's results, with this extension.
    pub(crate) fn file_name(self, extension: &str) -> String {
        format!("part-{}-of-{}.{extension}", self.number, self.count)
    }
}

/// The maximum size of a part, bytes.
pub(crate) const MAX_PART_BYTES: u64 = 1 << 30;

/// The path itself if it is a file, or all parts in the folder: at least one.
///
/// # Errors
/// If the folder cannot be read, or contains no part.
pub fn part_files(path: &Path) -> Result<Vec<PathBuf>, ExperimentError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let failure = |what: String| ExperimentError::Input(format!("{}: {what}", path.display()));
    let entries = fs::read_dir(path).map_err(|error| failure(error.to_string()))?;
    let files = entries.map(|entry| entry.map(|entry| entry.path()));
    let mut files = files.collect::<Result<Vec<_>, _>>().map_err(|error| failure(error.to_string()))?;
    files.retain(|file| is_part(file));
    files.sort_unstable();
    if files.is_empty() {
        return Err(failure("no part in this folder; parts are named part-I-of-N".to_owned()));
    }
    Ok(files)
}

/// Whether a file is named as by [`Shard::file_name`].
fn is_part(path: &Path) -> bool {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let numbers = stem.and_then(|stem| stem.strip_prefix("part-")?.split_once("-of-"));
    numbers.is_some_and(|(number, count)| format!("{number}/{count}").parse::<Shard>().is_ok())
}

/// Checks that parts, each with its shard, are all of the same number of shards, and each of these is present exactly
/// once.
pub(crate) fn check_complete(parts: &[(&Path, Shard)]) -> Result<(), ExperimentError> {
    let Some(&(first, Shard { count, .. })) = parts.first() else { return Ok(()) };
    let mut places: Vec<Option<&Path>> = vec![None; count as usize];
    for &(path, shard) in parts {
        if shard.count != count {
            return Err(ExperimentError::Input(format!(
                "{}: shard {shard}, but {} is one of {count}",
                path.display(),
                first.display()
            )));
        }
        if let Some(other) = places[shard.number as usize - 1].replace(path) {
            let (other, path) = (other.display(), path.display());
            return Err(ExperimentError::Input(format!("shard {shard} is there twice: {other} and {path}")));
        }
    }
    let missing = (1..).zip(places).filter_map(|(number, path): (u32, _)| path.is_none().then_some(number));
    match missing.collect::<Vec<u32>>() {
        missing if missing.is_empty() => Ok(()),
        missing => Err(ExperimentError::Input(format!("of {count} shards {}", are_missing(&missing)))),
    }
}

/// `these are missing: 2, 5, 7`
fn are_missing(missing: &[u32]) -> String {
    let named: Vec<String> = missing.iter().take(MAX_NAMED).map(u32::to_string).collect();
    let rest = match missing.len() - named.len() {
        0 => String::new(),
        rest => format!(" and {rest} more"),
    };
    format!("these are missing: {}{rest}", named.join(", "))
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let numbers = text
            .split_once('/')
            .and_then(|(number, count)| Some((number.parse().ok()?, count.parse().ok()?)));
        numbers
            .filter(|&(number, count)| {
                (1..=Self::MAX_COUNT).contains(&count) && (1..=count).contains(&number)
            })
            .map(|(number, count)| Self { number, count })
            .ok_or_else(|| {
                format!("allowed is I/N, such as 3/8: shard I, from 1, of N, up to {}", Self::MAX_COUNT)
            })
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse().map_err(|allowed| format!("{text:?}: {allowed}"))
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_is_written_as_a_number_of_how_many() {
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, count: 8 }));
        assert_eq!("100000/100000".parse::<Shard>().unwrap().to_string(), "100000/100000");
        for wrong in ["", "3", "/", "0/8", "9/8", "1/0", "-1/8", "1/100001", "1/2/3", "a/b", "1.5/2"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    fn places(count: u32, jobs: u64) -> Vec<Vec<u64>> {
        (1..=count).map(|number| Shard { number, count }.places(jobs).collect()).collect()
    }

    #[test]
    fn every_job_falls_to_one_shard_and_shares_differ_by_one_at_most() {
        for count in [1, 2, 3, 7, 20, 100] {
            for jobs in [0, 1, 6, 20, 99, 700] {
                let places = places(count, jobs);
                let shares = places.iter().map(Vec::len);
                let (least, most) = (shares.clone().min().unwrap(), shares.max().unwrap());
                assert!(most - least <= 1, "{jobs} jobs, {count} shards: {places:?}");
                for (number, places) in (1..).zip(&places) {
                    let held = (0..jobs).filter(|&place| Shard { number, count }.holds(place));
                    assert!(held.eq(places.iter().copied()), "{number}/{count}: {places:?}");
                }
                let mut all = places.concat();
                all.sort_unstable();
                assert!(all.into_iter().eq(0..jobs), "{jobs} jobs, {count} shards");
            }
        }
    }

    #[test]
    fn slow_jobs_in_a_row_are_spread_however_their_number_divides_that_of_the_shards() {
        // Blocks of ten seeds: a fast policy, a slow one, and so on.
        let is_slow = |place: &&u64| **place / 10 % 2 == 1;
        for count in [4, 5, 10, 20, 40] {
            let even = 800 / count as usize;
            for places in places(count, 1600) {
                let slow = places.iter().filter(is_slow).count();
                assert!(slow.abs_diff(even) <= 2 + even / 10, "{count} shards: {slow} of a shard");
            }
        }
    }

    #[test]
    fn parts_are_known_by_their_names() {
        assert_eq!(Shard { number: 3, count: 8 }.file_name("json"), "part-3-of-8.json");
        for (name, expected) in [
            ("a/part-3-of-8.json", true),
            ("part-9-of-8.json", false),
            (".unfinished-part-3-of-8.json", false),
            ("summary.csv", false),
        ] {
            assert_eq!(is_part(Path::new(name)), expected, "{name}");
        }
    }

    #[test]
    fn missing_and_repeated_shards_are_named() {
        let check = |shards: &[&str]| {
            let parts: Vec<_> = shards.iter().map(|shard| (Path::new("a"), shard.parse().unwrap())).collect();
            check_complete(&parts).map_err(|failure| match failure {
                ExperimentError::Input(message) => message,
                other => panic!("{other:?}"),
            })
        };
        assert_eq!(check(&["2/3", "1/3", "3/3"]), Ok(()));
        assert_eq!(check(&["2/4", "3/4"]).unwrap_err(), "of 4 shards these are missing: 1, 4");
        assert_eq!(check(&["1/2", "1/2"]).unwrap_err(), "shard 1/2 is there twice: a and a");
        assert_eq!(check(&["1/2", "2/3"]).unwrap_err(), "a: shard 2/3, but a is one of 2");
        assert!(check(&["1/100"]).unwrap_err().ends_with("20, 21 and 79 more"));
    }
}
