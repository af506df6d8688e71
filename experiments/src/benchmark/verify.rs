//! Verification: which episodes of a result another run gives differently.

use std::fmt;
use std::path::Path;

use xxhash_rust::xxh3::xxh3_64_with_seed;

use super::entry::Decider;
use super::result::{BenchmarkResult, EpisodeResult};
use super::track::Track;
use crate::ExperimentError;
use crate::comparison::{Case, run_episodes};
use crate::jobs::Done;
use crate::progress::Progress;

/// An episode of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Index of the policy.
    pub policy: usize,
    /// Index of the episode, in the order of the track.
    pub episode: usize,
}

/// Some of a result's episodes.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Number of episodes.
    pub count: u64,
    /// The seed that they are drawn with.
    pub seed: u64,
}

/// An episode that another run gave differently.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferentEpisode {
    /// Name of the policy.
    pub policy: String,
    /// As the result says.
    pub claimed: EpisodeResult,
    /// As the other run gave it.
    pub found: EpisodeResult,
}

/// The episodes to run again: all, or a sample without repetition; in their order.
///
/// # Errors
/// If the sample is empty or larger than the result.
pub fn places(result: &BenchmarkResult, sample: Option<Sample>) -> Result<Vec<Place>, ExperimentError> {
    let of_policy =
        |(policy, count): (usize, usize)| (0..count).map(move |episode| Place { policy, episode });
    let counts = result.policies.iter().map(|policy| policy.episodes.len());
    let mut places: Vec<Place> = counts.enumerate().flat_map(of_policy).collect();
    let Some(Sample { count, seed }) = sample else { return Ok(places) };
    let all = places.len();
    let count = usize::try_from(count).ok().filter(|count| (1..=all).contains(count)).ok_or_else(|| {
        ExperimentError::Input(format!(
            "a sample of {count}; allowed is 1 to {all}, the episodes of the result"
        ))
    })?;
    // A shuffle by numbers that are as good as random, and the same everywhere.
    let key = |place: &Place| {
        let number = [place.policy as u64, place.episode as u64].map(u64::to_le_bytes).concat();
        (xxh3_64_with_seed(&number, seed), *place)
    };
    places.sort_unstable_by_key(key);
    places.truncate(count);
    places.sort_unstable();
    Ok(places)
}

/// Runs a result's episodes again, all of them of policies of this program, on this many threads, by default one for each
/// core; returns those that differ.
///
/// # Errors
/// If a callable decided one, a policy or its weights cannot be had, or an episode fails.
pub fn run(
    result: &BenchmarkResult,
    track: &Track,
    places: &[Place],
    weights: Option<&Path>,
    threads: Option<u16>,
    progress: &dyn Progress,
) -> Result<Done<DifferentEpisode>, ExperimentError> {
    let mut cases: Vec<Vec<Case>> = Vec::new();
    for policy in &result.policies {
        if let Decider::Callable(_) = policy.decider {
            return Err(ExperimentError::Input(format!(
                "policy {} is a callable in Python: verify the result there, with dragnet.benchmark.verify",
                policy.name
            )));
        }
        cases.push(policy.entry().cases(track, weights)?);
    }
    let episodes: Vec<(usize, u64)> = track.episodes().collect();
    let again = |place: &Place| {
        let (search, seed) = episodes[place.episode];
        (&cases[place.policy][search], seed)
    };
    let again: Vec<(&Case, u64)> = places.iter().map(again).collect();
    let done = run_episodes(&again, threads, progress)?;
    let differing = places.iter().zip(&done.results).filter_map(|(place, trial)| {
        let search = track.searches()[episodes[place.episode].0].scenario.name();
        difference(result, *place, EpisodeResult::new(search, trial))
    });
    Ok(Done { results: differing.collect(), effort: done.effort })
}

/// The difference of another run's episode to the result's, if there is one.
#[must_use]
pub fn difference(result: &BenchmarkResult, place: Place, found: EpisodeResult) -> Option<DifferentEpisode> {
    let policy = &result.policies[place.policy];
    let claimed = policy.episodes[place.episode].clone();
    (claimed != found).then(|| DifferentEpisode { policy: policy.name.clone(), claimed, found })
}

/// `path on figure_four_1, seed 30007: all found after 45 cells, average recall 0.91, recall 1; and not ..`
impl fmt::Display for DifferentEpisode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { policy, claimed, found } = self;
        let (claims, finds) = (claimed.measures(), found.measures());
        write!(formatter, "{policy} on {}, seed {}: {finds}; and not {claims}", found.search, found.seed)
    }
}

impl EpisodeResult {
    fn measures(&self) -> String {
        let found = match self.cells_to_full_recall {
            Some(cells) => format!("all found after {cells} cells"),
            None => "not all found".to_owned(),
        };
        format!("{found}, average recall {}, recall {}", self.average_recall, self.recall)
    }
}

#[cfg(test)]
mod tests {
    use super::super::entry::Interface;
    use super::super::result::tests::{Unseen, greedy};
    use super::*;

    fn verified(result: &BenchmarkResult, sample: Option<Sample>) -> Vec<DifferentEpisode> {
        let track = Track::named("smoke").unwrap();
        let places = places(result, sample).unwrap();
        run(result, &track, &places, None, None, &Unseen).unwrap().results
    }

    #[test]
    fn an_honest_result_is_confirmed_and_an_edited_episode_is_found() {
        let result = greedy();
        assert_eq!(verified(&result, None), []);
        let edited = result.clone().edited(|it| it.policies[0].episodes[7].average_recall += 0.01);
        let differing = verified(&edited, None);
        assert_eq!(differing.len(), 1);
        assert_eq!(differing[0].claimed, edited.policies[0].episodes[7]);
        assert_eq!(differing[0].found, result.policies[0].episodes[7]);
        let text = differing[0].to_string();
        assert!(
            text.starts_with("mine on open_asterisk_1, seed 30001: ") && text.contains("; and not "),
            "{text}"
        );
    }

    #[test]
    fn a_sample_has_its_size_no_repetition_and_depends_on_its_seed() {
        let result = greedy();
        let drawn = |count, seed| places(&result, Some(Sample { count, seed }));
        let samples: Vec<Vec<Place>> = (0..20).map(|seed| drawn(4, seed).unwrap()).collect();
        for sample in &samples {
            assert!(sample.len() == 4 && sample.is_sorted_by(|a, b| a < b), "{sample:?}");
        }
        let mut seen = samples.concat();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 12, "in 20 samples of a third each episode occurs");
        assert_eq!(drawn(4, 3).unwrap(), samples[3]);
        assert_eq!(drawn(12, 5).unwrap(), places(&result, None).unwrap());
        for count in [0, 13] {
            let refused = drawn(count, 0).unwrap_err().to_string();
            assert_eq!(
                refused,
                format!("a sample of {count}; allowed is 1 to 12, the episodes of the result")
            );
        }
    }

    #[test]
    fn a_callable_is_not_verified_here() {
        let (observation, frame, control) = ("dict".to_owned(), "map".to_owned(), "step".to_owned());
        let interface = Interface { observation, frame, control };
        let result = greedy().edited(|it| it.policies[0].decider = Decider::Callable(interface));
        let track = Track::named("smoke").unwrap();
        let all = places(&result, None).unwrap();
        let refused = run(&result, &track, &all, None, None, &Unseen).err().unwrap().to_string();
        assert!(
            refused.contains("policy mine is a callable") && refused.contains("benchmark.verify"),
            "{refused}"
        );
    }
}
