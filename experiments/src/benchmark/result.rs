//! Results: the file that is published, and what is checked when one is read.

use std::fmt::Display;
use std::path::Path;

use dragnet_files::read_at_most;
use dragnet_search::evidence::Digest;
use dragnet_sim::comparison::Trial;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::entry::{Decider, Entry};
use super::summary::{Summary, summaries};
use super::track::Track;
use crate::cut_off::is_cut_off;
use crate::{ExperimentError, output};

const FORMAT: &str = "dragnet benchmark result";
/// The version of the format; no other is read.
const FORMAT_VERSION: u32 = 1;
/// The maximum size of a file, bytes.
const MAX_BYTES: u64 = 1 << 28;

/// The results of policies on a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BenchmarkResult {
    format: String,
    format_version: u32,
    track: TrackStamp,
    program: Program,
    /// Each policy, in the order of the tables.
    pub policies: Vec<PolicyResult>,
    /// XXH3-128 of the compact JSON of all of the above, 32 hexadecimal digits.
    digest: String,
}

/// The track of a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrackStamp {
    name: String,
    version: u32,
    digest: String,
}

/// The program that ran the episodes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Program {
    /// Its version.
    pub version: String,
    /// Its commit, if it knows it.
    pub commit: Option<String>,
}

/// One policy's results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolicyResult {
    /// Its name in tables.
    pub name: String,
    /// What decides.
    pub decider: Decider,
    /// One for each group of searches, then one for all.
    pub summary: Vec<Summary>,
    /// Every episode, in the order of the track.
    pub episodes: Vec<EpisodeResult>,
}

/// One episode's results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EpisodeResult {
    /// Name of the search.
    pub search: String,
    /// Of the episode.
    pub seed: u64,
    /// Path length of the farthest robot until every object was found, cells; `None` if that was not within the budget.
    pub cells_to_full_recall: Option<f64>,
    /// Mean of recall over path lengths from 0 to the budget, `0..=1`.
    pub average_recall: f64,
    /// Recall at the budget, `0..=1`.
    pub recall: f64,
}

/// The beginning of a file, of whatever version.
#[derive(Deserialize)]
struct Stamp {
    format: String,
    format_version: u32,
}

impl BenchmarkResult {
    /// The results of a program on a track: each policy with the trials of all episodes, in the order of the track.
    #[must_use]
    pub fn new(track: &Track, program: Program, policies: Vec<(Entry, Vec<Trial>)>) -> Self {
        let policies = policies.into_iter().map(|(entry, trials)| PolicyResult::new(track, entry, &trials));
        let mut result = Self {
            format: FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            track: TrackStamp::of(track),
            program,
            policies: policies.collect(),
            digest: String::new(),
        };
        result.digest = result.digest_of_content();
        result
    }

    /// Name of its track.
    #[must_use]
    pub fn track_name(&self) -> &str {
        &self.track.name
    }

    /// The program that ran it.
    #[must_use]
    pub const fn program(&self) -> &Program {
        &self.program
    }

    /// The digest over all of it.
    #[must_use]
    pub fn digest(&self) -> &str {
        &self.digest
    }

    /// The text of the file.
    ///
    /// # Errors
    /// Never, since all of it can be written as JSON.
    pub fn to_json(&self) -> Result<String, ExperimentError> {
        serde_json::to_string(self).map(|json| json + "\n").map_err(ExperimentError::run)
    }

    /// Writes the file atomically.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), ExperimentError> {
        output::write(path, self.to_json()?.as_bytes())
    }

    /// Reads a file and checks that it is whole, unchanged, of this version of the program, and of a track as this program
    /// has it; returns it with its track.
    ///
    /// # Errors
    /// If it is not.
    pub fn read(path: &Path, program: &Program) -> Result<(Self, Track), ExperimentError> {
        let wrong = |what: &dyn Display| ExperimentError::Input(format!("{}: {what}", path.display()));
        let bytes = read_at_most(path, MAX_BYTES).map_err(|error| wrong(&error))?;
        Self::parse(&bytes, program).map_err(|what| wrong(&what))
    }

    fn parse(json: &[u8], program: &Program) -> Result<(Self, Track), String> {
        let stamp: Stamp = serde_json::from_slice(json).map_err(|error| unreadable(json, &error))?;
        if stamp.format != FORMAT {
            return Err(format!("{NO_RESULT} (its format is {:?})", stamp.format));
        }
        if stamp.format_version != FORMAT_VERSION {
            let version = stamp.format_version;
            return Err(format!(
                "a result of format version {version}; this program reads version {FORMAT_VERSION}"
            ));
        }
        let result: Self =
            serde_json::from_slice(json).map_err(|error| format!("a damaged result: {error}"))?;
        let digest = result.digest_of_content();
        if digest != result.digest {
            return Err(format!(
                "an edited or damaged result: it has digest {digest} and says {}",
                result.digest
            ));
        }
        let version = &result.program.version;
        if *version != program.version {
            return Err(format!(
                "a result of dragnet {version}; this is {}, and other versions may decide otherwise",
                program.version
            ));
        }
        let track = Track::named(&result.track.name).map_err(|error| error.to_string())?;
        let frozen = TrackStamp::of(&track);
        if result.track != frozen {
            let TrackStamp { name, version, digest } = &result.track;
            return Err(format!(
                "a result of track {name} version {version} with digest {digest}; this program has version {} with \
                 digest {}",
                frozen.version, frozen.digest
            ));
        }
        result.policies.iter().try_for_each(|policy| policy.check(&track))?;
        Ok((result, track))
    }

    /// The digest that it should have.
    fn digest_of_content(&self) -> String {
        let content = Self { digest: String::new(), ..self.clone() };
        // What has no JSON has no file either.
        Digest(xxh3_128(&serde_json::to_vec(&content).unwrap_or_default())).to_string()
    }
}

impl TrackStamp {
    fn of(track: &Track) -> Self {
        Self { name: track.name().to_owned(), version: track.version(), digest: track.digest().to_string() }
    }
}

impl PolicyResult {
    fn new(track: &Track, entry: Entry, trials: &[Trial]) -> Self {
        debug_assert_eq!(track.episodes().count(), trials.len());
        let of = |((search, _), trial): ((usize, u64), &Trial)| {
            EpisodeResult::new(track.searches()[search].scenario.name(), trial)
        };
        let episodes: Vec<EpisodeResult> = track.episodes().zip(trials).map(of).collect();
        let Entry { name, decider } = entry;
        Self { name, decider, summary: summaries(track, &episodes, Some(trials)), episodes }
    }

    /// What decided, as an entry of another run.
    #[must_use]
    pub fn entry(&self) -> Entry {
        Entry { name: self.name.clone(), decider: self.decider.clone() }
    }

    /// Checks that the episodes are those of the track, and that the summary is theirs, but for computing times.
    fn check(&self, track: &Track) -> Result<(), String> {
        let name = &self.name;
        let expected =
            track.episodes().map(|(search, seed)| (track.searches()[search].scenario.name(), seed));
        if !expected.eq(self.episodes.iter().map(|it| (it.search.as_str(), it.seed))) {
            return Err(format!("policy {name}: its episodes are not those of track {}", track.name()));
        }
        let untimed = |summary: &Summary| Summary { decision_ms_p50: None, ..summary.clone() };
        let own: Vec<Summary> = self.summary.iter().map(untimed).collect();
        if own == summaries(track, &self.episodes, None) {
            Ok(())
        } else {
            Err(format!("policy {name}: its summary is not that of its episodes"))
        }
    }
}

impl EpisodeResult {
    /// What is kept of a trial.
    #[must_use]
    pub fn new(search: &str, trial: &Trial) -> Self {
        Self {
            search: search.to_owned(),
            seed: trial.seed,
            cells_to_full_recall: trial.cells_to_full_recall,
            average_recall: trial.average_recall,
            recall: trial.recall,
        }
    }
}

const NO_RESULT: &str = "no result of a benchmark; allowed is what `dragnet benchmark --out` writes";

fn unreadable(json: &[u8], error: &serde_json::Error) -> String {
    if is_cut_off(json, error) {
        format!("a result that was cut off ({error})")
    } else {
        format!("{NO_RESULT} ({error})")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::comparison::run_episodes;
    use crate::progress::{Progress, Work};

    pub(in super::super) struct Unseen;

    impl Progress for Unseen {
        fn begin(&self, _steps: u64, _unit: &str) -> Box<dyn Work> {
            Box::new(Self)
        }
    }

    impl Work for Unseen {
        fn advance(&self, _steps: u64) {}
    }

    pub(in super::super) fn program() -> Program {
        Program { version: "1.2.3".to_owned(), commit: None }
    }

    /// A fast policy on `smoke`.
    pub(in super::super) fn greedy() -> BenchmarkResult {
        let track = Track::named("smoke").unwrap();
        let entry = Entry::of_policy("mine".to_owned(), &"greedy".parse().unwrap(), None).unwrap();
        let cases = entry.cases(&track, None).unwrap();
        let episodes: Vec<_> = track.episodes().map(|(search, seed)| (&cases[search], seed)).collect();
        let trials = run_episodes(&episodes, None, &Unseen).unwrap().results;
        BenchmarkResult::new(&track, program(), vec![(entry, trials)])
    }

    impl BenchmarkResult {
        /// As one who edits a result and computes its digest anew.
        pub(in super::super) fn edited(mut self, edit: impl FnOnce(&mut Self)) -> Self {
            edit(&mut self);
            self.digest = self.digest_of_content();
            self
        }
    }

    fn refused(json: &str) -> String {
        BenchmarkResult::parse(json.as_bytes(), &program()).err().unwrap()
    }

    #[test]
    fn a_result_survives_its_file() {
        let result = greedy();
        let (read, track) = BenchmarkResult::parse(result.to_json().unwrap().as_bytes(), &program()).unwrap();
        assert_eq!(read, result);
        assert_eq!((track.name(), read.track_name()), ("smoke", "smoke"));
        assert!(result.policies[0].episodes.iter().any(|it| it.cells_to_full_recall.is_some()));
    }

    #[test]
    fn what_is_no_whole_and_unchanged_result_is_refused() {
        let json = greedy().to_json().unwrap();
        let edited = json.replacen("\"recall\":1.0", "\"recall\":0.5", 1);
        assert_ne!(edited, json);
        for (text, expected) in [
            (edited, "an edited or damaged result: it has digest"),
            (json.replacen("\"digest\":\"", "\"digest\":\"0", 1), "an edited or damaged result"),
            (json[..json.len() / 2].to_owned(), "cut off"),
            (json.replacen("\"seed\"", "\"sed\"", 1), "a damaged result: unknown field `sed`"),
            (json.replacen("benchmark result", "comparison part", 1), "no result of a benchmark"),
            (json.replacen("\"format_version\":1", "\"format_version\":2", 1), "of format version 2"),
            ("[]".to_owned(), "no result of a benchmark"),
            (String::new(), "cut off"),
        ] {
            let message = refused(&text);
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn a_result_of_another_version_track_or_summary_is_refused_whatever_its_digest() {
        type Edit<'a> = &'a dyn Fn(&mut BenchmarkResult);
        let result = greedy();
        let cases: [(Edit, &str); 7] = [
            (&|it| it.program.version = "1.2.4".to_owned(), "of dragnet 1.2.4; this is 1.2.3"),
            (&|it| it.track.name = "smok".to_owned(), "no such track; allowed are smoke, single"),
            (&|it| it.track.version = 2, "track smoke version 2"),
            (&|it| it.track.digest = "0".repeat(32), "with digest 00000000000000000000000000000000; this"),
            (&|it| it.policies[0].episodes[3].seed += 1, "its episodes are not those of track smoke"),
            (&|it| drop(it.policies[0].episodes.pop()), "its episodes are not those of track smoke"),
            (&|it| it.policies[0].summary[0].cells_to_full_recall.mean -= 1.0, "its summary is not that"),
        ];
        for (edit, expected) in cases {
            let message = refused(&result.clone().edited(edit).to_json().unwrap());
            assert!(message.contains(expected), "{message}");
        }
    }
}
