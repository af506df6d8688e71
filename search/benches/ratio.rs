//! `path` against its definition, measured by turns in one run.

use std::time::Duration;

use dragnet_search::policy::{Parameters, PathIntegralReference, Policy, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::shape::Shape;

use crate::field::Field;
use crate::times::{Times, milliseconds, time};

const DENSITIES: [f64; 2] = [0.2, 0.01];

/// Prints the times of both, after their scores are the same.
pub(crate) fn print() {
    println!("\npath against its definition, every candidate's path walked and summed anew; medians in ms\n");
    println!("| side | state | density | path | definition | ratio |");
    println!("|---|---|---|---|---|---|");
    for side in [30, 60] {
        for density in DENSITIES {
            let fresh = Field::fresh(Shape::AllTraversable, side, density, 1);
            for (state, field) in [("fresh", fresh), ("midway", Field::midway(side, density, 1))] {
                assert_same_scores(&field);
                let (path, definition) = time_both(&field);
                let ratio = definition.as_secs_f64() / path.as_secs_f64();
                let (path, definition) = (milliseconds(path), milliseconds(definition));
                println!("| {side} | {state} | {density} | {path} | {definition} | {ratio:.0} |");
            }
        }
    }
}

fn assert_same_scores(field: &Field) {
    let mut random = stream(1, Purpose::Decision, 1);
    let decision = build(PolicyName::Path, Parameters::default()).decide(&field.situation(), &mut random);
    let defined = definition().decide(&field.situation(), &mut random);
    for (index, (score, expected)) in decision.scores.iter().zip(defined.scores).enumerate() {
        // Cells that are not candidates score -inf.
        let is_same = if expected.is_finite() {
            (score - expected).abs() <= 1e-4 * expected.abs()
        } else {
            score.is_infinite()
        };
        assert!(is_same, "cell {index}: {score}, by definition {expected}");
    }
}

/// Medians of `path` and of its definition in one situation, measured by turns.
fn time_both(field: &Field) -> (Duration, Duration) {
    let mut random = stream(1, Purpose::Decision, 1);
    let (mut path, mut definition) = (Vec::new(), Vec::new());
    for _ in 0..31 {
        let decide =
            || build(PolicyName::Path, Parameters::default()).decide(&field.situation(), &mut random);
        path.push(time(decide).0);
        definition.push(time(|| self::definition().decide(&field.situation(), &mut random)).0);
    }
    (Times::of(path).quantile(0.5), Times::of(definition).quantile(0.5))
}

fn definition() -> PathIntegralReference {
    PathIntegralReference::new(Parameters::default().path_length_weight)
}
