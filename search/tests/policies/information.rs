//! The information policies against the definition: every candidate's path walked and summed anew.

use dragnet_search::cell::Cell;
use dragnet_search::evidence::UNITS;
use dragnet_search::information::InformationTable;
use dragnet_search::policy::{Parameters, PathIntegralReference, Policy, PolicyName};
use dragnet_search::seed::{Purpose, stream};

use super::{Case, check};

/// Information of looks from these cells, beyond what is promised, nats.
fn information(case: &Case, from: &[Cell]) -> f64 {
    let table = InformationTable::shared();
    let grid = case.terrain.grid();
    let mut sum = 0.0;
    for cell in case.terrain.searched_cells() {
        let mut precision = 0;
        for &from in from {
            let distance = grid.manhattan(from, cell);
            if distance <= case.sensor.radius() {
                precision += dragnet_search::evidence::precision_units(case.sensor.variance(distance));
            }
        }
        let row = table.row(case.belief.log_odds_nats(cell));
        let promised = case.promised.precision(cell);
        let at = |units: i64| f64::from(table.information(row, i32::try_from(units).unwrap()));
        assert!((promised + precision) as f64 / UNITS < 30_000.0);
        sum += at(promised + precision) - at(promised);
    }
    sum
}

fn weight(case: &Case, to: Cell) -> f64 {
    1.0 / (1.0 + 0.2 * f64::from(case.routes().length(to)))
}

#[test]
fn greedy_values_the_look_at_the_waypoint() {
    for seed in 0..100 {
        let case = Case::new(seed);
        check(&case, &case.decide(PolicyName::Greedy, seed), |to| information(&case, &[to]), 1e-4);
    }
}

#[test]
fn path_additive_sums_the_looks_one_by_one() {
    for seed in 0..100 {
        let case = Case::new(seed);
        let sum = |to: Cell| -> f64 {
            case.routes().path(to).iter().map(|&from| information(&case, &[from])).sum()
        };
        let expected = |to| weight(&case, to) * sum(to);
        check(&case, &case.decide(PolicyName::PathAdditive, seed), expected, 1e-4);
    }
}

#[test]
fn path_values_all_looks_together() {
    let mut overlaps = 0;
    for seed in 0..100 {
        let case = Case::new(seed);
        let decision = case.decide(PolicyName::Path, seed);
        let joint = |to: Cell| information(&case, &case.routes().path(to));
        check(&case, &decision, |to| weight(&case, to) * joint(to), 1e-4);
        let path = case.routes().path(decision.chosen);
        let single: f64 = path.iter().map(|&from| information(&case, &[from])).sum();
        overlaps += usize::from(single > joint(decision.chosen) + 0.01);
    }
    assert!(overlaps > 50, "paths whose looks overlap: {overlaps}");
}

#[test]
fn path_is_what_its_definition_says() {
    for seed in 0..100 {
        let case = Case::new(seed);
        let mut random = stream(seed, Purpose::Decision, 1);
        let mut definition = PathIntegralReference::new(Parameters::default().path_length_weight);
        let defined = definition.decide(&case.situation(), &mut random);
        check(&case, &case.decide(PolicyName::Path, seed), |to| defined.scores[to.index()], 1e-4);
    }
}
