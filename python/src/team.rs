//! Many searches of a team each, stepped side by side by one move of every robot at a time.

mod known;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::state_machine::ParticipantError;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_sim::single_robot_env::features::{Company, Layout};
use dragnet_sim::single_robot_env::{Control, Field, Reward};
use dragnet_sim::team_env::{Move, TeamEnv, TerminationReason};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::actions::{Actions, Actor};
use crate::arrays::{self, Arrays, Extent, Member, ObservationBuffers};
use crate::choice;
use crate::lanes::{self, Lanes, expect_one_each, no_environment};
use crate::measures::{Measured, MeasuredRobot, Measures, Reason};
use crate::pool;
use crate::scenario::Scenario;
use known::Known;

/// Longer than any mission.
const MOST_SECONDS: f64 = 1e9;
/// Searches that a thread steps together: a team takes some ten microseconds.
const LEAST_TOGETHER: usize = 1;

/// Searches of a scenario's team, each with its own seed, and their arrays, which have a part for every robot of the first
/// search, then of the second, and so on.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct TeamBatch {
    field: Arc<Field>,
    /// Size of a team.
    robots: usize,
    actions: Actions,
    reward: Reward,
    crashes: BTreeMap<RobotId, MissionTime>,
    layout: Layout,
    arrays: Arrays,
    measures: Measures,
    known: Known,
    lanes: Lanes<Lane>,
}

/// A search, and all that makes it again.
struct Lane {
    env: TeamEnv,
    seed: u64,
    /// The action of each robot in each step.
    history: Vec<i64>,
    /// Of each robot the map's frame of what is observed in its own.
    kept: Vec<Vec<f32>>,
    /// Whether what changed since the last drawing is all that has to be drawn.
    is_drawn: bool,
    /// The same of what the team knows.
    is_known_drawn: bool,
}

/// The next step of a search.
enum Task {
    /// Start a new episode.
    Begin { seed: u64 },
    /// Each robot takes its action, which leads to a cell, or lets it stay.
    Act { actions: Vec<i64>, targets: Vec<Option<Cell>> },
    /// Leave the search unchanged.
    Keep,
}

type MeasuredTeam = Measured<Vec<MeasuredRobot>>;

#[pymethods]
impl TeamBatch {
    #[new]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    #[expect(clippy::too_many_arguments, reason = "named in the package, each checked")]
    fn new(
        py: Python<'_>,
        scenario: &Scenario,
        num_envs: usize,
        control: &str,
        reward: &str,
        masked_action: &str,
        observation: &str,
        frame: &str,
        crashes: BTreeMap<u16, f64>,
    ) -> PyResult<Self> {
        let lanes = Lanes::new(num_envs)?;
        let field = scenario.field()?;
        let robots = field.scenario().robots().len();
        let actions = Actions::new(control, masked_action)?;
        let grid = field.scenario().terrain().grid();
        let layout = choice::layout(observation, frame, Company::Team, grid)?;
        let crash = |(&robot, &seconds): (&u16, &f64)| crash(robot, seconds, robots);
        Ok(Self {
            robots,
            reward: choice::reward(reward)?,
            crashes: crashes.iter().map(crash).collect::<PyResult<_>>()?,
            arrays: Arrays::new(py, num_envs * robots, &layout, field.action_count(actions.control))?,
            measures: Measures::new(py, num_envs, robots)?,
            known: Known::new(py, num_envs, robots, Layout::of_team(grid))?,
            lanes,
            layout,
            actions,
            field,
        })
    }

    /// All arrays, by name; they are written in place. `state` is written by [`TeamBatch::state`] alone.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = self.arrays.dict(py)?;
        self.measures.add_to(&dict)?;
        dict.set_item("state", &self.known.numbers)?;
        Ok(dict)
    }

    /// Names of the features, in their order.
    fn features(&self) -> Vec<&'static str> {
        self.layout.features().iter().map(|feature| feature.as_str()).collect()
    }

    /// The exact belief of a robot, in new arrays.
    fn belief<'py>(&self, py: Python<'py>, place: usize, robot: usize) -> PyResult<Bound<'py, PyDict>> {
        self.of(place, |env| arrays::belief(py, &self.field, &env.view(robot, &[])))?
    }

    /// Writes what the team of each search knows.
    fn state(&self, py: Python<'_>) -> PyResult<()> {
        let mut lanes = self.lanes.lock()?;
        let begun = lanes.iter_mut().map(|lane| {
            lane.as_mut()
                .ok_or_else(|| PyRuntimeError::new_err("state before the first reset; call reset first"))
        });
        let begun = begun.collect::<PyResult<Vec<&mut Lane>>>()?;
        self.known.write(py, begun)
    }

    /// What makes a search again: its seed, and the action of each robot in each step. `None` before the first reset.
    fn history<'py>(
        &self,
        py: Python<'py>,
        place: usize,
    ) -> PyResult<Option<(u64, Bound<'py, PyArray2<i64>>)>> {
        let lanes = self.lanes.lock()?;
        let Some(lane) = lanes.get(place).ok_or_else(|| no_environment(place))? else { return Ok(None) };
        let steps = lane.history.len() / self.robots;
        let history = PyArray1::from_slice(py, &lane.history).reshape([steps, self.robots])?;
        Ok(Some((lane.seed, history)))
    }

    /// Makes a search again.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn replay(
        &self,
        py: Python<'_>,
        place: usize,
        seed: u64,
        history: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<()> {
        let mut lanes = self.lanes.lock()?;
        let count = lanes.len();
        let lane = lanes.get_mut(place).ok_or_else(|| no_environment(place))?;
        let mut measured = self.advance(lane, Task::Begin { seed }).map_err(|error| failed(&error))?;
        for actions in history.as_array().rows() {
            let Some(begun) = lane.as_ref() else { break };
            let actions = expect_one_each("actions", actions.to_vec(), self.robots)?;
            let targets = self.targets(begun, None, &actions)?;
            measured = self.advance(lane, Task::Act { actions, targets }).map_err(|error| failed(&error))?;
        }
        let mut written = self.arrays.write(py)?;
        let mut buffers = written.buffers(count * self.robots)?;
        if let Some(lane) = lane {
            self.draw(lane, &mut buffers[place * self.robots..][..self.robots]);
        }
        let measured: Vec<Option<MeasuredTeam>> =
            (0..count).map(|it| if it == place { measured.take() } else { None }).collect();
        self.measures.write(py, &measured)
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
        self.perform(py, &mut lanes, seeds.into_iter().zip(mask).map(task).collect())
    }

    /// Each robot that searches takes its action, the robots of the first search first; those of others are ignored. With
    /// seeds, searches that are over start a new episode instead.
    #[pyo3(signature = (actions, seeds=None))]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray1<'_, i64>,
        seeds: Option<PyReadonlyArray1<'_, u64>>,
    ) -> PyResult<()> {
        let mut lanes = self.lanes.lock()?;
        let actions = expect_one_each("actions", actions.as_array().to_vec(), lanes.len() * self.robots)?;
        let seeds = match seeds {
            Some(seeds) => Some(expect_one_each("seeds", seeds.as_array().to_vec(), lanes.len())?),
            None => None,
        };
        let environment = |place| Some(place).filter(|_| lanes.len() > 1);
        // No search moves before all actions are known to be possible.
        let tasks = lanes.iter().zip(actions.chunks_exact(self.robots)).enumerate();
        let tasks = tasks.map(|(place, (lane, actions))| {
            let begin = seeds.as_ref().map(|seeds| Task::Begin { seed: seeds[place] });
            lanes::next(lane.as_ref(), Lane::is_over, begin, |lane| {
                let targets = self.targets(lane, environment(place), actions)?;
                Ok(Task::Act { actions: actions.to_vec(), targets })
            })
        });
        let tasks = tasks.collect::<PyResult<Vec<Task>>>()?;
        self.perform(py, &mut lanes, tasks)
    }

    /// The cell of each robot, by index.
    fn cells(&self, place: usize) -> PyResult<Vec<i64>> {
        self.of(place, |env| (0..self.robots).map(|robot| i64::from(env.cell(robot).number())).collect())
    }

    /// Every cell that each robot was in, by index, in order from its start.
    fn tracks<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Vec<Bound<'py, PyArray1<i64>>>> {
        self.of(place, |env| (0..self.robots).map(|robot| numbers(env.track(robot)).to_pyarray(py)).collect())
    }

    /// Cells that hold an object, by index.
    fn objects<'py>(&self, py: Python<'py>, place: usize) -> PyResult<Bound<'py, PyArray1<i64>>> {
        self.of(place, |env| numbers(env.truth().objects()).to_pyarray(py))
    }

    /// Digests of each robot's belief, and of all that the team has observed.
    fn digests(&self, place: usize) -> PyResult<(Vec<String>, String)> {
        self.of(place, |env| {
            let own = (0..self.robots).map(|robot| env.belief(robot).digest().to_string());
            (own.collect(), env.merged().digest().to_string())
        })
    }
}

impl TeamBatch {
    fn of<T>(&self, place: usize, read: impl FnOnce(&TeamEnv) -> T) -> PyResult<T> {
        self.lanes.read(place, |lane| read(&lane.env))
    }

    /// The cell that each robot's action leads to; `None` if it stays, or does not search.
    fn targets(
        &self,
        lane: &Lane,
        environment: Option<usize>,
        actions: &[i64],
    ) -> PyResult<Vec<Option<Cell>>> {
        let reasons = lane.env.termination_reasons();
        let target = |robot: usize| {
            if reasons[robot] != TerminationReason::Searching {
                return Ok(None);
            }
            let actor = Actor { environment, robot: Some(robot), from: lane.env.cell(robot) };
            self.actions.target(&self.field, actor, actions[robot])
        };
        (0..self.robots).map(target).collect()
    }

    /// Performs the task of each search, in parallel, and writes its arrays and measures.
    fn perform(&self, py: Python<'_>, lanes: &mut [Option<Lane>], tasks: Vec<Task>) -> PyResult<()> {
        let mut written = self.arrays.write(py)?;
        let mut buffers = written.buffers(lanes.len() * self.robots)?;
        let work = lanes.iter_mut().zip(buffers.chunks_exact_mut(self.robots)).zip(tasks).collect();
        let measured = pool::map(py, work, LEAST_TOGETHER, |((lane, buffers), task)| {
            let measured = self.advance(lane, task)?;
            if let (Some(lane), Some(_)) = (lane, &measured) {
                self.draw(lane, buffers);
            }
            Ok(measured)
        });
        let measured = measured.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| failed(&error))?;
        self.measures.write(py, &measured)
    }

    /// Performs the task of a search.
    fn advance(&self, lane: &mut Option<Lane>, task: Task) -> Result<Option<MeasuredTeam>, ParticipantError> {
        match task {
            Task::Keep => Ok(None),
            Task::Begin { seed } => {
                let env = TeamEnv::new(Arc::clone(&self.field), self.reward, &self.crashes, seed)?;
                let lane = lane.insert(Lane {
                    env,
                    seed,
                    history: Vec::new(),
                    kept: vec![Vec::new(); self.robots],
                    is_drawn: false,
                    is_known_drawn: false,
                });
                Ok(Some(lane.measured(|_| 0.0)))
            }
            Task::Act { actions, targets } => match lane {
                Some(lane) => self.act(lane, &actions, &targets).map(Some),
                None => Ok(None),
            },
        }
    }

    fn act(
        &self,
        lane: &mut Lane,
        actions: &[i64],
        targets: &[Option<Cell>],
    ) -> Result<MeasuredTeam, ParticipantError> {
        // Who left gets no reward; who is out as the episode begins leaves with the first action.
        let is_first = lane.history.is_empty();
        let reasons = lane.env.termination_reasons();
        let is_searching = |&reason: &TerminationReason| reason == TerminationReason::Searching;
        let counts: Vec<bool> = reasons.iter().map(|reason| is_first || is_searching(reason)).collect();
        let gain = if reasons.iter().any(is_searching) {
            let next = (0..self.robots).map(|robot| self.one_move(&lane.env, robot, targets[robot]));
            let next: Vec<Move> = next.collect();
            lane.env.step(&next)?
        } else {
            0.0
        };
        lane.history.extend(actions);
        Ok(lane.measured(|robot| if counts[robot] { gain } else { 0.0 }))
    }

    /// The move toward a cell.
    fn one_move(&self, env: &TeamEnv, robot: usize, to: Option<Cell>) -> Move {
        let next = match (to, self.actions.control) {
            (Some(to), Control::Waypoint) => self.field.path(env.cell(robot), to).first().copied(),
            (to, _) => to,
        };
        next.map_or(Move::Wait, Move::To)
    }

    /// Writes what each robot of a search observes.
    fn draw(&self, lane: &mut Lane, buffers: &mut [ObservationBuffers<'_>]) {
        let Lane { env, kept, is_drawn, .. } = lane;
        let extent = if std::mem::replace(is_drawn, true) { Extent::Changes } else { Extent::All };
        for (robot, (buffer, kept)) in buffers.iter_mut().zip(kept).enumerate() {
            let member = &mut Member(env, robot);
            buffer.draw(member, &self.field, &self.layout, self.actions.control, extent, kept);
        }
    }
}

impl Lane {
    /// Whether it has told that it is over: after its first action at the earliest.
    fn is_over(&self) -> bool {
        !self.env.termination_reasons().contains(&TerminationReason::Searching) && !self.history.is_empty()
    }

    fn measured(&self, reward: impl Fn(usize) -> f64) -> MeasuredTeam {
        let env = &self.env;
        let robots = env.termination_reasons().iter().enumerate().map(|(robot, &reason)| MeasuredRobot {
            reward: reward(robot),
            reason: match reason {
                TerminationReason::Searching => Reason::Searching,
                TerminationReason::Found => Reason::Found,
                TerminationReason::Spent => Reason::Spent,
                TerminationReason::Crashed => Reason::Crashed,
            },
            path_cells: env.path_cells(robot),
        });
        Measured {
            is_new: self.history.is_empty(),
            f1: env.score().f1(),
            recall: env.score().recall(),
            time_seconds: env.now().as_seconds(),
            robots: robots.collect(),
        }
    }
}

fn numbers(cells: &[Cell]) -> Vec<i64> {
    cells.iter().map(|cell| i64::from(cell.number())).collect()
}

fn failed(error: &ParticipantError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
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
