//! Differences between two policies on the same seeds.

use std::fmt;

use crate::comparison::{Estimate, Row, Trial};

/// A difference in area between `random` and the expert that is too small to be divided by.
const LEAST_GAP: f64 = 1e-6;

/// The share of the gap from which a clone is said to match its expert: the paper gives no number for it, and areas
/// alone hardly distinguish policies.
pub(super) const MATCHING_SHARE: f64 = 0.9;

/// Where the mean F1 of two policies differs most.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    /// By how much the first is above the second, percentage points.
    pub(super) points: Estimate,
    /// At this path length.
    cells: f64,
}

/// `-1.2 ± 0.8 at 45`
impl fmt::Display for Gap {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} at {:.0}", signed(self.points, 1), self.cells)
    }
}

/// Of the mean F1 of two policies over all path lengths; the first such length.
pub(super) fn largest_difference(policy: &Row, other: &Row) -> Gap {
    let difference = |place: usize| policy.curve.mean[place] - other.curve.mean[place];
    let mut farthest = 0;
    for place in 0..policy.curve.mean.len() {
        if difference(place).abs() > difference(farthest).abs() {
            farthest = place;
        }
    }
    let points = paired(policy, other, |trial| 100.0 * trial.curve[farthest]);
    Gap { points, cells: policy.curve.cells[farthest] }
}

/// The mean difference of a measure between two policies, seed by seed.
pub(super) fn paired(policy: &Row, other: &Row, of: impl Fn(&Trial) -> f64) -> Estimate {
    let pairs = policy.trials.iter().zip(&other.trials);
    Estimate::of(pairs.map(|(trial, other)| of(trial) - of(other)))
}

/// The difference of the area under F1 between two policies, percentage points.
pub(super) fn area_points(policy: &Row, other: &Row) -> Estimate {
    paired(policy, other, |trial| 100.0 * trial.auc_f1)
}

/// The share of the gap in area under F1 between `random` and the expert that a policy closes; `None` if there is no
/// gap. Its standard error is by the jackknife: from leaving out each seed in turn (Tukey 1958).
pub(super) fn share_closed(policy: &Row, random: &Row, expert: &Row) -> Option<Estimate> {
    let areas = |row: &Row| row.trials.iter().map(|trial| trial.auc_f1).collect::<Vec<f64>>();
    let (policy, random, expert) = (areas(policy), areas(random), areas(expert));
    let over_random = |areas: &[f64]| areas.iter().zip(&random).map(|(area, random)| area - random).collect();
    let (parts, wholes): (Vec<f64>, Vec<f64>) = (over_random(&policy), over_random(&expert));
    let (part, whole): (f64, f64) = (parts.iter().sum(), wholes.iter().sum());
    let count = parts.len() as f64;
    if whole / count < LEAST_GAP {
        return None;
    }
    let without = parts.iter().zip(&wholes).map(|(out, of)| (part - out) / (whole - of));
    // The standard error of a mean, times (n - 1): leaving one value out changes a mean by so much less than the value
    // differs from it.
    let sem = Estimate::of(without).sem.map(|sem| sem * (count - 1.0));
    Some(Estimate { mean: part / whole, sem: sem.filter(|sem| sem.is_finite()) })
}

/// By how much the share of the gap that a policy closes exceeds [`MATCHING_SHARE`].
pub(super) fn matching(policy: &Row, random: &Row, expert: &Row) -> Option<Estimate> {
    let share = share_closed(policy, random, expert)?;
    Some(Estimate { mean: share.mean - MATCHING_SHARE, ..share })
}

/// The path length at which the mean F1 of a policy first reaches a value.
pub(super) fn length_to(row: &Row, f1: f64) -> Option<f64> {
    let reached = row.curve.mean.iter().position(|&mean| mean >= f1)?;
    Some(row.curve.cells[reached])
}

/// The mean of the areas of one policy on all maps; its standard error is that of the seeds' means.
pub(super) fn mean_area(rows: &[&Row]) -> Estimate {
    let seeds = rows.iter().map(|row| row.trials.len()).min().unwrap_or(0);
    let mean =
        |place: usize| rows.iter().map(|row| row.trials[place].auc_f1).sum::<f64>() / rows.len() as f64;
    Estimate::of((0..seeds).map(mean))
}

/// `+0.9`
pub(super) fn with_sign(number: f64, decimals: usize) -> String {
    signed(Estimate { mean: number, sem: None }, decimals)
}

/// `+0.9 ± 0.4`
pub(super) fn signed(estimate: Estimate, decimals: usize) -> String {
    let Estimate { mean, sem } = estimate;
    let error = sem.map_or_else(String::new, |sem| format!(" ± {sem:.decimals$}"));
    format!("{mean:+.decimals$}{error}").replace('-', "\u{2212}")
}

/// `97.3 ± 1.2 %`
pub(super) fn percent(share: Option<Estimate>) -> String {
    let Some(Estimate { mean, sem }) = share else { return "-".to_owned() };
    let error = sem.map_or_else(String::new, |sem| format!(" ± {:.1}", 100.0 * sem));
    format!("{:.1}{error} %", 100.0 * mean).replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::super::map::{Map, Size};
    use super::*;
    use crate::comparison::{Case, Experiment};

    /// A row of trials with these areas and curves over 0, 1 and 2 cells.
    fn row(areas: &[f64], curves: &[[f64; 3]]) -> Row {
        let trials = areas.iter().zip(curves).map(|(&auc_f1, curve)| Trial {
            seed: 0,
            auc_f1,
            average_recall: 0.0,
            cells_to_full_recall: None,
            cells_to_recall: [None; 3],
            f1: 0.0,
            recall: 0.0,
            objects_in_reach: 1,
            farthest_cells: 2.0,
            remaining: 0,
            expected_remaining: 0.0,
            tail_seconds: 0.0,
            curve: curve.to_vec(),
            decisions: Vec::new(),
        });
        let scenario = Map::IceCreamCone.scenario(Size::Thirty).unwrap().with_budget_cells(2).unwrap();
        let seeds = areas.len().to_string().parse().unwrap();
        let experiment = Experiment { cases: vec![Case::new(scenario, "path")], seeds };
        experiment.design().rows(trials.collect()).remove(0)
    }

    fn areas(areas: &[f64]) -> Row {
        row(areas, &vec![[0.0; 3]; areas.len()])
    }

    fn is_about(value: f64, expected: f64) -> bool {
        (value - expected).abs() < 1e-9
    }

    #[test]
    fn curves_differ_most_where_their_means_do() {
        let policy = row(&[0.0; 2], &[[0.0, 0.2, 0.8], [0.0, 0.4, 1.0]]);
        let other = row(&[0.0; 2], &[[0.0, 0.6, 0.7], [0.0, 0.5, 1.0]]);
        let gap = largest_difference(&policy, &other);
        assert!(is_about(gap.points.mean, -25.0) && is_about(gap.cells, 1.0), "{gap}");
        // Of -40 and -10.
        assert!(is_about(gap.points.sem.unwrap(), 15.0), "{gap}");
        assert_eq!(gap.to_string(), "\u{2212}25.0 ± 15.0 at 1");
        assert!(is_about(largest_difference(&policy, &policy).points.mean, 0.0));
        assert_eq!((length_to(&policy, 0.3), length_to(&policy, 0.95)), (Some(1.0), None));
    }

    #[test]
    fn the_gap_closed_is_that_of_the_means() {
        let (random, expert) = (areas(&[0.5, 0.6, 0.7]), areas(&[0.9, 0.9, 0.9]));
        let closed = |policy: &Row| share_closed(policy, &random, &expert).unwrap();
        assert!(is_about(closed(&expert).mean, 1.0) && is_about(closed(&expert).sem.unwrap(), 0.0));
        assert!(is_about(closed(&random).mean, 0.0));
        let half = closed(&areas(&[0.7, 0.75, 0.8]));
        assert!(is_about(half.mean, 0.5) && is_about(half.sem.unwrap(), 0.0));
        assert!(share_closed(&expert, &expert, &expert).is_none());
    }

    #[test]
    fn with_a_constant_gap_the_jackknife_is_the_usual_standard_error() {
        let (random, expert) = (areas(&[0.5; 4]), areas(&[0.9; 4]));
        let policy = areas(&[0.6, 0.7, 0.85, 0.9]);
        let shares = Estimate::of(policy.trials.iter().map(|trial| (trial.auc_f1 - 0.5) / 0.4));
        let closed = share_closed(&policy, &random, &expert).unwrap();
        assert!(is_about(closed.mean, shares.mean));
        assert!(is_about(closed.sem.unwrap(), shares.sem.unwrap()));
    }

    #[test]
    fn a_mean_over_maps_is_that_of_each_seed() {
        let (one, other) = (areas(&[0.2, 0.4]), areas(&[0.6, 0.4]));
        let mean = mean_area(&[&one, &other]);
        assert!(is_about(mean.mean, 0.4) && is_about(mean.sem.unwrap(), 0.0));
        assert!(is_about(area_points(&other, &one).mean, 20.0));
    }

    #[test]
    fn numbers_have_a_sign_and_an_error_where_they_are_known() {
        assert_eq!(signed(Estimate { mean: -0.25, sem: Some(0.5) }, 1), "\u{2212}0.2 ± 0.5");
        assert_eq!(signed(Estimate { mean: 1.0, sem: None }, 2), "+1.00");
        assert_eq!(percent(Some(Estimate { mean: 0.973, sem: Some(0.0124) })), "97.3 ± 1.2 %");
        assert_eq!(percent(None), "-");
    }
}
