//! One search of a team, stepped by one move of every robot at a time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::route::ShortestPathTree;
use dragnet_sim::single_robot_env::features::{Company, Frame, Layout, Order, View};
use dragnet_sim::single_robot_env::{Control, Field, Reward};
use dragnet_sim::team_env::{Move, TeamEnv, TerminationReason};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, Arrays};
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
    layout: Layout,
    arrays: Arrays,
    /// `None` before the first reset.
    search: Mutex<Option<Search>>,
}

/// A search, and all that makes it again.
struct Search {
    env: TeamEnv,
    seed: u64,
    /// The action of each robot in each step.
    history: Vec<i64>,
}

#[pymethods]
impl Team {
    #[new]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    #[expect(clippy::too_many_arguments, reason = "named in the package, each checked")]
    fn new(
        py: Python<'_>,
        scenario: &Scenario,
        control: &str,
        reward: &str,
        masked_action: &str,
        observation: &str,
        frame: &str,
        crashes: BTreeMap<u16, f64>,
    ) -> PyResult<Self> {
        let field = Arc::clone(&scenario.field);
        let robots = field.scenario().robots().len();
        let control = choice::control(control)?;
        let grid = field.scenario().terrain().grid();
        let layout = choice::layout(observation, frame, Company::Team, grid)?;
        let crash = |(&robot, &seconds): (&u16, &f64)| crash(robot, seconds, robots);
        Ok(Self {
            control,
            reward: choice::reward(reward)?,
            masked: choice::masked(masked_action)?,
            crashes: crashes.iter().map(crash).collect::<PyResult<_>>()?,
            arrays: Arrays::new(py, robots, &layout, field.action_count(control)),
            search: Mutex::new(None),
            layout,
            field,
        })
    }

    /// All arrays, by name; they are written in place.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.arrays.dict(py)
    }

    /// Names of the features, in their order.
    fn features(&self) -> Vec<&'static str> {
        self.layout.features().iter().map(|feature| feature.as_str()).collect()
    }

    /// The exact belief of a robot, by its index in the team; of all together without one. In new arrays.
    #[pyo3(signature = (place=None))]
    fn belief<'py>(&self, py: Python<'py>, place: Option<usize>) -> PyResult<Bound<'py, PyDict>> {
        self.read(|env| {
            let belief = place.map_or(env.merged(), |place| env.belief(place));
            arrays::belief(py, &self.field, &View { belief, ..self.view(env, place.unwrap_or(0), &[]) })
        })?
    }

    /// Features of all that the team has observed, shape `[features, cells]`: those of cells, the distance last, which is
    /// that from the first robot.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let grid = self.field.scenario().terrain().grid();
        let layout = Layout::new(Order::Named, Frame::Map, Company::Alone, grid);
        let mut numbers = vec![0.0; layout.len()];
        self.read(|env| {
            let view = View { belief: env.merged(), ..self.view(env, 0, &[]) };
            layout.draw(&self.field, &view, &mut numbers);
        })?;
        PyArray1::from_vec(py, numbers).reshape([layout.features().len(), grid.cell_count()])
    }

    /// The cell of each robot, by index.
    fn cells(&self) -> PyResult<Vec<i64>> {
        self.read(|env| {
            (0..env.termination_reasons().len()).map(|place| i64::from(env.cell(place).number())).collect()
        })
    }

    /// What makes the search again: its seed, and the action of each robot in each step. `None` before the first reset.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Option<(u64, Bound<'py, PyArray2<i64>>)>> {
        let search = self.lock()?;
        let Some(search) = search.as_ref() else { return Ok(None) };
        let robots = search.env.termination_reasons().len();
        let steps = search.history.len() / robots;
        let history = PyArray1::from_slice(py, &search.history).reshape([steps, robots])?;
        Ok(Some((search.seed, history)))
    }

    /// Makes a search again.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn replay(&self, py: Python<'_>, seed: u64, history: PyReadonlyArray2<'_, i64>) -> PyResult<()> {
        self.reset(py, seed)?;
        let mut search = self.lock()?;
        if let Some(search) = search.as_mut() {
            for actions in history.as_array().rows() {
                self.advance(py, search, actions.to_vec())?;
            }
            self.draw(py, &search.env)?;
        }
        Ok(())
    }

    /// Starts the search of a seed.
    fn reset(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        let mut search = self.lock()?;
        let begun = py.detach(|| TeamEnv::new(Arc::clone(&self.field), self.reward, &self.crashes, seed));
        let env = begun.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let begun = search.insert(Search { env, seed, history: Vec::new() });
        self.draw(py, &begun.env)
    }

    /// Every robot that searches takes its action; those of others are ignored. Returns the team's reward.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn step(&self, py: Python<'_>, actions: PyReadonlyArray1<'_, i64>) -> PyResult<f64> {
        let mut search = self.lock()?;
        let search = search
            .as_mut()
            .ok_or_else(|| PyRuntimeError::new_err("step before the first reset; call reset first"))?;
        let gain = self.advance(py, search, actions.as_array().to_vec())?;
        self.draw(py, &search.env)?;
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
    fn lock(&self) -> PyResult<MutexGuard<'_, Option<Search>>> {
        self.search.try_lock().map_err(|_| {
            PyRuntimeError::new_err("another thread is stepping this environment; allowed is one at a time")
        })
    }

    fn read<T>(&self, read: impl FnOnce(&TeamEnv) -> T) -> PyResult<T> {
        let search = self.lock()?;
        let search =
            search.as_ref().ok_or_else(|| PyRuntimeError::new_err("nothing before the first reset"))?;
        Ok(read(&search.env))
    }

    fn advance(&self, py: Python<'_>, search: &mut Search, actions: Vec<i64>) -> PyResult<f64> {
        let Search { env, history, .. } = search;
        let robots = env.termination_reasons().len();
        let actions = expect_one_each("actions", actions, robots)?;
        if !env.termination_reasons().contains(&TerminationReason::Searching) {
            return Err(PyRuntimeError::new_err("step after the end of the episode; call reset first"));
        }
        let moves = (0..robots)
            .map(|place| self.wanted(env, place, actions[place]))
            .collect::<PyResult<Vec<Move>>>()?;
        let gain =
            py.detach(|| env.step(&moves)).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        history.extend(actions);
        Ok(gain)
    }

    fn view<'a>(&self, env: &'a TeamEnv, place: usize, teammates: &'a [Cell]) -> View<'a> {
        View {
            belief: env.belief(place),
            robot: env.cell(place),
            budget: self.field.budget(env.remaining_meters(place)),
            teammates,
        }
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
        usize::try_from(action).is_ok_and(|action| action < self.field.action_count(self.control))
    }

    /// The first cell on the shortest path to a cell.
    fn toward(&self, from: Cell, to: usize) -> Option<Cell> {
        let scenario = self.field.scenario();
        let to = u32::try_from(to).ok().and_then(|number| scenario.terrain().grid().cell_numbered(number))?;
        ShortestPathTree::from(scenario.terrain(), scenario.connectivity(), from).path(to).first().copied()
    }

    fn draw(&self, py: Python<'_>, env: &TeamEnv) -> PyResult<()> {
        let robots = env.termination_reasons().len();
        let mut written = self.arrays.write(py)?;
        for (place, buffer) in written.buffers(robots)?.iter_mut().enumerate() {
            let others = (0..robots).filter(|&other| other != place);
            let teammates: Vec<Cell> = others.filter_map(|other| env.received(place, other)).collect();
            let view = self.view(env, place, &teammates);
            buffer.draw_view(&self.field, &self.layout, self.control, &view);
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
