//! One search of a team, stepped by one move of every robot at a time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::route::ShortestPathTree;
use dragnet_sim::single_robot_env::buffers::Control;
use dragnet_sim::single_robot_env::{Field, Reward};
use dragnet_sim::team_env::{Move, TeamEnv, TerminationReason};
use numpy::{PyArray1, PyArray3, PyReadonlyArray1, ToPyArray};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Arrays, borrow, slice};
use crate::batch::expect_one_each;
use crate::choice::{self, Masked};
use crate::scenario::Scenario;

/// Longer than any mission.
const MOST_SECONDS: f64 = 1e9;

/// A search of a scenario's team, and the arrays of each robot's belief.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct Team {
    field: Arc<Field>,
    control: Control,
    reward: Reward,
    masked: Masked,
    crashes: BTreeMap<RobotId, MissionTime>,
    arrays: Arrays,
    teammates: Py<PyArray3<i32>>,
    /// `None` before the first reset.
    search: Mutex<Option<TeamEnv>>,
}

#[pymethods]
impl Team {
    #[new]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn new(
        py: Python<'_>,
        scenario: &Scenario,
        control: &str,
        reward: &str,
        masked_action: &str,
        crashes: BTreeMap<u16, f64>,
    ) -> PyResult<Self> {
        let field = Arc::clone(&scenario.field);
        let robots = field.scenario().robots().len();
        let control = choice::control(control)?;
        let grid = field.scenario().terrain().grid();
        let actions = match control {
            Control::Waypoint => grid.cell_count(),
            Control::Step => field.step_count(),
        };
        let crash = |(&robot, &seconds): (&u16, &f64)| crash(robot, seconds, robots);
        Ok(Self {
            control,
            reward: choice::reward(reward)?,
            masked: choice::masked(masked_action)?,
            crashes: crashes.iter().map(crash).collect::<PyResult<_>>()?,
            arrays: Arrays::new(py, robots, grid, actions),
            teammates: PyArray3::zeros(py, (robots, robots, 2), false).unbind(),
            search: Mutex::new(None),
            field,
        })
    }

    /// All arrays, by name; they are written in place.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.arrays.dict(py)?;
        dict.set_item("teammates", &self.teammates)?;
        Ok(dict)
    }

    /// Starts the search of a seed.
    fn reset(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        let mut search = self.lock()?;
        let begun = py.detach(|| TeamEnv::new(Arc::clone(&self.field), self.reward, &self.crashes, seed));
        let begun = begun.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let begun = search.insert(begun);
        self.draw(py, begun)
    }

    /// Every robot that searches takes its action; those of others are ignored. Returns the team's reward.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn step(&self, py: Python<'_>, actions: PyReadonlyArray1<'_, i64>) -> PyResult<f64> {
        let mut search = self.lock()?;
        let search = search
            .as_mut()
            .ok_or_else(|| PyRuntimeError::new_err("step before the first reset; call reset first"))?;
        let robots = search.termination_reasons().len();
        let actions = expect_one_each("actions", actions.as_array().to_vec(), robots)?;
        if !search.termination_reasons().contains(&TerminationReason::Searching) {
            return Err(PyRuntimeError::new_err("step after the end of the episode; call reset first"));
        }
        let moves = (0..robots)
            .map(|place| self.wanted(search, place, actions[place]))
            .collect::<PyResult<Vec<Move>>>()?;
        let gain =
            py.detach(|| search.step(&moves)).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        self.draw(py, search)?;
        Ok(gain)
    }

    /// State of each robot: `"searching"`, `"found"`, `"spent"` or `"crashed"`.
    fn termination_reasons(&self) -> PyResult<Vec<&'static str>> {
        self.read(|search| {
            search
                .termination_reasons()
                .iter()
                .map(|fate| match fate {
                    TerminationReason::Searching => "searching",
                    TerminationReason::Found => "found",
                    TerminationReason::Spent => "spent",
                    TerminationReason::Crashed => "crashed",
                })
                .collect()
        })
    }

    /// F1 and recall of all that the team has observed, the path length of each robot (cells), and the time (seconds).
    fn measures(&self) -> PyResult<(f64, f64, Vec<f64>, f64)> {
        self.read(|search| {
            let paths =
                (0..search.termination_reasons().len()).map(|place| search.path_cells(place)).collect();
            (search.score().f1(), search.score().recall(), paths, search.now().as_seconds())
        })
    }

    /// Cells that hold an object, by index.
    fn objects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let objects = |search: &TeamEnv| -> Vec<i64> {
            search.truth().objects().iter().map(|cell| i64::from(cell.number())).collect()
        };
        self.read(|search| objects(search).to_pyarray(py))
    }

    /// Digests of each robot's belief, and of all that the team has observed.
    fn digests(&self) -> PyResult<(Vec<String>, String)> {
        self.read(|search| {
            let own = (0..search.termination_reasons().len())
                .map(|place| search.belief(place).digest().to_string());
            (own.collect(), search.merged().digest().to_string())
        })
    }
}

impl Team {
    fn lock(&self) -> PyResult<MutexGuard<'_, Option<TeamEnv>>> {
        self.search.try_lock().map_err(|_| {
            PyRuntimeError::new_err("another thread is stepping this environment; allowed is one at a time")
        })
    }

    fn read<T>(&self, read: impl FnOnce(&TeamEnv) -> T) -> PyResult<T> {
        let search = self.lock()?;
        search.as_ref().map(read).ok_or_else(|| PyRuntimeError::new_err("nothing before the first reset"))
    }

    /// The move that an action stands for.
    fn wanted(&self, search: &TeamEnv, place: usize, action: i64) -> PyResult<Move> {
        if search.termination_reasons()[place] != TerminationReason::Searching {
            return Ok(Move::Wait);
        }
        let from = search.cell(place);
        let to = usize::try_from(action).ok().and_then(|action| match self.control {
            Control::Step => self.field.neighbor(from, action),
            Control::Waypoint => self.toward(from, action),
        });
        match (to, self.masked) {
            (Some(to), _) => Ok(Move::To(to)),
            (None, Masked::Stay) if self.is_action(action) => Ok(Move::Wait),
            (None, _) => {
                let number = place + 1;
                let at = self.field.scenario().terrain().grid().position(from);
                Err(PyValueError::new_err(format!(
                    "robot_{number} at row {}, column {}: action {action}: the robot cannot go there; allowed are those \
                     whose action_mask is 1",
                    at.row, at.column
                )))
            }
        }
    }

    fn is_action(&self, action: i64) -> bool {
        let actions = match self.control {
            Control::Waypoint => self.field.scenario().terrain().grid().cell_count(),
            Control::Step => self.field.step_count(),
        };
        usize::try_from(action).is_ok_and(|action| action < actions)
    }

    /// The first cell on the shortest path to a cell.
    fn toward(&self, from: Cell, to: usize) -> Option<Cell> {
        let scenario = self.field.scenario();
        let to = u32::try_from(to).ok().and_then(|number| scenario.terrain().grid().cell_numbered(number))?;
        ShortestPathTree::from(scenario.terrain(), scenario.connectivity(), from).path(to).first().copied()
    }

    fn draw(&self, py: Python<'_>, search: &TeamEnv) -> PyResult<()> {
        let robots = search.termination_reasons().len();
        let grid = self.field.scenario().terrain().grid();
        let mut written = self.arrays.write(py)?;
        let mut teammates = borrow(self.teammates.bind(py))?;
        let mut buffers = written.buffers(robots)?;
        for (place, buffer) in buffers.iter_mut().enumerate() {
            buffer.draw_belief(search.belief(place), grid.cells());
            buffer.draw_robot(&self.field, search.cell(place), self.control);
        }
        for (index, at) in slice(&mut teammates)?.chunks_exact_mut(2).enumerate() {
            let received = search.received(index / robots, index % robots).map(|cell| grid.position(cell));
            let whole = |number: u32| i32::try_from(number).unwrap_or(i32::MAX);
            at.copy_from_slice(
                &received.map_or([-1, -1], |received| [whole(received.row), whole(received.column)]),
            );
        }
        Ok(())
    }
}

fn crash(robot: u16, seconds: f64, robots: usize) -> PyResult<(RobotId, MissionTime)> {
    let named = RobotId::new(robot).filter(|robot| robot.index() < robots).ok_or_else(|| {
        PyValueError::new_err(format!(
            "crashes: robot {robot}; allowed are the robots' numbers, 1 to {robots}"
        ))
    })?;
    if !(0.0..=MOST_SECONDS).contains(&seconds) {
        return Err(PyValueError::new_err(format!(
            "crashes: {seconds} seconds for robot {robot}; allowed are 0 to {MOST_SECONDS:e}"
        )));
    }
    Ok((named, MissionTime::START + Duration::from_secs_f64(seconds)))
}
