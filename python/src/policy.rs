//! Dragnet's policies for Python.

use std::path::PathBuf;
use std::sync::Mutex;

use dragnet_learn::policy::{PolicyName, build};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::evidence::{CellEvidence, Evidence, UNITS};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::{Ground, Terrain};
use numpy::{PyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::scenario::{Scenario, refused};

/// Sums of evidence stay below this many units, so that they are whole numbers in 64-bit floats.
const MOST_UNITS: f64 = (1_u64 << 53) as f64;

/// A policy with its random stream.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct Policy {
    recipe: dragnet_scenario::Policy,
    /// Map, prior, sensor and moves; without a scenario they follow from the observation and the defaults.
    scenario: Option<dragnet_scenario::Scenario>,
    robot: u16,
    state: Mutex<PolicyState>,
}

struct PolicyState {
    policy: Box<dyn dragnet_search::policy::Policy + Send>,
    random: Stream,
}

/// The waypoint, the path to it, and the score of every cell.
type Decided<'py> = (i64, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<f64>>);

/// The observation of a robot, checked.
struct Observed {
    terrain: Terrain,
    belief: Belief,
    robot: Cell,
}

/// Names of all policies.
#[pyfunction]
pub(crate) fn policy_names() -> Vec<&'static str> {
    PolicyName::all().map(PolicyName::as_str).collect()
}

#[pymethods]
impl Policy {
    #[new]
    #[pyo3(signature = (name, scenario, weights, seed, robot))]
    fn new(
        name: &str,
        scenario: Option<&Scenario>,
        weights: Option<PathBuf>,
        seed: u64,
        robot: u16,
    ) -> PyResult<Self> {
        let name = name.parse::<PolicyName>().map_err(|error| PyValueError::new_err(error.to_string()))?;
        let scenario = scenario.map(Scenario::inner);
        let policy = match (weights, scenario) {
            (None, Some(scenario)) if scenario.robots()[0].policy.name == name => {
                scenario.robots()[0].policy.clone()
            }
            (None, _) => dragnet_scenario::Policy::from(name),
            (Some(weights), Some(scenario)) if name.as_str() == "gnn" => {
                let scenario = scenario.with_weights(&weights).map_err(|error| refused(&error))?;
                scenario.robots()[0].policy.clone()
            }
            (Some(_), _) => {
                return Err(PyValueError::new_err(
                    "weights without policy \"gnn\" and a scenario; allowed is with both only",
                ));
            }
        };
        let state = Mutex::new(PolicyState::new(&policy, seed, robot));
        Ok(Self { recipe: policy, scenario: scenario.cloned(), robot, state })
    }

    /// Restarts the policy with the random stream of a seed.
    fn reset(&self, seed: u64) -> PyResult<()> {
        let mut state = self.state.try_lock().map_err(|_| busy())?;
        *state = PolicyState::new(&self.recipe, seed, self.robot);
        Ok(())
    }

    /// The waypoint, the path to it, and the score of every cell, all by index.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn decide<'py>(
        &self,
        py: Python<'py>,
        log_odds: PyReadonlyArray2<'py, f64>,
        precision: PyReadonlyArray2<'py, f64>,
        weighted_sum: PyReadonlyArray2<'py, f64>,
        traversable: PyReadonlyArray2<'py, i8>,
        position: (i64, i64),
    ) -> PyResult<Decided<'py>> {
        let rows_and_columns = log_odds.as_array().dim();
        let flat = |array: PyReadonlyArray2<'py, f64>| array.as_array().iter().copied().collect::<Vec<f64>>();
        let open: Vec<bool> = traversable.as_array().iter().map(|&open| open != 0).collect();
        let evidence = evidence(&flat(precision), &flat(weighted_sum))?;
        let observed = self.observe(rows_and_columns, flat(log_odds), evidence, &open, position)?;
        let mut state = self.state.try_lock().map_err(|_| busy())?;
        let locked: &mut PolicyState = &mut state;
        let decision = py.detach(|| self.decide_in(locked, &observed));
        let path: Vec<i64> = decision.path.iter().map(|cell| i64::from(cell.number())).collect();
        Ok((i64::from(decision.chosen.number()), path.to_pyarray(py), decision.scores.to_pyarray(py)))
    }
}

impl Policy {
    fn decide_in(&self, state: &mut PolicyState, observed: &Observed) -> dragnet_search::policy::Decision {
        let usual = Sensor::default();
        let planned_precision = PlannedPrecision::nothing(&observed.terrain);
        let scenario = self.scenario.as_ref();
        let sensor = scenario.map_or(&usual, dragnet_scenario::Scenario::sensor);
        let Observed { terrain, belief, robot, .. } = observed;
        let mut situation = Situation::alone(terrain, sensor, belief, &planned_precision, *robot);
        if let Some(scenario) = scenario {
            situation.connectivity = scenario.connectivity();
            situation.detection_threshold = scenario.mission().detection_threshold;
        }
        state.policy.decide(&situation, &mut state.random)
    }

    fn observe(
        &self,
        (rows, columns): (usize, usize),
        log_odds: Vec<f64>,
        evidence: Vec<CellEvidence>,
        traversable: &[bool],
        (row, column): (i64, i64),
    ) -> PyResult<Observed> {
        let refuse = |message: String| PyValueError::new_err(message);
        let side = |cells: usize| u32::try_from(cells).unwrap_or(u32::MAX);
        let grid = Grid::new(side(rows), side(columns)).map_err(|error| refuse(error.to_string()))?;
        let robot = u32::try_from(row).ok().zip(u32::try_from(column).ok());
        let robot = robot.and_then(|(row, column)| grid.cell(Position { row, column })).ok_or_else(|| {
            refuse(format!("position ({row}, {column}) on a map of {rows} x {columns} cells"))
        })?;
        let evidence = Evidence::from_cells(evidence)
            .ok_or_else(|| refuse("precision below 0; allowed is at least 0".to_owned()))?;
        let (terrain, belief) = match &self.scenario {
            Some(scenario) if scenario.terrain().grid() == grid => {
                (scenario.terrain().clone(), scenario.prior().with_evidence(evidence))
            }
            Some(scenario) => {
                let map = scenario.terrain().grid();
                let expected = format!("{} x {}", map.rows(), map.columns());
                return Err(refuse(format!("{rows} x {columns} cells; the scenario's map has {expected}")));
            }
            None => {
                let ground = log_odds.iter().zip(traversable).map(|(&log_odds, &traversable)| Ground {
                    traversable,
                    searched: log_odds > f64::NEG_INFINITY,
                });
                let terrain = Terrain::new(grid, 1.0, ground.collect());
                let terrain = terrain.map_err(|error| refuse(error.to_string()))?;
                let gained = grid.cells().map(|cell| evidence.of(cell).log_likelihood_ratio_nats());
                let prior = log_odds.into_iter().zip(gained).map(|(now, gained)| now - gained).collect();
                let prior = Belief::from_log_odds(&terrain, prior);
                (terrain, prior.and_then(|prior| prior.with_evidence(evidence)))
            }
        };
        let belief = belief.map_err(|error| refuse(error.to_string()))?;
        if !terrain.is_traversable(robot) {
            return Err(refuse(format!("position ({row}, {column}): no robot can be in that cell")));
        }
        Ok(Observed { terrain, belief, robot })
    }
}

impl PolicyState {
    fn new(policy: &dragnet_scenario::Policy, seed: u64, robot: u16) -> Self {
        Self {
            policy: build(policy.name, policy.parameters, policy.network.as_ref()),
            random: stream(seed, Purpose::Decision, robot),
        }
    }
}

/// Evidence arrays, converted back to whole units.
#[expect(clippy::cast_possible_truncation, reason = "checked to be in range")]
fn evidence(precision: &[f64], weighted_sum: &[f64]) -> PyResult<Vec<CellEvidence>> {
    let units = |name: &str, cell: usize, value: f64| {
        let units = (value * UNITS).round();
        if units.abs() < MOST_UNITS {
            return Ok(units as i64);
        }
        let most = MOST_UNITS / UNITS;
        Err(PyValueError::new_err(format!(
            "{name} {value} of cell {cell}; allowed are numbers below {most:e}"
        )))
    };
    let cells = precision.iter().zip(weighted_sum).enumerate();
    cells
        .map(|(cell, (&precision, &weighted_sum))| {
            Ok(CellEvidence {
                precision: units("precision", cell, precision)?,
                weighted_sum: units("weighted_sum", cell, weighted_sum)?,
            })
        })
        .collect()
}

fn busy() -> PyErr {
    PyRuntimeError::new_err("another thread is asking this policy; allowed is one at a time")
}
