//! The mission: a pond as no-go area, two prior regions, and two robots that drive east along two rows.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_coordinator::Ending;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_proto::directive::Directive;
use dragnet_proto::message::{Detection, Intent, MissionStatus};
use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::evidence::Reading;
use dragnet_search::observation::{Observation, Origin, RobotId, Versions};

/// 400 x 300 m at the equator, in cells of 20 m: 15 rows of 20 columns.
const AREAS: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"name":"Field & wood"},"geometry":{"type":"Polygon","coordinates":
    [[[0,0],[0.003593,0],[0.003593,0.002713],[0,0.002713],[0,0]]]}},
{"type":"Feature","properties":{"name":"Pond","kind":"no_go"},"geometry":{"type":"Polygon","coordinates":
    [[[0.0018,0.0020],[0.0022,0.0020],[0.0022,0.0023],[0.0018,0.0023],[0.0018,0.0020]]]}},
{"type":"Feature","properties":{"name":"South","poa":"60%"},"geometry":{"type":"Polygon","coordinates":
    [[[0,0],[0.003593,0],[0.003593,0.0007235],[0,0.0007235],[0,0]]]}},
{"type":"Feature","properties":{"name":"Car","poa":0.2,"spread_meters":50},"geometry":{"type":"Point","coordinates":
    [0.0030,0.0020]}}]}"#;
const SCENARIO: &str = "name = 'drawn'
map = { file = 'a.geojson', cell_meters = 20.0 }
objects.count = 2
robots.count = 2
mission = { budget_meters = 1000.0, speed_meters_per_second = 1.5 }
";

/// 2026-03-01T12:00:00Z.
pub(crate) const START_UNIX_NS: u64 = 1_772_366_400_000_000_000;
pub(crate) const SECOND_NS: u64 = 1_000_000_000;
/// Steps of each robot, one in ten seconds.
pub(crate) const STEPS: u32 = 18;

pub(crate) fn scenario() -> Scenario {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.geojson"), AREAS).unwrap();
    Scenario::from_text(&folder.path().join("a.toml"), SCENARIO.to_owned()).unwrap()
}

pub(crate) fn at(row: u32, column: u32) -> Cell {
    Grid::new(15, 20).unwrap().cell(Position { row, column }).unwrap()
}

#[expect(clippy::cast_possible_truncation, reason = "recordings have single precision")]
pub(crate) fn single_precision(prior: &Belief, cells: impl Iterator<Item = Cell>) -> Vec<f32> {
    cells.map(|cell| prior.probability(cell) as f32).collect()
}

/// The recording, as read.
pub(crate) fn playback() -> Playback {
    let scenario = scenario();
    let grid = scenario.terrain().grid();
    let mut records: Vec<(MissionTime, Record)> = (0..STEPS)
        .flat_map(|step| [(1, 2), (2, 10)].map(|(robot, row)| (step, robot, row)))
        .map(|(step, robot, row)| observe(&scenario, step, robot, row))
        .collect();
    // A message that was lost at first comes last.
    let (_, late) = records.remove(6);
    records.push((MissionTime(172 * SECOND_NS), late));
    records.push((MissionTime(175 * SECOND_NS), Record::Intent(intent())));
    let end = MissionTime(180 * SECOND_NS);
    records.push((end, Record::Status(status())));
    let run = [
        ("scenario", "drawn"),
        ("robots", "2"),
        ("detection_threshold", "0.95"),
        ("speed_meters_per_second", "1.5"),
    ];
    Playback {
        prior: single_precision(scenario.prior(), grid.cells()),
        terrain: Arc::new(scenario.terrain().clone()),
        origin: scenario.origin(),
        records,
        start_unix_ns: START_UNIX_NS,
        earth: scenario.earth(),
        run: run.map(|(name, value)| (name.to_owned(), value.to_owned())).into(),
        summary: BTreeMap::new(),
        ending: Ending::Complete,
    }
}

/// A robot observes from the next cell of its row.
fn observe(scenario: &Scenario, step: u32, robot: u16, row: u32) -> (MissionTime, Record) {
    let (grid, from) = (scenario.terrain().grid(), at(row, step));
    let footprint = scenario.sensor().footprint().iter();
    let readings = footprint.filter_map(|footprint_cell| {
        let cell = grid.step(from, footprint_cell.offset)?;
        Some(Reading { cell, value: 0.0, variance: footprint_cell.variance })
    });
    let time_ns = u64::from(step) * 10 * SECOND_NS;
    let observation = Observation {
        origin: Origin::first(RobotId::new(robot).unwrap()),
        sequence: step.into(),
        time_ns,
        from,
        readings: readings.collect(),
        positions: Box::default(),
    };
    (MissionTime(time_ns), Record::Observation(Arc::new(observation)))
}

/// Robot 1 goes on east, then north, and finally west.
fn intent() -> Intent {
    let path = [(2, 18), (2, 19), (3, 19), (4, 19), (5, 19), (5, 18)];
    Intent {
        robot: RobotId::FIRST,
        incarnation: 0,
        decision: 4,
        time_ns: 175 * SECOND_NS,
        path: path.map(|(row, column)| at(row, column)).to_vec().into(),
    }
}

fn status() -> MissionStatus {
    let object = |cell, probability, seconds| Detection { cell, probability, time_ns: seconds * SECOND_NS };
    MissionStatus {
        time_ns: 180 * SECOND_NS,
        declared: vec![object(at(3, 12), 0.9876, 125), object(at(9, 4), 0.96, 45)],
        expected_remaining: 0.5,
        alive: vec![RobotId::FIRST, RobotId::new(2).unwrap()],
        observations: 36,
        versions: Versions::default(),
        digest: scenario().prior().digest(),
        directive: Directive::default(),
        doubled: Vec::new(),
    }
}
