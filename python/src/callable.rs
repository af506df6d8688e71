//! A policy that is a callable in Python.

use std::sync::{Arc, Mutex, PoisonError};

use dragnet_search::cell::Cell;
use dragnet_search::observation::RobotId;
use dragnet_search::policy::{Decision, Policy};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;
use dragnet_sim::single_robot_env::features::{Company, Layout, View};
use dragnet_sim::single_robot_env::{Control, Field};
use pyo3::prelude::*;

use crate::arrays::{self, Arrays, Extent};
use crate::choice;

/// How callables see and act: `observation`, `frame` and `control` of the environments.
pub(crate) type Interface = (String, String, String);

/// What decides, and its first exception.
pub(crate) struct Callable {
    decide: Py<PyAny>,
    arrays: Arrays,
    layout: Layout,
    control: Control,
    is_exact: bool,
    failure: Mutex<Option<PyErr>>,
}

/// A robot that asks a callable.
pub(crate) struct Caller {
    callable: Arc<Callable>,
    field: Arc<Field>,
    seed: u64,
    robot: RobotId,
    decisions: u64,
}

impl Callable {
    /// What decides on the map of a field.
    pub(crate) fn new(
        py: Python<'_>,
        decide: &Py<PyAny>,
        field: &Field,
        (observation, frame, control): &Interface,
    ) -> PyResult<Self> {
        let grid = field.scenario().terrain().grid();
        let layout = choice::layout(observation, frame, Company::Alone, grid)?;
        let control = choice::control(control)?;
        Ok(Self {
            decide: decide.clone_ref(py),
            arrays: Arrays::new(py, 1, &layout, field.action_count(control))?,
            layout,
            control,
            is_exact: choice::is_belief(observation),
            failure: Mutex::new(None),
        })
    }

    /// Begins the episode of a seed.
    pub(crate) fn reset(&self, py: Python<'_>, seed: u64) -> PyResult<()> {
        self.decide.call_method1(py, "reset", (seed,)).map(|_| ())
    }

    /// The exception that it raised, once.
    pub(crate) fn failure(&self) -> Option<PyErr> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Caller {
    pub(crate) fn new(callable: &Arc<Callable>, field: &Arc<Field>, seed: u64, robot: RobotId) -> Self {
        Self { callable: Arc::clone(callable), field: Arc::clone(field), seed, robot, decisions: 0 }
    }

    /// The path of the action that the callable chooses; none if it rests.
    fn ask(&self, py: Python<'_>, situation: &Situation<'_>) -> PyResult<Vec<Cell>> {
        let Callable { decide, arrays, layout, control, is_exact, .. } = &*self.callable;
        let scenario = self.field.scenario();
        let meters = situation.remaining_cells * scenario.terrain().cell_meters();
        let view = View {
            belief: situation.belief,
            robot: situation.robot,
            budget: self.field.budget(meters),
            teammates: &[],
        };
        {
            let mut written = arrays.write(py)?;
            for buffer in &mut written.buffers(1)? {
                buffer.draw(&mut view.clone(), &self.field, layout, *control, Extent::All, &mut Vec::new());
            }
        }
        let exact = if *is_exact { Some(arrays::belief(py, &self.field, &view)?) } else { None };
        let at = scenario.terrain().grid().position(situation.robot);
        let place = format!(
            "on {:?}, seed {}, decision {} of robot_{} at row {}, column {}",
            scenario.name(),
            self.seed,
            self.decisions,
            self.robot.number(),
            at.row,
            at.column
        );
        let action: Option<usize> = decide.call1(py, (arrays.dict(py)?, exact, place))?.extract(py)?;
        let Some(to) = action.and_then(|action| self.field.target(*control, situation.robot, action)) else {
            return Ok(Vec::new());
        };
        Ok(match control {
            Control::Step => vec![to],
            Control::Waypoint => {
                ShortestPathTree::from(scenario.terrain(), scenario.connectivity(), situation.robot).path(to)
            }
        })
    }
}

impl Policy for Caller {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        self.decisions += 1;
        let path = Python::attach(|py| {
            let mut failure = self.callable.failure.lock().unwrap_or_else(PoisonError::into_inner);
            if failure.is_some() {
                return Vec::new();
            }
            self.ask(py, situation).unwrap_or_else(|error| {
                *failure = Some(error);
                Vec::new()
            })
        });
        let chosen = path.last().copied().unwrap_or(situation.robot);
        Decision { chosen, path, scores: Vec::new() }
    }
}
