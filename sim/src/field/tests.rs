//! Whole trials of the field test.

use std::path::Path;

use dragnet_learn::policy::{PolicyName, Shipped};
use dragnet_scenario::file::PolicyField;
use dragnet_search::policy::PolicyName as Exact;

use super::*;

fn field(policy: impl Into<PolicyField>) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/field.toml");
    Scenario::load(&path).unwrap().with_policy(policy).unwrap()
}

/// A trial, and all of its results except measured times.
fn trial(scenario: &Scenario, seed: u64, thinking: DecisionTime) -> (Trial, String) {
    let trial = run(scenario, seed, thinking).unwrap();
    let text = format!("{:?}", Trial { decisions: Vec::new(), ..trial.clone() });
    (trial, text)
}

#[test]
fn the_site_is_that_of_the_paper() {
    let scenario = field(Exact::Path);
    let terrain = scenario.terrain();
    let area = terrain.searched_cells().count() as f64 * terrain.cell_meters().powi(2);
    assert!((area - 75_000.0).abs() < 500.0, "{area}");
    let site = Site::new(&scenario, 1).unwrap();
    assert_eq!(site.objects_meters().len(), 5);
    for (cell, object) in site.truth().objects().iter().zip(site.objects_meters()) {
        assert_eq!(
            terrain.grid().cell_at(object.x / terrain.cell_meters(), object.y / terrain.cell_meters()),
            Some(*cell)
        );
    }
}

#[test]
fn a_vehicle_finds_the_objects_and_its_observations_are_accepted() {
    let scenario = field(Exact::Path);
    let mut found = 0;
    for seed in [1, 2, 7, 10] {
        let (trial, _) = trial(&scenario, seed, DecisionTime::NONE);
        assert_eq!((trial.rejected, trial.decisions.is_empty()), (0, false), "seed {seed}");
        assert!(trial.score.false_positives <= 1, "{:?}", trial.score);
        // It drove at full speed, and observed in every cell of its paths.
        let seconds = trial.ended.as_seconds();
        let meters = trial.driven_meters[0];
        assert!((1.5 * seconds..2.0 * seconds).contains(&meters), "{meters} m in {seconds} s");
        assert!(trial.observations as f64 > meters / 25.0, "{} looks on {meters} m", trial.observations);
        found += u32::from(trial.found.is_some());
    }
    assert!(found >= 3, "{found} of 4");
}

/// Cells have 15.2 m: their centers are 5.8 m from the objects in them on average.
#[test]
fn declared_objects_are_where_their_positions_say() {
    let scenario = field(Exact::Path);
    let (mut within, mut offs, mut total) = (0, 0.0, 0);
    for seed in [1, 2, 7, 10] {
        let site = Site::new(&scenario, seed).unwrap();
        let (trial, _) = trial(&scenario, seed, DecisionTime::NONE);
        for (&cell, object) in site.truth().objects().iter().zip(site.objects_meters()) {
            let Some(position) = trial.positions.of(cell) else { continue };
            let (east, north) = position.meters();
            let off = (east - object.x).hypot(north - object.y);
            assert!(off < 3.0, "seed {seed}: {position:?} is {off} m off");
            total += 1;
            offs += off;
            within += u32::from(off <= position.accuracy_meters());
        }
    }
    let mean = offs / f64::from(total);
    assert!(total >= 12 && mean < 1.0, "{total} objects, {mean} m off on average");
    assert!(within * 10 >= total * 8, "{within} of {total} are within their accuracy");
}

#[test]
fn the_same_seed_gives_the_same_trial_to_the_byte() {
    for scenario in [
        field(PolicyName::Learned(Shipped::PathIceCreamCone)),
        field(Exact::Nats),
        field(Exact::Path).with_robots(3).unwrap(),
    ] {
        let (first, text) = trial(&scenario, 3, DecisionTime::NONE);
        assert_eq!(trial(&scenario, 3, DecisionTime::NONE).1, text);
        let (other, _) = trial(&scenario, 4, DecisionTime::NONE);
        assert_ne!(other.digest, first.digest);
    }
}

#[test]
fn three_vehicles_share_observations_and_are_done_sooner() {
    let (alone, team) = (field(Exact::Path), field(Exact::Path).with_robots(3).unwrap());
    let seconds = |scenario: &Scenario| -> f64 {
        let times = [1, 2, 3].map(|seed| trial(scenario, seed, DecisionTime::NONE).0);
        assert!(times.iter().all(|trial| trial.rejected == 0));
        times.iter().map(|trial| trial.ended.as_seconds()).sum()
    };
    let (alone, team) = (seconds(&alone), seconds(&team));
    assert!(team < 0.75 * alone, "{team} s instead of {alone} s");
}

#[test]
fn time_to_think_is_time_of_the_mission() {
    let scenario = field(Exact::Nats);
    let (at_once, _) = trial(&scenario, 2, DecisionTime::NONE);
    let (slow, _) = trial(&scenario, 2, DecisionTime { time: Duration::from_secs(30) });
    let still = |trial: &Trial| trial.trace.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let stops = slow.decisions.len() - 1;
    // From the edge of a cell it takes about 5 s to the middle; the rest of the time it stands.
    assert!(still(&slow) > still(&at_once) + 100 * stops, "{} {}", still(&slow), still(&at_once));
}
