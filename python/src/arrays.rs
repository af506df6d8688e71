//! The arrays that hold observations of environments: allocated once, written in place.

use std::slice::ChunksExactMut;

use dragnet_search::cell::Grid;
use dragnet_sim::single_robot_env::ObservationBuffers;
use numpy::ndarray::Dimension;
use numpy::{AsSliceError, Element, PyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadwriteArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The arrays of a number of robots, by robot, each in its own search or all in one.
pub(crate) struct Arrays {
    log_odds: Py<PyArray3<f64>>,
    probability: Py<PyArray3<f32>>,
    precision: Py<PyArray3<f64>>,
    weighted_sum: Py<PyArray3<f64>>,
    distance: Py<PyArray3<f32>>,
    position: Py<PyArray2<i32>>,
    action_mask: Py<PyArray2<i8>>,
}

/// The arrays, borrowed for writing.
pub(crate) struct Written<'py> {
    log_odds: PyReadwriteArray<'py, f64, numpy::Ix3>,
    probability: PyReadwriteArray<'py, f32, numpy::Ix3>,
    precision: PyReadwriteArray<'py, f64, numpy::Ix3>,
    weighted_sum: PyReadwriteArray<'py, f64, numpy::Ix3>,
    distance: PyReadwriteArray<'py, f32, numpy::Ix3>,
    position: PyReadwriteArray<'py, i32, numpy::Ix2>,
    action_mask: PyReadwriteArray<'py, i8, numpy::Ix2>,
}

impl Arrays {
    /// Arrays for a number of robots on a grid, each with a number of actions.
    pub(crate) fn new(py: Python<'_>, robots: usize, grid: Grid, actions: usize) -> Self {
        let cells = (robots, grid.rows() as usize, grid.columns() as usize);
        Self {
            log_odds: PyArray3::zeros(py, cells, false).unbind(),
            probability: PyArray3::zeros(py, cells, false).unbind(),
            precision: PyArray3::zeros(py, cells, false).unbind(),
            weighted_sum: PyArray3::zeros(py, cells, false).unbind(),
            distance: PyArray3::zeros(py, cells, false).unbind(),
            position: PyArray2::zeros(py, (robots, 2), false).unbind(),
            action_mask: PyArray2::zeros(py, (robots, actions), false).unbind(),
        }
    }

    /// The arrays by name.
    pub(crate) fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("log_odds", &self.log_odds)?;
        dict.set_item("probability", &self.probability)?;
        dict.set_item("precision", &self.precision)?;
        dict.set_item("weighted_sum", &self.weighted_sum)?;
        dict.set_item("distance", &self.distance)?;
        dict.set_item("position", &self.position)?;
        dict.set_item("action_mask", &self.action_mask)?;
        Ok(dict)
    }

    /// Borrows all of them.
    pub(crate) fn write<'py>(&self, py: Python<'py>) -> PyResult<Written<'py>> {
        Ok(Written {
            log_odds: borrow(self.log_odds.bind(py))?,
            probability: borrow(self.probability.bind(py))?,
            precision: borrow(self.precision.bind(py))?,
            weighted_sum: borrow(self.weighted_sum.bind(py))?,
            distance: borrow(self.distance.bind(py))?,
            position: borrow(self.position.bind(py))?,
            action_mask: borrow(self.action_mask.bind(py))?,
        })
    }
}

impl Written<'_> {
    /// The part of each robot, by robot.
    pub(crate) fn buffers(&mut self, robots: usize) -> PyResult<Vec<ObservationBuffers<'_>>> {
        let mut log_odds = parts(&mut self.log_odds, robots)?;
        let mut probability = parts(&mut self.probability, robots)?;
        let mut precision = parts(&mut self.precision, robots)?;
        let mut weighted_sum = parts(&mut self.weighted_sum, robots)?;
        let mut distance = parts(&mut self.distance, robots)?;
        let mut position = parts(&mut self.position, robots)?;
        let mut action_mask = parts(&mut self.action_mask, robots)?;
        let buffers = std::iter::from_fn(|| {
            Some(ObservationBuffers {
                log_odds_nats: log_odds.next()?,
                probability: probability.next()?,
                precision: precision.next()?,
                weighted_sum: weighted_sum.next()?,
                distance_cells: distance.next()?,
                position: position.next()?,
                action_mask: action_mask.next()?,
            })
        });
        Ok(buffers.collect())
    }
}

/// A number for each robot.
pub(crate) fn column<T: Element>(py: Python<'_>, robots: usize) -> Py<PyArray1<T>> {
    PyArray1::zeros(py, robots, false).unbind()
}

/// Borrows an array to write into it.
pub(crate) fn borrow<'py, T: Element, D: Dimension>(
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    array.try_readwrite().map_err(|error| {
        PyRuntimeError::new_err(format!("an array of this environment cannot be written: {error}"))
    })
}

/// The numbers of an array, in its order.
pub(crate) fn slice<'a, T: Element, D: Dimension>(
    array: &'a mut PyReadwriteArray<'_, T, D>,
) -> PyResult<&'a mut [T]> {
    array.as_slice_mut().map_err(|error: AsSliceError| PyRuntimeError::new_err(error.to_string()))
}

fn parts<'a, T: Element, D: Dimension>(
    array: &'a mut PyReadwriteArray<'_, T, D>,
    robots: usize,
) -> PyResult<ChunksExactMut<'a, T>> {
    let numbers = slice(array)?;
    let part = (numbers.len() / robots).max(1);
    Ok(numbers.chunks_exact_mut(part))
}
