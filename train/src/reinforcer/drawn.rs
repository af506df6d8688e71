//! Which decisions of a round are learned from.

use dragnet_search::seed::Stream;
use rand::RngExt;

use super::Choice;

/// The least share of doubt that a choice counts with.
const LEAST_DOUBT: f64 = 0.02;

/// A decision that is learned from.
#[derive(Clone, Debug)]
pub(super) struct Drawn<'a> {
    pub(super) choice: &'a Choice,
    /// What it saved beyond the mean of its round, over the standard deviation, and over the share of the draws that it
    /// was due.
    pub(super) advantage: f64,
}

/// Draws `count` of the choices in proportion to how much they would change: what they saved beyond the mean, times how
/// doubtful they were, as the gradient of `ln pi` is small where `pi` is near 1. What is drawn counts the less, so that
/// the sum is in expectation that over all.
pub(super) fn draw<'a>(
    choices: &[(&'a Choice, f64)],
    (mean, deviation): (f64, f64),
    count: usize,
    random: &mut Stream,
) -> Vec<Drawn<'a>> {
    let advantage = |saved: f64| (saved - mean) / deviation.max(1e-9);
    let due = |&(choice, saved): &(&Choice, f64)| {
        advantage(saved).abs() * (-choice.log_probability.exp_m1()).max(LEAST_DOUBT)
    };
    let total: f64 = choices.iter().map(due).sum();
    // At even distances from a random place on, so that each is drawn as often as it is due, give or take one.
    let distance = total / count as f64;
    let mut next = distance * random.random::<f64>();
    let mut passed = 0.0;
    let mut drawn = Vec::with_capacity(count);
    for choice in choices {
        let due = due(choice);
        passed += due;
        while next < passed && drawn.len() < count {
            let advantage = advantage(choice.1) * total / (due * choices.len() as f64);
            drawn.push(Drawn { choice: choice.0, advantage });
            next += distance;
        }
    }
    drawn
}
