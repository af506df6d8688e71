//! A recording as arrays and plain records.

use std::path::PathBuf;

use dragnet_coordinator::RecordingError;
use dragnet_coordinator::fold::MissionFold;
use dragnet_coordinator::mission::Record;
use dragnet_coordinator::playback::Playback;
use dragnet_proto::message::{Activity, MissionStatus};
use dragnet_scenario::map_file::MapOrigin;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::observation::Observation;
use numpy::{PyArray2, PyArrayMethods, ToPyArray};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Reads a recording: the map, every observation and plan, the mission's status, and the belief at the end.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
pub(crate) fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let playback = py.detach(|| Playback::read(&path)).map_err(|error| unreadable(&error))?;
    let recording = PyDict::new(py);
    recording.set_item("run", &playback.run)?;
    recording.set_item("summary", &playback.summary)?;
    recording.set_item("ending", playback.ending.to_string())?;
    let mut fold = MissionFold::of(&playback);
    for (_, record) in &playback.records {
        fold.take(record);
    }
    add_map(&recording, &playback, &fold)?;
    add_observations(&recording, &playback)?;
    add_belief(&recording, &fold)?;
    let (plans, heartbeats, statuses) = (PyList::empty(py), PyList::empty(py), PyList::empty(py));
    for (time, record) in &playback.records {
        match record {
            Record::Intent(intent) => {
                let plan = timed(py, *time)?;
                plan.set_item("robot", intent.robot.number())?;
                plan.set_item("decision", intent.decision)?;
                plan.set_item("path", numbers(&intent.path).to_pyarray(py))?;
                plans.append(plan)?;
            }
            Record::Heartbeat(heartbeat) => {
                let beat = timed(py, *time)?;
                beat.set_item("robot", heartbeat.robot.number())?;
                beat.set_item("activity", activity(heartbeat.activity))?;
                beat.set_item("cell", heartbeat.cell.number())?;
                beat.set_item("path_meters", heartbeat.path_meters)?;
                beat.set_item("digest", heartbeat.digest.to_string())?;
                heartbeats.append(beat)?;
            }
            Record::Status(status) => statuses.append(standing(py, *time, status)?)?,
            _ => {}
        }
    }
    recording.set_item("plans", plans)?;
    recording.set_item("heartbeats", heartbeats)?;
    recording.set_item("statuses", statuses)?;
    Ok(recording)
}

fn unreadable(error: &RecordingError) -> PyErr {
    match error {
        RecordingError::Unreadable { .. } => PyValueError::new_err(error.to_string()),
        _ => PyOSError::new_err(error.to_string()),
    }
}

/// The map, its prior and what is searched, with the cells that the operator added.
fn add_map(recording: &Bound<'_, PyDict>, playback: &Playback, fold: &MissionFold) -> PyResult<()> {
    let (py, terrain) = (recording.py(), fold.terrain());
    let grid = terrain.grid();
    recording.set_item("cell_meters", terrain.cell_meters())?;
    let MapOrigin { x_meters, y_meters, yaw_radians } = playback.origin;
    recording.set_item("origin", (x_meters, y_meters, yaw_radians))?;
    recording.set_item("traversable", cells(py, grid, |cell| terrain.is_traversable(cell))?)?;
    recording.set_item("searched", cells(py, grid, |cell| terrain.is_searched(cell))?)?;
    #[expect(clippy::cast_possible_truncation, reason = "recordings have single precision")]
    let prior = |cell| fold.belief().prior_probability(cell) as f32;
    recording.set_item("prior", cells(py, grid, prior)?)
}

/// One entry for each observation, and one for each reading, which refers to its observation by index.
fn add_observations(recording: &Bound<'_, PyDict>, playback: &Playback) -> PyResult<()> {
    let py = recording.py();
    let seen: Vec<&Observation> = observations(playback).collect();
    let table = PyDict::new(py);
    let seconds = |it: &&Observation| MissionTime(it.time_ns).as_seconds();
    table.set_item("time_seconds", seen.iter().map(seconds).collect::<Vec<f64>>().to_pyarray(py))?;
    let robots: Vec<i64> = seen.iter().map(|it| i64::from(it.origin.source.number())).collect();
    table.set_item("robot", robots.to_pyarray(py))?;
    table.set_item("cell", seen.iter().map(|it| number(it.from)).collect::<Vec<i64>>().to_pyarray(py))?;
    recording.set_item("observations", table)?;
    let readings =
        || (0_i64..).zip(&seen).flat_map(|(place, it)| it.readings.iter().map(move |its| (place, its)));
    let table = PyDict::new(py);
    table.set_item("observation", readings().map(|(place, _)| place).collect::<Vec<i64>>().to_pyarray(py))?;
    table.set_item("cell", readings().map(|(_, it)| number(it.cell)).collect::<Vec<i64>>().to_pyarray(py))?;
    table.set_item("value", readings().map(|(_, it)| it.value).collect::<Vec<f32>>().to_pyarray(py))?;
    table.set_item("variance", readings().map(|(_, it)| it.variance).collect::<Vec<f32>>().to_pyarray(py))?;
    recording.set_item("readings", table)
}

/// The belief from all observations.
fn add_belief(recording: &Bound<'_, PyDict>, fold: &MissionFold) -> PyResult<()> {
    let (py, belief) = (recording.py(), fold.belief());
    let grid = fold.terrain().grid();
    recording.set_item("log_odds", cells(py, grid, |cell| belief.log_odds_nats(cell))?)?;
    recording.set_item("digest", belief.digest().to_string())
}

fn observations(playback: &Playback) -> impl Iterator<Item = &Observation> {
    playback.records.iter().filter_map(|(_, record)| match record {
        Record::Observation(observation) => Some(&**observation),
        _ => None,
    })
}

fn standing<'py>(py: Python<'py>, time: MissionTime, status: &MissionStatus) -> PyResult<Bound<'py, PyDict>> {
    let standing = timed(py, time)?;
    let declared: Vec<Cell> = status.declared.iter().map(|detection| detection.cell).collect();
    let probability: Vec<f64> = status.declared.iter().map(|detection| detection.probability).collect();
    standing.set_item("declared", numbers(&declared).to_pyarray(py))?;
    standing.set_item("probability", probability.to_pyarray(py))?;
    standing.set_item("observations", status.observations)?;
    standing.set_item("expected_remaining", status.expected_remaining)?;
    standing.set_item("digest", status.digest.to_string())?;
    Ok(standing)
}

fn timed(py: Python<'_>, time: MissionTime) -> PyResult<Bound<'_, PyDict>> {
    let record = PyDict::new(py);
    record.set_item("time_seconds", time.as_seconds())?;
    Ok(record)
}

const fn activity(activity: Activity) -> &'static str {
    match activity {
        Activity::Searching => "searching",
        Activity::Cleared => "cleared",
        Activity::Spent => "spent",
        Activity::Stuck => "stuck",
        Activity::Paused => "paused",
        Activity::Waiting => "waiting",
        Activity::Returning => "returning",
        Activity::Recalled => "recalled",
        Activity::Sent => "sent",
        Activity::Holding => "holding",
        Activity::Leaving => "leaving",
        Activity::GivingWay => "giving way",
    }
}

fn number(cell: Cell) -> i64 {
    i64::from(cell.number())
}

fn numbers(cells: &[Cell]) -> Vec<i64> {
    cells.iter().map(|&cell| number(cell)).collect()
}

/// A value for each cell, in rows from the south.
fn cells<T: numpy::Element>(
    py: Python<'_>,
    grid: Grid,
    value: impl Fn(Cell) -> T,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let values: Vec<T> = grid.cells().map(value).collect();
    values.to_pyarray(py).reshape([grid.rows() as usize, grid.columns() as usize])
}
