//! Summaries of a policy's episodes, one for each group of searches and one for all.

use dragnet_sim::comparison::{Estimate, Latencies, Trial, restricted};
use serde::{Deserialize, Serialize};

use super::result::EpisodeResult;
use super::track::Track;

/// The group of the whole track.
pub const ALL_GROUPS: &str = "all";

/// A policy's episodes in a group of searches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// The group, such as `caves, 1 %`, or [`ALL_GROUPS`].
    pub group: String,
    /// Number of its episodes.
    pub episodes: usize,
    /// Episodes that found every object within the budget.
    pub reached: usize,
    /// Path length of the farthest robot until every object was found, cells: a restricted mean, in which an episode that
    /// does not find all counts as its budget. Of the whole track: the mean of the groups' means.
    pub cells_to_full_recall: Estimate,
    /// Mean of recall over path lengths from 0 to the budget, `0..=1`.
    pub average_recall: Estimate,
    /// Half of all decisions took no longer, milliseconds; for information, since it depends on the computer.
    pub decision_ms_p50: Option<f64>,
}

/// The summaries of episodes in the order of the track: its groups in the order of their first searches, then all.
pub(super) fn summaries(track: &Track, episodes: &[EpisodeResult], trials: Option<&[Trial]>) -> Vec<Summary> {
    let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
    for (place, (search, _)) in track.episodes().enumerate() {
        let name = track.searches()[search].group.as_str();
        match groups.iter_mut().find(|(group, _)| *group == name) {
            Some((_, places)) => places.push(place),
            None => groups.push((name, vec![place])),
        }
    }
    let budgets: Vec<f64> =
        track.episodes().map(|(search, _)| track.searches()[search].scenario.budget_cells()).collect();
    let of_group = |(name, places): &(&str, Vec<usize>)| {
        let cells = |place: &usize| restricted(episodes[*place].cells_to_full_recall, budgets[*place]);
        Summary {
            group: (*name).to_owned(),
            episodes: places.len(),
            reached: places.iter().filter(|place| episodes[**place].cells_to_full_recall.is_some()).count(),
            cells_to_full_recall: Estimate::of(places.iter().map(cells)),
            average_recall: Estimate::of(places.iter().map(|place| episodes[*place].average_recall)),
            decision_ms_p50: trials.and_then(|trials| median(places.iter().map(|place| &trials[*place]))),
        }
    };
    let mut summaries: Vec<Summary> = groups.iter().map(of_group).collect();
    let median = trials.and_then(|trials| median(trials.iter()));
    summaries.push(all(&summaries, median));
    summaries
}

/// The whole track: groups count alike, and their errors are independent.
fn all(groups: &[Summary], decision_ms_p50: Option<f64>) -> Summary {
    let mean_of = |estimate: &dyn Fn(&Summary) -> Estimate| {
        let count = groups.len() as f64;
        let mean = groups.iter().map(|group| estimate(group).mean).sum::<f64>() / count;
        let variance: Option<f64> = groups.iter().map(|group| Some(estimate(group).sem?.powi(2))).sum();
        Estimate { mean, sem: variance.map(|variance| variance.sqrt() / count) }
    };
    Summary {
        group: ALL_GROUPS.to_owned(),
        episodes: groups.iter().map(|group| group.episodes).sum(),
        reached: groups.iter().map(|group| group.reached).sum(),
        cells_to_full_recall: mean_of(&|group| group.cells_to_full_recall),
        average_recall: mean_of(&|group| group.average_recall),
        decision_ms_p50,
    }
}

fn median<'a>(trials: impl Iterator<Item = &'a Trial>) -> Option<f64> {
    Latencies::new(trials.flat_map(|trial| trial.decisions.iter().copied()).collect()).percentile_ms(50)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every episode of `smoke` on the cone finds all after 10, 20 and 60 cells; none does on the asterisk.
    fn episodes(track: &Track) -> Vec<EpisodeResult> {
        let of = |(place, (search, seed)): (usize, (usize, u64))| {
            let search = track.searches()[search].scenario.name().to_owned();
            let is_found = search.starts_with("ice");
            let cells = is_found.then(|| [10.0, 20.0, 60.0][place % 3]);
            EpisodeResult { search, seed, cells_to_full_recall: cells, average_recall: 0.5, recall: 0.9 }
        };
        track.episodes().enumerate().map(of).collect()
    }

    #[test]
    fn a_miss_counts_as_the_budget_and_groups_count_alike() {
        let track = Track::named("smoke").unwrap();
        let summaries = summaries(&track, &episodes(&track), None);
        let rows: Vec<_> = summaries
            .iter()
            .map(|it| (it.group.as_str(), it.episodes, it.reached, it.cells_to_full_recall.mean))
            .collect();
        let expected = [
            ("ice cream cone, 1 %", 3, 3, 30.0),
            ("ice cream cone, 20 %", 3, 3, 30.0),
            ("open asterisk, 1 %", 3, 0, 300.0),
            ("open asterisk, 20 %", 3, 0, 300.0),
            ("all", 12, 6, 165.0),
        ];
        assert_eq!(rows, expected);
        // Sample variance 700 of 10, 20 and 60 in two of four groups: the spread between the groups is no error.
        let sem = summaries[4].cells_to_full_recall.sem.unwrap();
        assert!((sem - (2.0_f64 * 700.0 / 3.0).sqrt() / 4.0).abs() < 1e-12, "{sem}");
    }
}
