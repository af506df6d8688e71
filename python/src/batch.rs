//! Many searches of one robot each, stepped side by side.

use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_sim::single_robot_env::features::{Company, Layout};
use dragnet_sim::single_robot_env::{Control, Ended, Field, SingleRobotEnv, Terms};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions::{Actions, Actor};
use crate::arrays::{self, Arrays, Extent, ObservationBuffers};
use crate::choice;
use crate::lanes::{self, Lanes, expect_one_each, no_environment};
use crate::measures::{Measured, MeasuredRobot, Measures, Reason};
use crate::pool;
use crate::scenario::Scenario;

/// Searches that a thread steps together: one takes a microsecond or two.
const LEAST_TOGETHER: usize = 4;

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
    actions: Actions,
    terms: Terms,
    layout: Layout,
    arrays: Arrays,
    measures: Measures,
    lanes: Lanes<Lane>,
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
        let lanes = Lanes::new(num_envs)?;
        let field = scenario.field()?;
        let grid = field.scenario().terrain().grid();
        let actions = Actions::new(control, masked_action)?;
        let layout = choice::layout(observation, frame, Company::Alone, grid)?;
        Ok(Self {
            actions,
            terms: Terms { end: choice::end(end)?, reward: choice::reward(reward)? },
            arrays: Arrays::new(py, num_envs, &layout, field.action_count(actions.control))?,
            measures: Measures::new(py, num_envs, 1)?,
            lanes,
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
            actions: self.actions,
            terms: self.terms,
            layout: self.layout.clone(),
            arrays: self.arrays.copy(py)?,
            measures: self.measures.copy(py)?,
            lanes: Lanes::of(self.lanes.lock()?.clone()),
        })
    }

    /// What makes a search again: its seed, and the cell that each action led to, by index; -1 where the robot stayed.
    /// `None` before the first reset.
    fn history<'py>(
        &self,
        py: Python<'py>,
        place: usize,
    ) -> PyResult<Option<(u64, Bound<'py, PyArray1<i64>>)>> {
        let lanes = self.lanes.lock()?;
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
        let mut lanes = self.lanes.lock()?;
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
        let mut lanes = self.lanes.lock()?;
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
        let mut lanes = self.lanes.lock()?;
        let actions = expect_one_each("actions", actions.as_array().to_vec(), lanes.len())?;
        let seeds = match seeds {
            Some(seeds) => Some(expect_one_each("seeds", seeds.as_array().to_vec(), lanes.len())?),
            None => None,
        };
        let environment = |place| Some(place).filter(|_| lanes.len() > 1);
        let task = |place: usize| {
            let begin = seeds.as_ref().map(|seeds| Task::Begin { seed: seeds[place] });
            lanes::next(lanes[place].as_ref(), Lane::is_over, begin, |lane| {
                let actor = Actor { environment: environment(place), robot: None, from: lane.env.cell() };
                let to = self.actions.target(&self.field, actor, actions[place])?;
                Ok(to.map_or(Task::Wait, Task::Go))
            })
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
        self.of(place, |env| env.ended().map(|ended| reason(Some(ended)).as_str()))
    }
}

impl Batch {
    fn of<T>(&self, place: usize, read: impl FnOnce(&SingleRobotEnv) -> T) -> PyResult<T> {
        self.lanes.read(place, |lane| read(&lane.env))
    }

    /// Performs the task of each search, in parallel, and writes its arrays and measures.
    fn perform(&self, py: Python<'_>, lanes: &mut [Option<Lane>], tasks: &[Task]) -> PyResult<()> {
        let mut written = self.arrays.write(py)?;
        let buffers = written.buffers(lanes.len())?;
        let work = lanes.iter_mut().zip(buffers).zip(tasks).collect();
        let measured = pool::map(py, work, LEAST_TOGETHER, |((lane, mut buffer), &task)| {
            self.perform_one(lane, &mut buffer, task)
        });
        self.measures.write(py, &measured)
    }

    fn perform_one(
        &self,
        lane: &mut Option<Lane>,
        buffer: &mut ObservationBuffers<'_>,
        task: Task,
    ) -> Option<Measured<[MeasuredRobot; 1]>> {
        if let Task::Begin { seed } = task {
            let env = SingleRobotEnv::new(Arc::clone(&self.field), self.terms, seed);
            *lane = Some(Lane { env, seed, history: Vec::new(), kept: Vec::new() });
        }
        let Lane { env, history, kept, .. } = lane.as_mut()?;
        let control = self.actions.control;
        let reward = match (task, control) {
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
        buffer.draw(env, &self.field, &self.layout, control, extent, kept);
        let robot = MeasuredRobot { reward, reason: reason(env.ended()), path_cells: env.path_cells() };
        Some(Measured {
            is_new,
            f1: env.score().f1(),
            recall: env.score().recall(),
            time_seconds: env.now().as_seconds(),
            robots: [robot],
        })
    }
}

impl Lane {
    /// Whether it has told that it is over: after its first action at the earliest.
    fn is_over(&self) -> bool {
        self.env.ended().is_some() && !self.history.is_empty()
    }
}

const fn reason(ended: Option<Ended>) -> Reason {
    match ended {
        None => Reason::Searching,
        Some(Ended::Found) => Reason::Found,
        Some(Ended::Cleared) => Reason::Cleared,
        Some(Ended::Spent) => Reason::Spent,
    }
}

fn number(cell: Cell) -> i64 {
    i64::from(cell.number())
}
