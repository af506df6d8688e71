//! What is measured of searches after a step: a number for each search, or for each of its robots.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{borrow, copy, slice, zeros};

/// Why a robot does not search any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    Searching,
    Found,
    Cleared,
    Spent,
    Crashed,
}

impl Reason {
    /// All, at the places of their numbers in arrays.
    pub(crate) const ALL: [Self; 5] =
        [Self::Searching, Self::Found, Self::Cleared, Self::Spent, Self::Crashed];

    pub(crate) const fn as_str(self) -> &'static str {
        match self {
            Self::Searching => "searching",
            Self::Found => "found",
            Self::Cleared => "cleared",
            Self::Spent => "spent",
            Self::Crashed => "crashed",
        }
    }

    const fn is_termination(self) -> bool {
        matches!(self, Self::Found | Self::Cleared | Self::Crashed)
    }
}

/// Names of reasons, at the places of their numbers in arrays.
#[pyfunction]
pub(crate) fn reasons() -> Vec<&'static str> {
    Reason::ALL.iter().map(|reason| reason.as_str()).collect()
}

/// A search after a task; `R` lists its robots.
pub(crate) struct Measured<R> {
    /// Whether its episode begins: what is over as it begins is told after its first action.
    pub(crate) is_new: bool,
    pub(crate) f1: f64,
    pub(crate) recall: f64,
    pub(crate) time_seconds: f64,
    pub(crate) robots: R,
}

/// A robot of it.
#[derive(Clone, Copy)]
pub(crate) struct MeasuredRobot {
    pub(crate) reward: f64,
    pub(crate) reason: Reason,
    pub(crate) path_cells: f64,
}

/// The arrays: of searches shape `[searches]`, of robots `[searches * robots]`.
pub(crate) struct Measures {
    over: Py<PyArray1<bool>>,
    f1: Py<PyArray1<f64>>,
    recall: Py<PyArray1<f64>>,
    time_seconds: Py<PyArray1<f64>>,
    reward: Py<PyArray1<f64>>,
    terminated: Py<PyArray1<bool>>,
    truncated: Py<PyArray1<bool>>,
    /// Numbers of reasons.
    reason: Py<PyArray1<u8>>,
    path_cells: Py<PyArray1<f64>>,
}

impl Measures {
    /// Arrays for searches of so many robots each.
    pub(crate) fn new(py: Python<'_>, searches: usize, robots: usize) -> PyResult<Self> {
        Ok(Self {
            over: zeros(py, searches)?,
            f1: zeros(py, searches)?,
            recall: zeros(py, searches)?,
            time_seconds: zeros(py, searches)?,
            reward: zeros(py, searches * robots)?,
            terminated: zeros(py, searches * robots)?,
            truncated: zeros(py, searches * robots)?,
            reason: zeros(py, searches * robots)?,
            path_cells: zeros(py, searches * robots)?,
        })
    }

    /// Others with the same content.
    pub(crate) fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self {
            over: copy(self.over.bind(py))?,
            f1: copy(self.f1.bind(py))?,
            recall: copy(self.recall.bind(py))?,
            time_seconds: copy(self.time_seconds.bind(py))?,
            reward: copy(self.reward.bind(py))?,
            terminated: copy(self.terminated.bind(py))?,
            truncated: copy(self.truncated.bind(py))?,
            reason: copy(self.reason.bind(py))?,
            path_cells: copy(self.path_cells.bind(py))?,
        })
    }

    /// Adds the arrays by name.
    pub(crate) fn add_to(&self, dict: &Bound<'_, PyDict>) -> PyResult<()> {
        dict.set_item("over", &self.over)?;
        dict.set_item("f1", &self.f1)?;
        dict.set_item("recall", &self.recall)?;
        dict.set_item("time_seconds", &self.time_seconds)?;
        dict.set_item("reward", &self.reward)?;
        dict.set_item("terminated", &self.terminated)?;
        dict.set_item("truncated", &self.truncated)?;
        dict.set_item("reason", &self.reason)?;
        dict.set_item("path_cells", &self.path_cells)
    }

    /// Writes what was measured; a search without measures keeps its own.
    pub(crate) fn write<R: AsRef<[MeasuredRobot]>>(
        &self,
        py: Python<'_>,
        measured: &[Option<Measured<R>>],
    ) -> PyResult<()> {
        let is_over = |it: &Measured<R>| {
            !it.is_new && it.robots.as_ref().iter().all(|robot| robot.reason != Reason::Searching)
        };
        fill(py, &self.over, measured, is_over)?;
        fill(py, &self.f1, measured, |it| it.f1)?;
        fill(py, &self.recall, measured, |it| it.recall)?;
        fill(py, &self.time_seconds, measured, |it| it.time_seconds)?;
        fill_robots(py, &self.reward, measured, |_, robot| robot.reward)?;
        let terminated =
            |it: &Measured<R>, robot: &MeasuredRobot| !it.is_new && robot.reason.is_termination();
        fill_robots(py, &self.terminated, measured, terminated)?;
        let truncated = |it: &Measured<R>, robot: &MeasuredRobot| !it.is_new && robot.reason == Reason::Spent;
        fill_robots(py, &self.truncated, measured, truncated)?;
        fill_robots(py, &self.reason, measured, |_, robot| robot.reason as u8)?;
        fill_robots(py, &self.path_cells, measured, |_, robot| robot.path_cells)
    }
}

fn fill<T: numpy::Element, R>(
    py: Python<'_>,
    column: &Py<PyArray1<T>>,
    measured: &[Option<Measured<R>>],
    value: impl Fn(&Measured<R>) -> T,
) -> PyResult<()> {
    let mut column = borrow(column.bind(py))?;
    for (place, measured) in slice(&mut column)?.iter_mut().zip(measured) {
        if let Some(measured) = measured {
            *place = value(measured);
        }
    }
    Ok(())
}

fn fill_robots<T: numpy::Element, R: AsRef<[MeasuredRobot]>>(
    py: Python<'_>,
    column: &Py<PyArray1<T>>,
    measured: &[Option<Measured<R>>],
    value: impl Fn(&Measured<R>, &MeasuredRobot) -> T,
) -> PyResult<()> {
    let mut column = borrow(column.bind(py))?;
    let numbers = slice(&mut column)?;
    let robots = (numbers.len() / measured.len().max(1)).max(1);
    for (places, measured) in numbers.chunks_exact_mut(robots).zip(measured) {
        if let Some(measured) = measured {
            for (place, robot) in places.iter_mut().zip(measured.robots.as_ref()) {
                *place = value(measured, robot);
            }
        }
    }
    Ok(())
}
