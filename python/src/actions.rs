//! What actions stand for, and what is wrong with those that cannot be taken.

use dragnet_search::cell::Cell;
use dragnet_sim::single_robot_env::{Control, Field};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::choice::{self, Masked};

/// How actions are read.
#[derive(Clone, Copy)]
pub(crate) struct Actions {
    pub(crate) control: Control,
    masked: Masked,
}

/// The robot that acts.
#[derive(Clone, Copy)]
pub(crate) struct Actor {
    /// The environment that it is in, if there are several.
    pub(crate) environment: Option<usize>,
    /// Its index in its team, if it has one.
    pub(crate) robot: Option<usize>,
    /// Its cell.
    pub(crate) from: Cell,
}

impl Actions {
    pub(crate) fn new(control: &str, masked: &str) -> PyResult<Self> {
        Ok(Self { control: choice::control(control)?, masked: choice::masked(masked)? })
    }

    /// The cell that a robot's action names; `None` if it stays.
    pub(crate) fn target(self, field: &Field, actor: Actor, action: i64) -> PyResult<Option<Cell>> {
        let place = usize::try_from(action).ok().filter(|&it| it < field.action_count(self.control));
        let to = place.and_then(|place| field.target(self.control, actor.from, place));
        match (to, self.masked) {
            (Some(_), _) => Ok(to),
            (None, Masked::Stay) if place.is_some() => Ok(None),
            (None, _) => {
                let what = if place.is_some() {
                    "it is masked: the robot cannot get there".to_owned()
                } else {
                    format!("no such action: they are 0 to {}", field.action_count(self.control) - 1)
                };
                let who = actor.described(field);
                Err(PyValueError::new_err(format!(
                    "{who}: action {action}: {what}; allowed are those whose action_mask is 1"
                )))
            }
        }
    }
}

impl Actor {
    fn described(self, field: &Field) -> String {
        let environment = self.environment.map_or(String::new(), |place| format!("environment {place}, "));
        let robot = self.robot.map_or("robot".to_owned(), |index| format!("robot_{}", index + 1));
        let at = field.scenario().terrain().grid().position(self.from);
        format!("{environment}{robot} at row {}, column {}", at.row, at.column)
    }
}
