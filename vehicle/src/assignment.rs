//! Which bearing belongs to which track: the assignment of the least total angle.
//!
//! Kuhn (1955) and Munkres (1957), on the absolute wrapped angle between where a track should be seen and
//! where something was seen. To leave a track and a bearing without each other costs as much as a pair at the
//! gate. So of all assignments the one is chosen that has the least sum of angles with a gate's worth for
//! every pair that is not made; a good pair is never given up to make two bad ones.

use pathfinding::kuhn_munkres::kuhn_munkres_min;
use pathfinding::matrix::Matrix;

use crate::plane::wrapped_radians;

/// Angles are compared as integers, so that ties are ties on every machine.
const UNITS_PER_RADIAN: f64 = 1e9;

/// What belongs together; all numbers are places in the lists that were given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assignment {
    /// `(predicted, observed)`, by the first; each of either at most once.
    pub pairs: Vec<(usize, usize)>,
    /// Predicted bearings that nothing was seen at, in order.
    pub predicted_alone: Vec<usize>,
    /// Observed bearings that nothing predicts, in order.
    pub observed_alone: Vec<usize>,
}

/// Why nothing was assigned.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum AssignmentError {
    /// An angle is missing.
    #[error("{which} bearing {index} is {value}: not a number")]
    NotANumber {
        /// `predicted` or `observed`.
        which: &'static str,
        /// Its place in the list.
        index: usize,
        /// As given.
        value: f64,
    },
    /// A gate that lets nothing or all through.
    #[error("a gate of {0} radians: allowed is above 0, up to pi")]
    Gate(f64),
    /// Too much to assign in a frame's time.
    #[error("{predicted} tracks and {observed} bearings: at most {MAX_ASSIGNED} each can be assigned")]
    TooMany {
        /// Predicted bearings.
        predicted: usize,
        /// Observed bearings.
        observed: usize,
    },
}

/// So many predicted and so many observed bearings can be assigned: the time grows with the third power.
pub const MAX_ASSIGNED: usize = 512;

/// Assigns observed to predicted bearings, all in radians in one frame; pairs are at most `gate_radians`
/// apart.
///
/// # Errors
/// If an angle is no number, the gate is not above 0 and at most pi, or one list is longer than
/// [`MAX_ASSIGNED`].
pub fn assign(
    predicted_radians: &[f64],
    observed_radians: &[f64],
    gate_radians: f64,
) -> Result<Assignment, AssignmentError> {
    check(predicted_radians, observed_radians, gate_radians)?;
    // The method wants at least as many columns as rows.
    let is_turned = predicted_radians.len() > observed_radians.len();
    let (rows, columns) =
        if is_turned { (observed_radians, predicted_radians) } else { (predicted_radians, observed_radians) };
    let gate = units(gate_radians);
    let distance = |row: usize, column: usize| units(wrapped_radians(rows[row] - columns[column]).abs());
    let chosen = if rows.is_empty() {
        Vec::new()
    } else {
        let cost = |(row, column)| distance(row, column).min(gate + 1);
        kuhn_munkres_min(&Matrix::from_fn(rows.len(), columns.len(), cost)).1
    };
    let within = chosen.into_iter().enumerate().filter(|&(row, column)| distance(row, column) <= gate);
    let mut pairs: Vec<_> =
        within.map(|(row, column)| if is_turned { (column, row) } else { (row, column) }).collect();
    pairs.sort_unstable();
    let predicted_alone = alone(predicted_radians.len(), pairs.iter().map(|&(predicted, _)| predicted));
    let observed_alone = alone(observed_radians.len(), pairs.iter().map(|&(_, observed)| observed));
    Ok(Assignment { pairs, predicted_alone, observed_alone })
}

#[expect(clippy::cast_possible_truncation, reason = "at most pi * 10^9")]
fn units(radians: f64) -> i64 {
    (radians * UNITS_PER_RADIAN).round() as i64
}

fn alone(count: usize, assigned: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut is_alone = vec![true; count];
    assigned.for_each(|index| is_alone[index] = false);
    (0..count).filter(|&index| is_alone[index]).collect()
}

fn check(predicted: &[f64], observed: &[f64], gate: f64) -> Result<(), AssignmentError> {
    // Written so that NaN fails as well.
    if !(gate > 0.0 && gate <= std::f64::consts::PI) {
        return Err(AssignmentError::Gate(gate));
    }
    if predicted.len().max(observed.len()) > MAX_ASSIGNED {
        return Err(AssignmentError::TooMany { predicted: predicted.len(), observed: observed.len() });
    }
    for (which, bearings) in [("predicted", predicted), ("observed", observed)] {
        if let Some((index, &value)) = bearings.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(AssignmentError::NotANumber { which, index, value });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use dragnet_search::seed::{Purpose, stream};
    use rand::RngExt;

    use super::*;

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

    /// Least sum over all ways to assign, a pair that is not made at the cost of the gate.
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
    fn bad_input_says_where_it_stands() {
        let message = |predicted: &[f64], observed: &[f64], gate| {
            assign(predicted, observed, gate).unwrap_err().to_string()
        };
        assert_eq!(message(&[0.0], &[1.0, f64::NAN], 0.1), "observed bearing 1 is NaN: not a number");
        assert_eq!(message(&[f64::INFINITY], &[], 0.1), "predicted bearing 0 is inf: not a number");
        assert!(message(&[0.0], &[0.0], f64::NAN).contains("gate"));
        assert!(message(&[0.0], &[0.0], 0.0).contains("gate"));
        assert!(message(&[0.0], &vec![0.0; 10_000], 0.1).contains("10000 bearings"));
    }
}
