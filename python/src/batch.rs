//! Many searches of one robot each, stepped side by side.

use std::sync::{Arc, Mutex, MutexGuard};

use dragnet_search::cell::Cell;
use dragnet_sim::single_robot_env::features::{Company, Layout};
use dragnet_sim::single_robot_env::{Control, Ended, Field, SingleRobotEnv, Terms};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use crate::arrays::{self, Arrays, Extent, ObservationBuffers, borrow, column, slice};
use crate::choice::{self, Masked};
use crate::pool;
use crate::scenario::Scenario;

/// An environment and its buffers, its task, and the result.
type Work<'a, 'b> =
    ((&'a mut Option<Lane>, &'a mut ObservationBuffers<'b>), (&'a Task, &'a mut Option<Measured>));

/// A search, and all that makes it again.
#[derive(Clone)]
struct Lane {
    env: SingleRobotEnv,
    seed: u64,
    /// The cell that each action led to, by number, or [`STAYED`].
    history: Vec<i64>,
    /// The map's frame of what is observed in the robot's.
    kept: Vec<f32>,
}

/// In place of a cell in a history.
const STAYED: i64 = -1;

/// Searches of one scenario, each with its own seed, and their arrays.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct Batch {
    field: Arc<Field>,
    control: Control,
    terms: Terms,
    masked: Masked,
    layout: Layout,
    arrays: Arrays,
    measures: Measures,
    /// `None` before the first reset.
    lanes: Mutex<Vec<Option<Lane>>>,
}

/// A number for each search.
struct Measures {
    reward: Py<PyArray1<f64>>,
    terminated: Py<PyArray1<bool>>,
    truncated: Py<PyArray1<bool>>,
    f1: Py<PyArray1<f64>>,
    recall: Py<PyArray1<f64>>,
    path_cells: Py<PyArray1<f64>>,
    time_seconds: Py<PyArray1<f64>>,
}

/// The next step of a search.
#[derive(Clone, Copy)]
enum Task {
    /// Start a new episode.
    Begin { seed: u64 },
    /// Go to a cell.
    Go(Cell),
    /// Stay.
    Wait,
    /// Leave the search unchanged.
    Keep,
}

/// The measures of a search after a task.
#[derive(Clone, Copy)]
struct Measured {
    reward: f64,
    terminated: bool,
    truncated: bool,
    f1: f64,
    recall: f64,
    path_cells: f64,
    time_seconds: f64,
}

#[pymethods]
impl Batch {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "named in the package, each checked")]
    fn new(
        py: Python<'_>,
        scenario: &Scenario,
        num_envs: usize,
        control: &str,
        reward: &str,
        end: &str,
        masked_action: &str,
        observation: &str,
        frame: &str,
    ) -> PyResult<Self> {
        let robots = scenario.inner().robots().len();
        if robots != 1 {
            return Err(PyValueError::new_err(format!(
                "{} has {robots} robots; allowed is 1 here, teams are searches of dragnet.parallel_env",
                scenario.inner().name()
            )));
        }
        if num_envs == 0 {
            return Err(PyValueError::new_err("num_envs=0; allowed is at least 1"));
        }
        let field = Arc::clone(&scenario.field);
        let grid = field.scenario().terrain().grid();
        let control = choice::control(control)?;
        let layout = choice::layout(observation, frame, Company::Alone, grid)?;
        Ok(Self {
            control,
            terms: Terms { end: choice::end(end)?, reward: choice::reward(reward)? },
            masked: choice::masked(masked_action)?,
            arrays: Arrays::new(py, num_envs, &layout, field.action_count(control)),
            measures: Measures::new(py, num_envs),
            lanes: Mutex::new((0..num_envs).map(|_| None).collect()),
            layout,
            field,
        })
    }

    /// All arrays, by name; they are written in place.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.arrays.dict(py)?;
        self.measures.add_to(&dict)?;
        Ok(dict)
    }

    /// Names of the features, in their order.
    fn features(&self) -> Vec<&'static str> {
        self.layout.features().iter().map(|feature| feature.as_str()).collect()
    }

    /// The exact belief of a search, in new arrays.
    fn belief<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyDict>> {
        self.of(place, |env| arrays::belief(py, &self.field, &env.view()))?
    }

    /// Other searches with the same future, and arrays of their own.
    #[pyo3(name = "clone")]
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self {
            field: Arc::clone(&self.field),
            control: self.control,
            terms: self.terms,
            masked: self.masked,
            layout: self.layout.clone(),
            arrays: self.arrays.copy(py)?,
            measures: self.measures.copy(py)?,
            lanes: Mutex::new(self.lock()?.clone()),
        })
    }

    /// What makes a search again: its seed, and the cell that each action led to, by index; -1 where the robot stayed.
    /// `None` before the first reset.
    fn history<'py>(
        &self,
        py: Python<'py>,
        place: usize,
    ) -> PyResult<Option<(u64, Bound<'py, PyArray1<i64>>)>> {
        let lanes = self.lock()?;
        let lane = lanes.get(place).ok_or_else(|| no_environment(place))?;
        Ok(lane.as_ref().map(|lane| (lane.seed, lane.history.to_pyarray(py))))
    }

    /// Makes a search again.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn replay(
        &self,
        py: Python<'_>,
        place: usize,
        seed: u64,
        history: PyReadonlyArray1<'_, i64>,
    ) -> PyResult<()> {
        let mut lanes = self.lock()?;
        if place >= lanes.len() {
            return Err(no_environment(place));
        }
        let mut tasks = vec![Task::Keep; lanes.len()];
        tasks[place] = Task::Begin { seed };
        self.perform(py, &mut lanes, &tasks)?;
        let grid = self.field.scenario().terrain().grid();
        for (step, &number) in history.as_array().iter().enumerate() {
            let cell = u32::try_from(number).ok().and_then(|number| grid.cell_numbered(number));
            tasks[place] = match cell {
                Some(cell) => Task::Go(cell),
                None if number == STAYED => Task::Wait,
                None => {
                    return Err(PyValueError::new_err(format!(
                        "cell {number} of step {step}: not on the map"
                    )));
                }
            };
            self.perform(py, &mut lanes, &tasks)?;
        }
        Ok(())
    }

    /// Starts new episodes in the searches of the mask.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn reset(
        &self,
        py: Python<'_>,
        seeds: PyReadonlyArray1<'_, u64>,
        mask: PyReadonlyArray1<'_, bool>,
    ) -> PyResult<()> {
        let mut lanes = self.lock()?;
        let seeds = expect_one_each("seeds", seeds.as_array().to_vec(), lanes.len())?;
        let mask = expect_one_each("mask", mask.as_array().to_vec(), lanes.len())?;
        let task = |(seed, begins)| if begins { Task::Begin { seed } } else { Task::Keep };
        let tasks: Vec<Task> = seeds.into_iter().zip(mask).map(task).collect();
        self.perform(py, &mut lanes, &tasks)
    }

    /// Takes one action in each search. With seeds, searches that are over start a new episode instead, and their
    /// action is ignored.
    #[pyo3(signature = (actions, seeds=None))]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray1<'_, i64>,
        seeds: Option<PyReadonlyArray1<'_, u64>>,
    ) -> PyResult<()> {
        let mut lanes = self.lock()?;
        let actions = expect_one_each("actions", actions.as_array().to_vec(), lanes.len())?;
        let seeds = match seeds {
            Some(seeds) => Some(expect_one_each("seeds", seeds.as_array().to_vec(), lanes.len())?),
            None => None,
        };
        let is_over = self.over(py)?;
        let task = |place: usize| match (&lanes[place], is_over[place], &seeds) {
            (None, ..) => Err(PyRuntimeError::new_err("step before the first reset; call reset first")),
            (Some(_), true, Some(seeds)) => Ok(Task::Begin { seed: seeds[place] }),
            (Some(_), true, None) => {
                Err(PyRuntimeError::new_err("step after the end of the episode; call reset first"))
            }
            (Some(lane), false, _) => self.task(place, &lane.env, actions[place]),
        };
        let tasks = (0..lanes.len()).map(task).collect::<PyResult<Vec<Task>>>()?;
        self.perform(py, &mut lanes, &tasks)
    }

    /// Every cell that a robot was in, by index, in order from its start.
    fn track<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.of(place, |env| env.track().iter().map(|&cell| number(cell)).collect::<Vec<_>>().to_pyarray(py))
    }

    /// Cells that hold an object, by index.
    fn objects<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let objects = |env: &SingleRobotEnv| -> Vec<i64> {
            env.truth().objects().iter().map(|&it| number(it)).collect()
        };
        self.of(place, |env| objects(env).to_pyarray(py))
    }

    /// Digest of all evidence, 32 hexadecimal digits.
    fn digest(&self, place: usize) -> PyResult<String> {
        self.of(place, |env| env.belief().digest().to_string())
    }

    /// Why a search is over.
    fn termination_reason(&self, place: usize) -> PyResult<Option<&'static str>> {
        self.of(place, |env| {
            env.ended().map(|ended| match ended {
                Ended::Found => "found",
                Ended::Cleared => "cleared",
                Ended::Spent => "spent",
            })
        })
    }
}

impl Batch {
    /// Locks the searches.
    fn lock(&self) -> PyResult<MutexGuard<'_, Vec<Option<Lane>>>> {
        self.lanes.try_lock().map_err(|_| {
            PyRuntimeError::new_err("another thread is stepping this environment; allowed is one at a time")
        })
    }

    fn of<T>(&self, place: usize, read: impl FnOnce(&SingleRobotEnv) -> T) -> PyResult<T> {
        let lanes = self.lock()?;
        let lane = lanes.get(place).ok_or_else(|| no_environment(place))?;
        let lane = lane.as_ref().ok_or_else(|| PyRuntimeError::new_err("nothing before the first reset"))?;
        Ok(read(&lane.env))
    }

    /// Whether each search has reported that it is over.
    fn over(&self, py: Python<'_>) -> PyResult<Vec<bool>> {
        let mut terminated = borrow(self.measures.terminated.bind(py))?;
        let mut truncated = borrow(self.measures.truncated.bind(py))?;
        let (terminated, truncated) = (slice(&mut terminated)?, slice(&mut truncated)?);
        Ok(terminated
            .iter()
            .zip(truncated)
            .map(|(&terminated, &mut truncated)| terminated || truncated)
            .collect())
    }

    /// The task that an action stands for.
    fn task(&self, place: usize, env: &SingleRobotEnv, action: i64) -> PyResult<Task> {
        let from = env.cell();
        let to = usize::try_from(action).ok().and_then(|it| self.field.target(self.control, from, it));
        match (to, self.masked) {
            (Some(to), _) => Ok(Task::Go(to)),
            (None, Masked::Stay) if self.is_action(action) => Ok(Task::Wait),
            (None, _) => Err(self.refuse(place, from, action)),
        }
    }

    fn is_action(&self, action: i64) -> bool {
        usize::try_from(action).is_ok_and(|action| action < self.field.action_count(self.control))
    }

    fn refuse(&self, place: usize, from: Cell, action: i64) -> PyErr {
        let at = self.field.scenario().terrain().grid().position(from);
        let what = if self.is_action(action) {
            "it is masked: the robot cannot get there".to_owned()
        } else {
            format!("no such action: they are 0 to {}", self.field.action_count(self.control) - 1)
        };
        PyValueError::new_err(format!(
            "environment {place}, robot at row {}, column {}: action {action}: {what}; allowed are those whose \
             action_mask is 1",
            at.row, at.column
        ))
    }

    /// Performs the task of each search, in parallel, and writes its arrays and measures.
    fn perform(&self, py: Python<'_>, lanes: &mut [Option<Lane>], tasks: &[Task]) -> PyResult<()> {
        let mut measured = vec![None; lanes.len()];
        let threads = if lanes.len() > 1 { pool::threads(py) } else { None };
        let mut written = self.arrays.write(py)?;
        let mut buffers = written.buffers(lanes.len())?;
        py.detach(|| {
            let work = |((lane, buffer), (task, measured)): Work<'_, '_>| {
                *measured = self.perform_one(lane, buffer, *task);
            };
            if let Some(threads) = threads {
                threads.install(|| {
                    let seen = lanes.par_iter_mut().zip(buffers.par_iter_mut());
                    seen.zip(tasks.par_iter().zip(measured.par_iter_mut())).with_min_len(4).for_each(work);
                });
            } else {
                let seen = lanes.iter_mut().zip(buffers.iter_mut());
                seen.zip(tasks.iter().zip(&mut measured)).for_each(work);
            }
        });
        self.measures.write(py, &measured)
    }

    fn perform_one(
        &self,
        lane: &mut Option<Lane>,
        buffer: &mut ObservationBuffers<'_>,
        task: Task,
    ) -> Option<Measured> {
        if let Task::Begin { seed } = task {
            let env = SingleRobotEnv::new(Arc::clone(&self.field), self.terms, seed);
            *lane = Some(Lane { env, seed, history: Vec::new(), kept: Vec::new() });
        }
        let Lane { env, history, kept, .. } = lane.as_mut()?;
        let reward = match (task, self.control) {
            (Task::Go(cell), Control::Waypoint) => env.go(cell),
            (Task::Go(cell), Control::Step) => env.step(cell),
            (Task::Wait, _) => env.wait(),
            (Task::Begin { .. }, _) => 0.0,
            (Task::Keep, _) => return None,
        };
        match task {
            Task::Go(cell) => history.push(number(cell)),
            Task::Wait => history.push(STAYED),
            Task::Begin { .. } | Task::Keep => {}
        }
        let is_new = matches!(task, Task::Begin { .. });
        let extent = if is_new { Extent::All } else { Extent::Changes };
        buffer.draw_env(env, &self.layout, self.control, extent, kept);
        Some(Measured {
            reward,
            // A search that is over when it begins reports this after its first action.
            terminated: !is_new && matches!(env.ended(), Some(Ended::Found | Ended::Cleared)),
            truncated: !is_new && env.ended() == Some(Ended::Spent),
            f1: env.score().f1(),
            recall: env.score().recall(),
            path_cells: env.path_cells(),
            time_seconds: env.now().as_seconds(),
        })
    }
}

impl Measures {
    fn new(py: Python<'_>, searches: usize) -> Self {
        Self {
            reward: column(py, searches),
            terminated: column(py, searches),
            truncated: column(py, searches),
            f1: column(py, searches),
            recall: column(py, searches),
            path_cells: column(py, searches),
            time_seconds: column(py, searches),
        }
    }

    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self {
            reward: arrays::copy(self.reward.bind(py))?,
            terminated: arrays::copy(self.terminated.bind(py))?,
            truncated: arrays::copy(self.truncated.bind(py))?,
            f1: arrays::copy(self.f1.bind(py))?,
            recall: arrays::copy(self.recall.bind(py))?,
            path_cells: arrays::copy(self.path_cells.bind(py))?,
            time_seconds: arrays::copy(self.time_seconds.bind(py))?,
        })
    }

    fn add_to(&self, dict: &Bound<'_, PyDict>) -> PyResult<()> {
        dict.set_item("reward", &self.reward)?;
        dict.set_item("terminated", &self.terminated)?;
        dict.set_item("truncated", &self.truncated)?;
        dict.set_item("f1", &self.f1)?;
        dict.set_item("recall", &self.recall)?;
        dict.set_item("path_cells", &self.path_cells)?;
        dict.set_item("time_seconds", &self.time_seconds)
    }

    fn write(&self, py: Python<'_>, measured: &[Option<Measured>]) -> PyResult<()> {
        fill(py, &self.reward, measured, |it| it.reward)?;
        fill(py, &self.terminated, measured, |it| it.terminated)?;
        fill(py, &self.truncated, measured, |it| it.truncated)?;
        fill(py, &self.f1, measured, |it| it.f1)?;
        fill(py, &self.recall, measured, |it| it.recall)?;
        fill(py, &self.path_cells, measured, |it| it.path_cells)?;
        fill(py, &self.time_seconds, measured, |it| it.time_seconds)
    }
}

fn fill<T: numpy::Element>(
    py: Python<'_>,
    column: &Py<PyArray1<T>>,
    measured: &[Option<Measured>],
    value: impl Fn(&Measured) -> T,
) -> PyResult<()> {
    let mut column = borrow(column.bind(py))?;
    for (place, measured) in slice(&mut column)?.iter_mut().zip(measured) {
        if let Some(measured) = measured {
            *place = value(measured);
        }
    }
    Ok(())
}

fn no_environment(place: usize) -> PyErr {
    PyValueError::new_err(format!("no environment {place}"))
}

fn number(cell: Cell) -> i64 {
    i64::from(cell.number())
}

/// Returns the list if it has one entry for each search.
pub(crate) fn expect_one_each<T>(name: &str, list: Vec<T>, count: usize) -> PyResult<Vec<T>> {
    if list.len() == count {
        return Ok(list);
    }
    Err(PyValueError::new_err(format!("{name} of length {}; allowed is {count}, one each", list.len())))
}
