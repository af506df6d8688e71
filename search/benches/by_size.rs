//! One decision of every policy by size of map. Every policy is built anew, as in the bench `policies`.

use std::time::Duration;

use dragnet_search::policy::{Parameters, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::shape::Shape;

use crate::field::Field;
use crate::times::{Times, milliseconds, time};

const SIDES: [u32; 5] = [30, 60, 100, 300, 1000];
const DENSITY: f64 = 0.01;
const SEED: u64 = 1;

/// Prints the medians.
pub(crate) fn print() {
    println!("\nall_traversable, density {DENSITY}; medians in ms\n");
    println!("| side | state | {} |", PolicyName::ALL.map(PolicyName::as_str).join(" | "));
    println!("|---|---|{}", "---|".repeat(PolicyName::ALL.len()));
    for side in SIDES {
        let fresh = Field::fresh(Shape::AllTraversable, side, DENSITY, SEED);
        for (state, field) in [("fresh", fresh), ("midway", Field::midway(side, DENSITY, SEED))] {
            let medians = PolicyName::ALL.map(|name| milliseconds(median(&field, name)));
            println!("| {side} | {state} | {} |", medians.join(" | "));
        }
    }
}

/// Of 5 decisions at least and 101 at most, within a quarter of a second.
fn median(field: &Field, name: PolicyName) -> Duration {
    let mut random = stream(SEED, Purpose::Decision, 1);
    let mut times = Vec::new();
    while times.len() < 5
        || (times.len() < 101 && times.iter().sum::<Duration>() < Duration::from_millis(250))
    {
        let decide = || build(name, Parameters::default()).decide(&field.situation(), &mut random);
        times.push(time(decide).0);
    }
    Times::of(times).quantile(0.5)
}
