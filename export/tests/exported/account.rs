//! The state of a recorded mission.

use dragnet_export::{Account, ExportError};
use dragnet_scenario::map_file::GeoPoint;
use dragnet_scenario::time::MissionTime;
use dragnet_search::detection::probability_of_detection;
use dragnet_search::observation::RobotId;

use crate::mission::{SECOND_NS, STEPS, at, playback, scenario};

fn account() -> Account {
    Account::new(&playback(), None, None).unwrap()
}

#[test]
fn tracks_are_in_the_order_of_the_robots_own_clock() {
    let account = account();
    assert_eq!(
        account.tracks.keys().copied().collect::<Vec<_>>(),
        [RobotId::FIRST, RobotId::new(2).unwrap()]
    );
    for (robot, visits) in &account.tracks {
        let cells: Vec<_> = visits.iter().map(|visit| visit.cell).collect();
        let row = if *robot == RobotId::FIRST { 2 } else { 10 };
        assert_eq!(cells, (0..STEPS).map(|column| at(row, column)).collect::<Vec<_>>());
        assert!(visits.is_sorted_by_key(|visit| visit.time));
    }
}

#[test]
fn at_an_earlier_time_the_account_knows_no_more_than_then() {
    let early = Account::new(&playback(), None, Some(MissionTime(45 * SECOND_NS))).unwrap();
    // One observation of robot 1 came late.
    let visits: Vec<usize> = early.tracks.values().map(Vec::len).collect();
    assert_eq!(visits, [4, 5]);
    assert!(early.found.is_empty() && early.plans.is_empty());
    assert!(early.total.pod < account().total.pod);
}

#[test]
fn each_cell_has_the_detection_of_its_own_evidence() {
    let (account, scenario, playback) = (account(), scenario(), playback());
    let mut belief = scenario.prior().clone();
    for (_, record) in &playback.records {
        if let dragnet_coordinator::mission::Record::Observation(observation) = record {
            observation.readings.iter().for_each(|reading| belief.add(reading));
        }
    }
    let mut met = [0, 0];
    for cell in scenario.terrain().grid().cells() {
        let evidence = belief.evidence().of(cell);
        let expected = probability_of_detection(scenario.prior().log_odds_nats(cell), evidence, 0.95);
        let given = account.pod[cell.index()];
        assert!((given - expected).abs() < 1e-4, "{cell:?}: {given} {expected}");
        met[0] += usize::from(given < 0.1);
        met[1] += usize::from(given > 0.9);
    }
    assert!(met.iter().all(|&count| count > 4), "{met:?}");
}

#[test]
fn the_success_of_all_is_that_of_its_parts() {
    let account = account();
    let coverage = |name: &str| account.areas.iter().find(|(area, _)| area.name == name).unwrap().1;
    assert_eq!(coverage("Pond"), None);
    let (field, south, car) = (coverage("Field & wood"), coverage("South"), coverage("Car"));
    let [field, south, car] = [field, south, car].map(Option::unwrap);
    assert_eq!((field.cells, south.cells), (300, 80));
    assert!((south.poa - 0.6).abs() < 1e-12 && (car.poa - 0.2).abs() < 1e-12);
    assert!((field.poa - 1.0).abs() < 1e-6, "all of it lies in the field: {field:?}");
    assert!(south.pod > 0.95 && car.pod < south.pod && car.pod > 0.1, "{south:?} {car:?}");
    // The rest is spread over the cells north of the southern region.
    let free = (4..15).flat_map(|row| (0..20).map(move |column| at(row, column)));
    let pods: Vec<f64> = free.map(|cell| account.pod[cell.index()]).collect();
    let rest = pods.iter().sum::<f64>() / pods.len() as f64;
    let parts = south.pos() + car.pos() + 0.2 * rest;
    assert!((account.total.pos() - parts).abs() < 1e-6, "{} {parts}", account.total.pos());
    assert!((account.total.pos() - field.pos()).abs() < 1e-6);
}

#[test]
fn a_map_needs_exactly_one_position() {
    let origin = GeoPoint { longitude_degrees: 7.0, latitude_degrees: 46.0 };
    assert!(matches!(Account::new(&playback(), Some(origin), None), Err(ExportError::TwoOrigins { .. })));
    let mut unplaced = playback();
    unplaced.earth = None;
    let error = Account::new(&unplaced, None, None).unwrap_err().to_string();
    assert!(error.contains("earth") && error.contains("allowed"), "{error}");
    let placed = Account::new(&unplaced, Some(origin), None).unwrap();
    let point = placed.point(at(0, 0));
    assert!((point.latitude_degrees - 46.0 - 10.0 / 111_150.0).abs() < 1e-6, "{point:?}");
    assert!((point.longitude_degrees - 7.0 - 10.0 / 77_470.0).abs() < 1e-6, "{point:?}");
    unplaced.origin.yaw_radians = std::f64::consts::FRAC_PI_2;
    let turned = Account::new(&unplaced, Some(origin), None).unwrap().point(at(0, 1));
    assert!(
        (turned.latitude_degrees - 46.0 - 30.0 / 111_150.0).abs() < 1e-6,
        "its rows run north: {turned:?}"
    );
    assert!((turned.longitude_degrees - 7.0 + 10.0 / 77_470.0).abs() < 1e-6, "{turned:?}");
    assert!(placed.areas.is_empty() && (placed.total.poa - 1.0).abs() < 1e-9);
}

#[test]
fn a_prior_of_another_length_is_ignored() {
    let mut broken = playback();
    broken.prior.pop();
    let account = Account::new(&broken, None, None).unwrap();
    assert!(account.pod.iter().all(|&pod| pod <= 0.0) && account.total.pos() <= 0.0);
}
