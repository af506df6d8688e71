//! Assigns bearings to tracks with the least total cost.
//!
//! Kuhn (1955) and Munkres (1957). The caller gives the cost of each pair; an unassigned track and an unassigned
//! bearing together cost as much as a pair at the limit. So the chosen assignment has the least sum of costs with the
//! limit for every pair that is not made; a good pair is never given up for two bad ones.

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

/// Costs are compared as integers, so that ties are ties on every machine.
const UNITS: f64 = 1e9;
/// The greatest limit.
const MAX_LIMIT: f64 = 1e6;

/// An assignment; all numbers are indices into the given lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assignment {
    /// `(predicted, observed)`, by the first; each of either at most once.
    pub pairs: Vec<(usize, usize)>,
    /// Predicted bearings without an observed one, in order.
    pub predicted_alone: Vec<usize>,
    /// Observed bearings without a predicted one, in order.
    pub observed_alone: Vec<usize>,
}

/// Why bearings could not be assigned.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AssignmentError {
    /// An invalid cost.
    #[error(
        "the cost of track {predicted} and bearing {observed} is {value}: needed is a number of at least 0"
    )]
    Cost {
        /// Index of the track.
        predicted: usize,
        /// Index of the bearing.
        observed: usize,
        /// The given value.
        value: f64,
    },
    /// An invalid limit.
    #[error("a limit of {0}: allowed is above 0, up to {MAX_LIMIT}")]
    Limit(f64),
    /// Too many bearings for a frame's time.
    #[error("{predicted} tracks and {observed} bearings: at most {MAX_ASSIGNED} each can be assigned")]
    TooMany {
        /// Predicted bearings.
        predicted: usize,
        /// Observed bearings.
        observed: usize,
    },
}

/// The maximum number of predicted and of observed bearings: time grows with the third power.
pub const MAX_ASSIGNED: usize = 512;

/// Assigns observed to predicted bearings by the cost of each pair, at least 0; an infinite cost excludes a pair. Pairs
/// cost at most the limit.
///
/// # Errors
/// If a cost is NaN or below 0, the limit is not above 0 and at most 10^6, or there are more than [`MAX_ASSIGNED`] of
/// either.
pub fn assign(
    predicted: usize,
    observed: usize,
    limit: f64,
    cost: impl Fn(usize, usize) -> f64,
) -> Result<Assignment, AssignmentError> {
    let costs = costs(predicted, observed, limit, cost)?;
    let units_at = |predicted: usize, column: usize| costs[predicted * observed + column];
    // The method needs at least as many columns as rows.
    let is_turned = predicted > observed;
    let (rows, columns) = if is_turned { (observed, predicted) } else { (predicted, observed) };
    let distance =
        |row: usize, column: usize| if is_turned { units_at(column, row) } else { units_at(row, column) };
    let chosen = if rows == 0 {
        Vec::new()
    } else {
        kuhn_munkres_min(&Matrix::from_fn(rows, columns, |(row, column)| distance(row, column))).1
    };
    let beyond = units(limit) + 1;
    let within = chosen.into_iter().enumerate().filter(|&(row, column)| distance(row, column) < beyond);
    let mut pairs: Vec<_> =
        within.map(|(row, column)| if is_turned { (column, row) } else { (row, column) }).collect();
    pairs.sort_unstable();
    let predicted_alone = alone(predicted, pairs.iter().map(|&(predicted, _)| predicted));
    let observed_alone = alone(observed, pairs.iter().map(|&(_, observed)| observed));
    Ok(Assignment { pairs, predicted_alone, observed_alone })
}

/// In units, by predicted and then observed; costs beyond the limit are one more than it.
fn costs(
    predicted: usize,
    observed: usize,
    limit: f64,
    cost: impl Fn(usize, usize) -> f64,
) -> Result<Vec<i64>, AssignmentError> {
    // Written so that NaN fails as well.
    if !(limit > 0.0 && limit <= MAX_LIMIT) {
        return Err(AssignmentError::Limit(limit));
    }
    if predicted.max(observed) > MAX_ASSIGNED {
        return Err(AssignmentError::TooMany { predicted, observed });
    }
    let mut costs = Vec::with_capacity(predicted * observed);
    for (predicted, observed) in (0..predicted).flat_map(|row| (0..observed).map(move |column| (row, column)))
    {
        let value = cost(predicted, observed);
        if value.is_nan() || value < 0.0 {
            return Err(AssignmentError::Cost { predicted, observed, value });
        }
        costs.push(if value > limit { units(limit) + 1 } else { units(value) });
    }
    Ok(costs)
}

#[expect(clippy::cast_possible_truncation, reason = "at most 10^6 * 10^9")]
fn units(cost: f64) -> i64 {
    (cost * UNITS).round() as i64
}

fn alone(count: usize, assigned: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut is_alone = vec![true; count];
    assigned.for_each(|index| is_alone[index] = false);
    (0..count).filter(|&index| is_alone[index]).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use dragnet_search::seed::{Purpose, stream};
    use rand::RngExt;

    use super::*;
    use crate::mentions::assert_mentions;
    use dragnet_lattice::plane::wrapped_radians;

    /// By angles alone.
    fn assign(predicted: &[f64], observed: &[f64], gate: f64) -> Result<Assignment, AssignmentError> {
        let angle = |row: usize, column: usize| wrapped_radians(predicted[row] - observed[column]).abs();
        super::assign(predicted.len(), observed.len(), gate, angle)
    }

    fn check(predicted: &[f64], observed: &[f64], gate: f64, pairs: &[(usize, usize)]) {
        let assignment = assign(predicted, observed, gate).unwrap();
        assert_eq!(assignment.pairs, pairs);
        assert_eq!(assignment.predicted_alone.len() + pairs.len(), predicted.len());
        assert_eq!(assignment.observed_alone.len() + pairs.len(), observed.len());
    }

    #[test]
    fn the_nearest_pair_is_not_always_in_the_best_assignment() {
        // Track 0 is nearest to bearing 0, but then track 1 has none within the gate.
        check(&[0.0, 0.05], &[0.03, -0.04], 0.07, &[(0, 1), (1, 0)]);
    }

    #[test]
    fn a_good_pair_is_not_given_up_for_two_bad_ones() {
        check(&[0.0, 0.05], &[0.0, -0.05], 0.06, &[(0, 0)]);
    }

    #[test]
    fn angles_are_wrapped() {
        check(&[PI - 0.01, 0.0], &[0.02, 0.01 - PI], 0.05, &[(0, 1), (1, 0)]);
        check(&[7.0 * PI], &[PI], 0.05, &[(0, 0)]);
    }

    #[test]
    fn beyond_the_gate_is_alone() {
        let assignment = assign(&[0.0, 1.0, 2.0], &[1.01, 3.0], 0.1).unwrap();
        assert_eq!(assignment.pairs, [(1, 0)]);
        assert_eq!((assignment.predicted_alone, assignment.observed_alone), (vec![0, 2], vec![1]));
    }

    #[test]
    fn empty_lists_leave_the_others_alone() {
        check(&[], &[], 0.1, &[]);
        check(&[1.0], &[], 0.1, &[]);
        check(&[], &[1.0, 2.0], 0.1, &[]);
    }

    /// The least sum over all assignments; a pair that is not made costs as much as the gate.
    fn best(predicted: &[f64], observed: &mut Vec<f64>, gate: f64) -> f64 {
        let Some((first, rest)) = predicted.split_first() else { return 0.0 };
        let mut least = gate + best(rest, observed, gate);
        for index in 0..observed.len() {
            let angle = wrapped_radians(first - observed[index]).abs();
            if angle <= gate {
                let taken = observed.remove(index);
                least = least.min(angle + best(rest, observed, gate));
                observed.insert(index, taken);
            }
        }
        least
    }

    #[test]
    fn no_other_assignment_is_better() {
        let mut random = stream(4, Purpose::Truth, 0);
        let mut differed_from_nearest = 0;
        for _ in 0..300 {
            let mut draw = || (0..random.random_range(0..6)).map(|_| random.random_range(2.0..5.0)).collect();
            let (predicted, observed): (Vec<f64>, Vec<f64>) = (draw(), draw());
            let gate = 0.8;
            let assignment = assign(&predicted, &observed, gate).unwrap();
            let angle =
                |&(track, seen): &(usize, usize)| wrapped_radians(predicted[track] - observed[seen]).abs();
            assert!(assignment.pairs.iter().all(|pair| angle(pair) <= gate + 1e-9));
            let sum: f64 = assignment.pairs.iter().map(angle).sum();
            let given = sum + gate * assignment.predicted_alone.len() as f64;
            assert!((given - best(&predicted, &mut observed.clone(), gate)).abs() < 1e-7);
            let nearer = |&(track, seen): &(usize, usize)| {
                (0..observed.len()).any(|other| angle(&(track, other)) < angle(&(track, seen)))
            };
            differed_from_nearest += usize::from(assignment.pairs.iter().any(nearer));
        }
        assert!(differed_from_nearest > 30, "{differed_from_nearest}");
    }

    #[test]
    fn bad_input_is_reported_with_its_place() {
        let message = |predicted: &[f64], observed: &[f64], gate| {
            assign(predicted, observed, gate).unwrap_err().to_string()
        };
        assert_mentions(&message(&[0.0], &[1.0, f64::NAN], 0.1), "track 0 .. bearing 1 .. NaN .. at least 0");
        let negative = super::assign(1, 1, 1.0, |_, _| -0.5).unwrap_err().to_string();
        assert_mentions(&negative, "-0.5 .. at least 0");
        assert!(message(&[0.0], &[0.0], f64::NAN).contains("limit"));
        assert!(message(&[0.0], &[0.0], 0.0).contains("limit"));
        assert!(message(&[0.0], &vec![0.0; 10_000], 0.1).contains("10000 bearings"));
    }

    #[test]
    fn a_pair_that_cannot_be_is_not_made() {
        let cost = |row: usize, column: usize| if row == column { f64::INFINITY } else { 1.0 };
        assert_eq!(super::assign(2, 2, 5.0, cost).unwrap().pairs, [(0, 1), (1, 0)]);
        assert_eq!(super::assign(1, 1, 5.0, cost).unwrap().pairs, []);
    }
}
