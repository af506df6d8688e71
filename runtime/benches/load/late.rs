//! A late joiner: a robot without observations meets one with all of a long mission.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::convert::Codec;
use dragnet_proto::state_machine::Event;
use dragnet_runtime::clock::Clock;
use dragnet_runtime::journal::Journal;
use dragnet_runtime::session::{Endpoints, open};
use dragnet_runtime::wall_clock::{self, Report};
use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::{Observation, Origin, RobotId};
use tokio::sync::mpsc;

use crate::probe::{Measured, Probe};
use crate::{join, journal, mesh, observe, scenario};

const MISSION: &str = "late";
const OBSERVATIONS: u32 = 10_000;
const ROUNDS: usize = 5;
/// Time from one cell to the next.
const STEP: Duration = Duration::from_nanos(STEP_NS);
const STEP_NS: u64 = 100_000_000_000;

pub(crate) async fn run() {
    for _ in 0..ROUNDS {
        round().await;
    }
}

async fn round() {
    let scenario = scenario(3, 60);
    let endpoints = mesh(2);
    let measured = Arc::new(Mutex::new(Measured::default()));
    let mut agent_config = AgentConfig::of_team(&scenario, 1).into_iter();
    let mut veteran = Agent::new(agent_config.next().unwrap());
    let journals = tempfile::tempdir().unwrap();
    let mut kept = journal(journals.path(), MISSION, RobotId::FIRST, &scenario);
    let there: Vec<Cell> = snake(&scenario);
    // There and back, so that each step is to a neighbor.
    let way = there.iter().chain(there.iter().rev()).cycle();
    for (sequence, &from) in (0..u64::from(OBSERVATIONS / 2)).zip(way) {
        for robot in [1, 3] {
            let (origin, time_ns) = (Origin::first(RobotId::new(robot).unwrap()), STEP_NS * sequence);
            let readings = observe(&scenario, from);
            let observation = Arc::new(Observation {
                origin,
                sequence,
                time_ns,
                from,
                readings,
                positions: Box::default(),
            });
            veteran.recall(&observation);
            kept.note(vec![observation]);
        }
    }
    let stand = |_: &Agent| Event::Sensed { cell: there[0], readings: observe(&scenario, there[0]) };
    let report = stand(&veteran);
    let veteran = Probe { robot: RobotId::FIRST, agent: veteran, measured: Arc::clone(&measured) };
    let first = tokio::spawn(take_part(veteran, endpoints[0].clone(), kept, (None, report)));
    // Until its first observation.
    while measured.lock().unwrap().published() == 0 {
        tokio::task::yield_now().await;
    }
    let late = Agent::new(agent_config.next().unwrap());
    let report = stand(&late);
    let late = Probe { robot: RobotId::new(2).unwrap(), agent: late, measured: Arc::clone(&measured) };
    let kept = journal(journals.path(), MISSION, RobotId::new(2).unwrap(), &scenario);
    let started = Instant::now();
    let second = tokio::spawn(take_part(late, endpoints[1].clone(), kept, (None, report)));
    while !measured.lock().unwrap().agree(2, u64::from(OBSERVATIONS) + 2) {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    println!("a late joiner has {OBSERVATIONS} observations after {:.2} s", started.elapsed().as_secs_f64());
    first.abort();
    second.abort();
}

/// All cells, each adjacent to the one before.
fn snake(scenario: &Scenario) -> Vec<Cell> {
    let grid = scenario.terrain().grid();
    let cells: Vec<Cell> = grid.cells().collect();
    let rows = cells.chunks(grid.columns() as usize).enumerate();
    rows.flat_map(|(row, cells)| {
        let mut cells = cells.to_vec();
        if row % 2 == 1 {
            cells.reverse();
        }
        cells
    })
    .collect()
}

async fn take_part(mut probe: Probe, endpoints: Endpoints, journal: Journal, report: Report) {
    let session = open(&endpoints).await.unwrap();
    let scenario = scenario(3, 60);
    let codec = Codec::new(scenario.terrain().grid());
    let mut link = join(session, MISSION, probe.robot, codec).await;
    let (sender, reports) = mpsc::channel(1);
    sender.send(report).await.unwrap();
    let never = std::future::pending::<()>();
    let clock = Clock::new(1.0).at(MissionTime::START + STEP * OBSERVATIONS);
    wall_clock::run(&mut link, &mut probe, scenario.places(), clock, Some(journal), reports, never)
        .await
        .unwrap();
}
