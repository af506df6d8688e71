//! The memory that a robot needs on a map of a million cells, in a process of its own, so that no other test counts.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Activity, Heartbeat, Intent, Message};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::evidence::{Digest, Reading};
use dragnet_search::observation::{Observation, Origin, RobotId, Version};
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;

const SIDE: u32 = 1000;
const LIMIT_BYTES: u64 = 200_000_000;
const MATE: RobotId = RobotId::FIRST;
/// Observations of each of the two robots.
const OBSERVATIONS: u64 = 2000;
/// The robot first decides when all of them have arrived, so that the test is quick.
const FIRST_DECISION: Duration = Duration::from_secs(10_000);

const SCENARIO: &str = r#"
name = "memory"

[map]
shape = "all_traversable"
rows = 1000
columns = 1000

[objects]
density = 0.01

[robots]
count = 2
policy = "path"

[mission]
budget_seconds = 1000000.0
speed_meters_per_second = 1000.0
start_stagger_seconds = 10000.0
"#;

#[test]
fn a_robot_on_a_million_cells_needs_less_than_200_megabytes() {
    let mut search = Search::new();
    for sequence in 0..OBSERVATIONS {
        let now = MissionTime::START + Duration::from_secs(sequence);
        search.sense(now, search.lane_cell(300, sequence));
        search.receive_mate(now, sequence);
    }
    assert_eq!(search.agent.replica().log().len(), 2 * OBSERVATIONS);
    assert_eq!(search.agent.decisions(), 0);

    let mut now = MissionTime::START + FIRST_DECISION;
    let mut effects = search.agent.react(now, Event::Woke);
    for decisions in 1..=3 {
        assert_eq!(search.agent.decisions(), decisions);
        for cell in effects.route.clone().unwrap() {
            now = now + Duration::from_secs(1);
            effects = search.sense(now, cell);
        }
    }

    let Some(peak) = peak_resident_bytes() else {
        println!("skipped: this system does not tell the peak of resident memory");
        return;
    };
    println!("peak of resident memory: {:.1} MB", peak as f64 / 1e6);
    assert!(peak < LIMIT_BYTES, "{peak} bytes");
}

/// The second robot of a team of two, and the world around it.
struct Search {
    agent: Agent,
    grid: Grid,
    sensor: Arc<Sensor>,
    noise: Stream,
}

impl Search {
    fn new() -> Self {
        let scenario = Scenario::from_text(Path::new("memory.toml"), SCENARIO.to_owned()).unwrap();
        let config = AgentConfig::of_team(&scenario, 1).remove(1);
        assert_eq!(config.terrain.grid().cell_count(), (SIDE * SIDE) as usize);
        let (grid, sensor) = (config.terrain.grid(), Arc::clone(&config.robot.class.sensor));
        Self { agent: Agent::new(config), grid, sensor, noise: stream(1, Purpose::Noise, 2) }
    }

    /// The cells of lanes a sensor's width apart, from this row on.
    fn lane_cell(&self, first_row: u32, step: u64) -> Cell {
        let step = u32::try_from(step).unwrap();
        let (lane, along) = (step / SIDE, step % SIDE);
        let column = if lane.is_multiple_of(2) { along } else { SIDE - 1 - along };
        let row = first_row + lane * (2 * self.sensor.radius() + 1);
        self.grid.cell(Position { row, column }).unwrap()
    }

    /// The robot observes from a cell and finds nothing.
    fn sense(&mut self, now: MissionTime, cell: Cell) -> Effects<Message> {
        let readings = self.observe(cell);
        self.agent.react(now, Event::Sensed { cell, readings })
    }

    fn observe(&mut self, from: Cell) -> Vec<Reading> {
        let mut readings = Vec::with_capacity(self.sensor.footprint().len());
        for step_observation in self.sensor.footprint() {
            if let Some(cell) = self.grid.step(from, step_observation.offset) {
                let value = self.sensor.draw(false, step_observation, &mut self.noise);
                readings.push(Reading { cell, value, variance: step_observation.variance });
            }
        }
        readings
    }

    /// The teammate is a hundred rows to the north: it publishes observations, and now and then a heartbeat with its
    /// plan.
    fn receive_mate(&mut self, now: MissionTime, sequence: u64) {
        let from = self.lane_cell(400, sequence);
        let readings = self.observe(from);
        let observation = Observation {
            origin: Origin::first(MATE),
            sequence,
            time_ns: now.0,
            from,
            readings,
            positions: Box::default(),
        };
        self.receive(now, Message::Observation(Arc::new(observation)));
        if sequence.is_multiple_of(10) {
            let intent = self.plan_of_mate(now, sequence);
            self.receive(now, Message::Intent(intent.clone()));
            self.receive(now, Message::Heartbeat(self.heartbeat_of_mate(now, sequence, intent)));
        }
    }

    fn plan_of_mate(&self, now: MissionTime, sequence: u64) -> Intent {
        let path = (1..=10).map(|ahead| self.lane_cell(400, sequence + ahead)).collect();
        Intent { robot: MATE, incarnation: 0, decision: sequence / 10, time_ns: now.0, path }
    }

    fn heartbeat_of_mate(&self, now: MissionTime, sequence: u64, intent: Intent) -> Heartbeat {
        Heartbeat {
            robot: MATE,
            time_ns: now.0,
            activity: Activity::Searching,
            cell: self.lane_cell(400, sequence),
            path_meters: sequence as f64 * 30.0,
            intent,
            versions: vec![Version { origin: Origin::first(MATE), next: sequence + 1 }].into(),
            digest: Digest(0),
            directive: Directive::default(),
        }
    }

    fn receive(&mut self, now: MissionTime, message: Message) {
        self.agent.react(now, Event::Received { from: Participant::Robot(MATE), message });
    }
}

/// `VmHWM` of this process, if the system provides it.
fn peak_resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
