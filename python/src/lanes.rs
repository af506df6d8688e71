//! Searches side by side, one lane each, which one thread at a time may touch.

use std::sync::{Mutex, MutexGuard};

use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// The lanes of a batch; `None` before their first reset.
pub(crate) struct Lanes<L>(Mutex<Vec<Option<L>>>);

impl<L> Lanes<L> {
    pub(crate) fn new(count: usize) -> PyResult<Self> {
        if count == 0 {
            return Err(PyValueError::new_err("num_envs=0; allowed is at least 1"));
        }
        let mut lanes = Vec::new();
        lanes
            .try_reserve_exact(count)
            .map_err(|error| PyMemoryError::new_err(format!("num_envs={count}: {error}")))?;
        lanes.resize_with(count, || None);
        Ok(Self::of(lanes))
    }

    pub(crate) const fn of(lanes: Vec<Option<L>>) -> Self {
        Self(Mutex::new(lanes))
    }

    pub(crate) fn lock(&self) -> PyResult<MutexGuard<'_, Vec<Option<L>>>> {
        self.0.try_lock().map_err(|_| {
            PyRuntimeError::new_err("another thread is stepping this environment; allowed is one at a time")
        })
    }

    /// Reads the search of a lane.
    pub(crate) fn read<T>(&self, place: usize, read: impl FnOnce(&L) -> T) -> PyResult<T> {
        let lanes = self.lock()?;
        let lane = lanes.get(place).ok_or_else(|| no_environment(place))?;
        let lane = lane.as_ref().ok_or_else(|| PyRuntimeError::new_err("nothing before the first reset"))?;
        Ok(read(lane))
    }
}

/// What a lane has to do in a step of the batch: begin anew where its search is over, if there is a seed for that, and
/// otherwise what `act` says.
pub(crate) fn next<L, T>(
    lane: Option<&L>,
    is_over: impl FnOnce(&L) -> bool,
    begin: Option<T>,
    act: impl FnOnce(&L) -> PyResult<T>,
) -> PyResult<T> {
    let lane =
        lane.ok_or_else(|| PyRuntimeError::new_err("step before the first reset; call reset first"))?;
    match (is_over(lane), begin) {
        (true, Some(begin)) => Ok(begin),
        (true, None) => Err(PyRuntimeError::new_err("step after the end of the episode; call reset first")),
        (false, _) => act(lane),
    }
}

pub(crate) fn no_environment(place: usize) -> PyErr {
    PyValueError::new_err(format!("no environment {place}"))
}

/// Returns the list if it has one entry for each.
pub(crate) fn expect_one_each<T>(name: &str, list: Vec<T>, count: usize) -> PyResult<Vec<T>> {
    if list.len() == count {
        return Ok(list);
    }
    Err(PyValueError::new_err(format!("{name} of length {}; allowed is {count}, one each", list.len())))
}
