//! A network learns which of its choices were good, and goes on where it was stopped.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use std::sync::mpsc;

use dragnet_learn::policy::Shipped;
use dragnet_learn::reinforcement::{Explorer, Visit};
use dragnet_learn::weights::Weights;
use dragnet_search::belief::Belief;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::policy::{CostToGo, Policy};
use dragnet_search::seed::{Purpose, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::Terrain;
use dragnet_train::{Device, Reinforcement, Reinforcer, set_threads};

/// Of a round.
const SEARCHES: u16 = 16;

fn settings(rounds: u32) -> Reinforcement {
    Reinforcement {
        seed: 1,
        rounds,
        passes: 3,
        batch: 8,
        learning_rate: 3e-3,
        temperature: 1.0,
        trace: 0.0,
        seeds: "these".to_owned(),
        start: "there".to_owned(),
    }
}

fn start() -> Weights {
    Weights::from_bytes(Shipped::Tour.weights()).unwrap()
}

/// Searches of one decision each, in the middle of a corridor. Who goes far has saved a cell, others have not; the network
/// could not tell west from east.
fn searches(reinforcer: &Reinforcer, seed: u64) -> Vec<Vec<Visit>> {
    let terrain = Terrain::from_ascii("...........\n", 30.0).unwrap();
    let belief = Belief::from_log_odds(&terrain, vec![-3.0; 11]).unwrap();
    let (sensor, nothing) = (Sensor::default(), PlannedPrecision::nothing(&terrain));
    let middle = terrain.grid().cells().nth(5).unwrap();
    let situation = Situation::alone(&terrain, &sensor, &belief, &nothing, middle);
    let network = reinforcer.network().unwrap();
    let search = |number| {
        let (sink, visits) = mpsc::channel();
        let mut explorer = Explorer::new(network.clone(), 1.0, sink);
        explorer.decide(&situation, &mut stream(seed, Purpose::Decision, number));
        let visit = visits.try_recv().unwrap();
        let is_far = visit.length_cells > 2.5;
        let to_go = CostToGo { expected_cells: f64::from(u8::from(is_far)), unfinished: 0.0 };
        vec![Visit { to_go, ..visit }]
    };
    (0..SEARCHES).map(search).collect()
}

fn far(searches: &[Vec<Visit>]) -> f64 {
    let saved = searches.iter().map(|visits| visits[0].to_go.expected_cells);
    saved.sum::<f64>() / searches.len() as f64
}

#[test]
fn what_saved_cells_is_chosen_more_often() {
    set_threads(1);
    let mut reinforcer = Reinforcer::new(start(), settings(12), Device::Cpu, "test");
    let before = far(&searches(&reinforcer, 0));
    assert!(before < 0.8, "{before}");
    for seed in 1..=12 {
        reinforcer.learn(&searches(&reinforcer, seed)).unwrap();
    }
    assert!(reinforcer.is_done());
    let after = far(&searches(&reinforcer, 0));
    assert!(after > 0.9, "{before} {after}");
}

#[test]
fn a_reinforcement_goes_on_where_it_was_stopped() {
    set_threads(1);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint");
    let mut whole = Reinforcer::new(start(), settings(4), Device::Cpu, "test");
    whole.start_measured(9.0);
    for round in 0..4 {
        if round == 2 {
            whole.checkpoint(&path).unwrap();
        }
        whole.learn(&searches(&whole, round)).unwrap();
        whole.measured([8.0, 7.0, 7.5, 8.0][usize::try_from(round).unwrap()]).unwrap();
    }
    let mut resumed = Reinforcer::resume(start(), settings(4), Device::Cpu, "test", &path).unwrap();
    assert_eq!(resumed.rounds_done(), 2);
    for round in 2..4 {
        resumed.learn(&searches(&resumed, round)).unwrap();
        resumed.measured(8.0).unwrap();
    }
    assert!(resumed.network().unwrap() == whole.network().unwrap());
    assert!(resumed.best() == whole.best(), "that of the second round");
    assert_eq!(resumed.best().recipe().own_searches, Some(32));

    let other = Reinforcement { trace: 0.5, ..settings(4) };
    let error = Reinforcer::resume(start(), other, Device::Cpu, "test", &path).err().unwrap().to_string();
    assert!(error.contains("another training") && error.contains("trace: 0.5"), "{error}");
}
