//! The information policies against their definition: every candidate's path is traversed and summed separately.

use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_search::evidence::UNITS;
use dragnet_search::intent::TeammatePlan;
use dragnet_search::policy::{Decision, Parameters, PathIntegralReference, Policy, PolicyName, build};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::utility::UtilityTable;

use super::{Case, check};

/// Information of observations from these cells, beyond the planned precision, nats.
fn information(case: &Case, from: &[Cell]) -> f64 {
    let table = UtilityTable::information();
    let grid = case.terrain.grid();
    let mut sum = 0.0;
    for cell in case.terrain.searched_cells() {
        let mut precision = 0;
        for &from in from {
            let offset = grid.offset(from, cell);
            let distance = offset.manhattan();
            if distance <= case.sensor.radius() && !case.terrain.line_of_sight().hides(from, offset) {
                precision += dragnet_search::evidence::precision_units(case.sensor.variance(distance));
            }
        }
        let row = table.row(case.belief.log_odds_nats(cell));
        let planned_precision = case.planned_precision.precision(cell);
        let at = |units: i64| f64::from(table.utility(row, i32::try_from(units).unwrap()));
        assert!((planned_precision + precision) as f64 / UNITS < 30_000.0);
        sum += at(planned_precision + precision) - at(planned_precision);
    }
    sum
}

fn weight(case: &Case, to: Cell) -> f64 {
    1.0 / (1.0 + 0.2 * f64::from(case.routes().length(to)))
}

#[test]
fn greedy_scores_the_observation_at_the_waypoint() {
    for seed in 0..100 {
        let case = Case::new(seed);
        check(&case, &case.decide(PolicyName::Greedy, seed), |to| information(&case, &[to]), 1e-4);
    }
}

#[test]
fn path_additive_sums_observations_one_by_one() {
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
fn path_scores_all_observations_jointly() {
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
fn path_equals_its_definition() {
    for seed in 0..100 {
        let case = Case::new(seed);
        let mut random = stream(seed, Purpose::Decision, 1);
        let mut definition = PathIntegralReference::new(Parameters::default().path_length_weight);
        let defined = definition.decide(&case.situation(), &mut random);
        check(&case, &case.decide(PolicyName::Path, seed), |to| defined.scores[to.index()], 1e-4);
    }
}

/// Among many teammates little is left to a robot, so that far candidates are not scored.
#[test]
fn path_chooses_the_same_where_nobody_looks_at_the_scores() {
    let (mut cut, mut rests) = (0, 0);
    for (number, seed) in (0..60).enumerate() {
        let mut case = Case::of_side(seed, 30..50);
        let waypoints: Vec<Cell> = case.terrain.grid().cells().skip(number % 7).step_by(29).collect();
        let teammates = [0, 4, waypoints.len()][number % 3];
        let sensor = Arc::new(case.sensor.clone());
        for &waypoint in &waypoints[..teammates] {
            let plan = TeammatePlan {
                member: None,
                cell: None,
                path: vec![waypoint].into(),
                driven_cells: 0.0,
                sensor: Arc::clone(&sensor),
                line_of_sight: case.terrain.line_of_sight().clone(),
                pace: 1.0,
            };
            case.planned_precision.add_plan(&case.terrain, plan);
        }
        case.planned_precision.add_shares(&case.terrain, &case.sensor, case.robot);
        let decision = case.decide(PolicyName::Path, seed);
        let mut policy = build(PolicyName::Path, Parameters::default());
        let chosen = policy.choose(&case.situation(), &mut stream(seed, Purpose::Decision, 1));
        assert_eq!((chosen.chosen, &chosen.path), (decision.chosen, &decision.path), "{seed}");
        assert_eq!(chosen.had_candidates(), decision.had_candidates(), "{seed}");
        let weighed = |decision: &Decision| decision.scores.iter().filter(|score| score.is_finite()).count();
        cut += usize::from(weighed(&chosen) < weighed(&decision));
        rests += usize::from(decision.is_rest());
    }
    assert!(cut > 10 && cut < 60 && rests < 40, "{cut} cut, {rests} rests");
}

/// No length of path is then too long to win.
#[test]
fn path_chooses_the_same_where_lengths_weigh_nothing() {
    for path_length_weight in [0.0, -0.0, 1e-300, 1e-17, 1e-6, 1e6] {
        let parameters = Parameters { path_length_weight, ..Parameters::default() };
        for seed in 0..10 {
            let case = Case::of_side(seed, 30..50);
            let random = || stream(seed, Purpose::Decision, 1);
            let decision = build(PolicyName::Path, parameters).decide(&case.situation(), &mut random());
            let chosen = build(PolicyName::Path, parameters).choose(&case.situation(), &mut random());
            assert_eq!(chosen.path, decision.path, "weight {path_length_weight}, seed {seed}");
        }
    }
}
