//! The median time of a decision: over whole episodes against its targets, of `path` against its definition, and of
//! every policy by size of map.
//!
//! Prints tables. Episodes are of one robot, a sensor of radius 5, and end when every object is found or
//! [`MOST_CELLS`] are entered. A policy is kept over its episode, as a robot keeps it.

#![expect(clippy::unwrap_used, reason = "a benchmark fails by panicking")]

mod by_size;
mod field;
mod line_of_sight;
mod ratio;
mod times;

use std::hint::black_box;
use std::time::Duration;

use dragnet_search::policy::{Parameters, PolicyName, build};
use dragnet_search::shape::Shape;
use dragnet_search::utility::UtilityTable;

use field::Field;
use times::{Times, milliseconds, time};

/// The probability from which an object counts as found.
const TAU: f64 = 0.95;
const SEEDS: u64 = 10;
const DENSITIES: [f64; 2] = [0.2, 0.01];
const MOST_CELLS: usize = 600;

fn main() {
    // `cargo test --all-targets` only wants to know that this builds.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    // The table is built on first use.
    black_box(UtilityTable::information());
    for (name, target) in [
        (PolicyName::Path, Duration::from_micros(300)),
        (PolicyName::PathAdditive, Duration::from_micros(100)),
        (PolicyName::Greedy, Duration::from_micros(100)),
    ] {
        print_episodes(name, target);
    }
    print_large_map(Duration::from_millis(12));
    ratio::print();
    by_size::print();
    line_of_sight::print();
}

fn print_episodes(name: PolicyName, target: Duration) {
    println!("\n{name}, 30 x 30, {SEEDS} episodes a row; times in ms\n");
    println!("| map | density | decisions | median | 95 % | longest | median of the slowest episode |");
    println!("|---|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for shape in Shape::ALL {
        for density in DENSITIES {
            let episodes: Vec<Times> = (0..SEEDS).map(|seed| episode(name, shape, density, seed)).collect();
            let slowest = episodes.iter().map(|times| times.quantile(0.5)).max().unwrap();
            let times = Times::of(episodes.into_iter().flat_map(|times| times.0));
            println!("| {} | {density} | {} | {} |", shape.as_str(), times.row(), milliseconds(slowest));
            rows.push(times);
        }
    }
    print_verdict(rows, target);
}

/// The decisions of one episode.
fn episode(name: PolicyName, shape: Shape, density: f64, seed: u64) -> Times {
    let mut field = Field::fresh(shape, 30, density, seed);
    decisions(&mut field, name, |field, entered| {
        let objects = field.truth.objects();
        entered >= MOST_CELLS || objects.iter().all(|&cell| field.belief.is_found(cell, TAU))
    })
}

fn print_large_map(target: Duration) {
    println!("\npath, 300 x 300, all_traversable, 40 decisions in a row; times in ms\n");
    println!("| state | density | decisions | median | 95 % | longest |");
    println!("|---|---|---|---|---|---|");
    let mut rows = Vec::new();
    for density in DENSITIES {
        let fresh = Field::fresh(Shape::AllTraversable, 300, density, 1);
        for (state, mut field) in [("fresh", fresh), ("midway", Field::midway(300, density, 1))] {
            let mut decided = 0;
            let times = decisions(&mut field, PolicyName::Path, |_, _| {
                decided += 1;
                decided >= 40
            });
            println!("| {state} | {density} | {} |", times.row());
            rows.push(times);
        }
    }
    print_verdict(rows, target);
}

/// Decides, at least once, and walks until the search is over, given the number of cells entered.
fn decisions(field: &mut Field, name: PolicyName, mut is_over: impl FnMut(&Field, usize) -> bool) -> Times {
    let mut policy = build(name, Parameters::default());
    let (mut times, mut entered) = (Vec::new(), 0);
    while times.is_empty() || !is_over(field, entered) {
        let (elapsed, decision) = time(|| field.decide(policy.as_mut()));
        times.push(elapsed);
        entered += decision.path.len();
        for cell in decision.path {
            field.enter(cell);
        }
    }
    Times::of(times)
}

/// The median of all decisions of the table, and that of its slowest row, against the target.
fn print_verdict(rows: Vec<Times>, target: Duration) {
    let slowest = rows.iter().map(|times| times.quantile(0.5)).max().unwrap();
    let all = Times::of(rows.into_iter().flat_map(|times| times.0)).quantile(0.5);
    println!("\ntarget: at most {} ms", milliseconds(target));
    for (what, median) in [("of all decisions", all), ("of the slowest row", slowest)] {
        let verdict = if median <= target { "reached" } else { "not reached" };
        println!("median {what}: {} ms, {verdict}", milliseconds(median));
    }
}
