//! How often an object is declared where it is, over random drives past it.
//!
//! `DRAGNET_DRIVES=200 cargo test --release -p dragnet-vehicle --test drives -- --nocapture` is the whole measurement;
//! without, there are a few drives of each kind. `DRAGNET_SEED` is the first seed of others, `DRAGNET_ONLY` a part of
//! the name of those that are driven, and `DRAGNET_LOG` prints the drives that were not right.

use crate::drive::{Eyes, Kind, Outcome, run, run_two};

/// Default number of drives of each kind.
const FEW_DRIVES: u64 = 3;
/// The minimum share of objects declared in the right place, and the maximum elsewhere.
const LEAST_RIGHT: f64 = 0.97;
const MOST_WRONG: f64 = 0.01;

#[derive(Default)]
struct Count {
    drives: u32,
    right: u32,
    wrong: u32,
    /// Seeds of the drives that were not right.
    others: Vec<u64>,
}

impl Count {
    fn add(&mut self, seed: u64, outcome: &Outcome) {
        self.drives += 1;
        self.right += u32::from(outcome.is_right && !outcome.is_wrong);
        self.wrong += u32::from(outcome.is_wrong);
        if !outcome.is_right || outcome.is_wrong {
            self.others.push(seed);
            if std::env::var("DRAGNET_LOG").is_ok() {
                println!("seed {seed}: {}", outcome.log);
            }
        }
    }

    fn print(&self, name: &str) {
        let Self { drives, right, wrong, others } = self;
        println!("{name}: of {drives} drives {right} right, {wrong} wrong; not right: {others:?}");
    }
}

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[cfg_attr(test, test)]
pub(crate) fn objects_are_declared_where_they_are() {
    let (first, drives) = (number("DRAGNET_SEED", 0), number("DRAGNET_DRIVES", FEW_DRIVES));
    let only = std::env::var("DRAGNET_ONLY").unwrap_or_default();
    let mut whole = Count::default();
    for eyes in [Eyes::TwoWide, Eyes::Default, Eyes::OneWide] {
        for cell_meters in [10.0, 30.0] {
            for kind in [Kind::Through, Kind::Abeam, Kind::Border, Kind::Corner] {
                let name = format!("{eyes:?}, {cell_meters} m, {kind:?}");
                if !name.contains(&only) {
                    continue;
                }
                let mut count = Count::default();
                for seed in first..first + drives {
                    let outcome = run(kind, eyes, cell_meters, seed);
                    count.add(seed, &outcome);
                    whole.add(seed, &outcome);
                }
                count.print(&name);
            }
        }
    }
    whole.print("all");
    let share = |count: u32| f64::from(count) / f64::from(whole.drives.max(1));
    assert!(share(whole.right) >= LEAST_RIGHT && share(whole.wrong) <= MOST_WRONG, "too few are right");
}

/// What one robot has declared in a cell, the next declares in the same one, even if its own estimate lies across the
/// border.
#[cfg_attr(test, test)]
pub(crate) fn two_robots_declare_an_object_on_a_border_once() {
    let (first, drives) = (number("DRAGNET_SEED", 0), number("DRAGNET_DRIVES", 20));
    let mut counts = [0; 4];
    for kind in [Kind::Border, Kind::Corner] {
        for eyes in [Eyes::TwoWide, Eyes::OneWide] {
            for seed in first..first + drives {
                counts[run_two(kind, eyes, 10.0, seed).min(3)] += 1;
            }
        }
    }
    println!("drives of two robots by the number of cells they declared, 0 to 3 and more: {counts:?}");
    let drives: u32 = counts.iter().sum();
    assert!(counts[1] * 100 >= drives * 97, "{counts:?}");
}
