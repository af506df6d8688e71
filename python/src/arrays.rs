//! The arrays that hold observations of environments: allocated once, written in place.

use std::slice::ChunksExactMut;

use dragnet_search::cell::Grid;
use dragnet_sim::single_robot_env::features::{Layout, View};
use dragnet_sim::single_robot_env::{Control, Field, SingleRobotEnv};
use dragnet_sim::team_env::TeamEnv;
use numpy::ndarray::Dimension;
use numpy::{AsSliceError, Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadwriteArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The arrays of a number of robots, by robot, each in its own search or all in one.
pub(crate) struct Arrays {
    /// Shape `[robots, numbers of the layout]`.
    features: Py<PyArray2<f32>>,
    /// Row and column, shares of the last ones, `0..=1`: shape `[robots, 2]`.
    position: Py<PyArray2<f32>>,
    /// Share that is left: shape `[robots, 1]`.
    budget: Py<PyArray2<f32>>,
    /// Shape `[robots, actions]`.
    action_mask: Py<PyArray2<i8>>,
}

/// The arrays, borrowed for writing.
pub(crate) struct Written<'py> {
    features: PyReadwriteArray<'py, f32, numpy::Ix2>,
    position: PyReadwriteArray<'py, f32, numpy::Ix2>,
    budget: PyReadwriteArray<'py, f32, numpy::Ix2>,
    action_mask: PyReadwriteArray<'py, i8, numpy::Ix2>,
}

/// The part of one robot.
pub(crate) struct ObservationBuffers<'a> {
    features: &'a mut [f32],
    position: &'a mut [f32],
    budget: &'a mut [f32],
    action_mask: &'a mut [i8],
}

/// Whether all is written, or what has changed since it was written last.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    All,
    Changes,
}

impl Arrays {
    /// Arrays for a number of robots.
    pub(crate) fn new(py: Python<'_>, robots: usize, layout: &Layout, actions: usize) -> PyResult<Self> {
        Ok(Self {
            features: zeros(py, (robots, layout.len()))?,
            position: zeros(py, (robots, 2))?,
            budget: zeros(py, (robots, 1))?,
            action_mask: zeros(py, (robots, actions))?,
        })
    }

    /// Others with the same content.
    pub(crate) fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self {
            features: copy(self.features.bind(py))?,
            position: copy(self.position.bind(py))?,
            budget: copy(self.budget.bind(py))?,
            action_mask: copy(self.action_mask.bind(py))?,
        })
    }

    /// The arrays by name.
    pub(crate) fn dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("features", &self.features)?;
        dict.set_item("position", &self.position)?;
        dict.set_item("budget", &self.budget)?;
        dict.set_item("action_mask", &self.action_mask)?;
        Ok(dict)
    }

    /// Borrows all of them.
    pub(crate) fn write<'py>(&self, py: Python<'py>) -> PyResult<Written<'py>> {
        Ok(Written {
            features: borrow(self.features.bind(py))?,
            position: borrow(self.position.bind(py))?,
            budget: borrow(self.budget.bind(py))?,
            action_mask: borrow(self.action_mask.bind(py))?,
        })
    }
}

impl Written<'_> {
    /// The part of each robot, by robot.
    pub(crate) fn buffers(&mut self, robots: usize) -> PyResult<Vec<ObservationBuffers<'_>>> {
        let mut features = parts(&mut self.features, robots)?;
        let mut position = parts(&mut self.position, robots)?;
        let mut budget = parts(&mut self.budget, robots)?;
        let mut action_mask = parts(&mut self.action_mask, robots)?;
        let buffers = std::iter::from_fn(|| {
            Some(ObservationBuffers {
                features: features.next()?,
                position: position.next()?,
                budget: budget.next()?,
                action_mask: action_mask.next()?,
            })
        });
        Ok(buffers.collect())
    }
}

/// A robot whose observation is drawn.
pub(crate) trait Observed {
    /// Writes what it knows in the map's frame.
    fn draw(&mut self, field: &Field, layout: &Layout, extent: Extent, numbers: &mut [f32]);

    /// What it knows; of its teammates nothing.
    fn view(&self) -> View<'_>;
}

impl Observed for SingleRobotEnv {
    fn draw(&mut self, _: &Field, layout: &Layout, extent: Extent, numbers: &mut [f32]) {
        match extent {
            Extent::All => Self::draw(self, layout, numbers),
            Extent::Changes => Self::redraw(self, layout, numbers),
        }
    }

    fn view(&self) -> View<'_> {
        Self::view(self)
    }
}

/// A robot of a team, by its index.
pub(crate) struct Member<'a>(pub(crate) &'a mut TeamEnv, pub(crate) usize);

impl Observed for Member<'_> {
    fn draw(&mut self, _: &Field, layout: &Layout, extent: Extent, numbers: &mut [f32]) {
        match extent {
            Extent::All => self.0.draw(self.1, layout, numbers),
            Extent::Changes => self.0.redraw(self.1, layout, numbers),
        }
    }

    fn view(&self) -> View<'_> {
        self.0.view(self.1, &[])
    }
}

/// Only ever drawn as a whole.
impl Observed for View<'_> {
    fn draw(&mut self, field: &Field, layout: &Layout, _: Extent, numbers: &mut [f32]) {
        layout.draw(field, self, numbers);
    }

    fn view(&self) -> View<'_> {
        *self
    }
}

impl ObservationBuffers<'_> {
    /// Writes what a robot observes. `kept` keeps the map's frame of a layout that is centered on the robot.
    pub(crate) fn draw(
        &mut self,
        robot: &mut impl Observed,
        field: &Field,
        layout: &Layout,
        control: Control,
        extent: Extent,
        kept: &mut Vec<f32>,
    ) {
        if layout.is_centered() {
            kept.resize(layout.drawn_len(), 0.0);
        }
        let numbers = if layout.is_centered() { kept.as_mut_slice() } else { &mut *self.features };
        robot.draw(field, layout, extent, numbers);
        self.finish(field, layout, control, &robot.view(), kept);
    }

    fn finish(&mut self, field: &Field, layout: &Layout, control: Control, view: &View<'_>, kept: &[f32]) {
        if layout.is_centered() {
            layout.center(view, kept, self.features);
        }
        let grid = field.scenario().terrain().grid();
        let position = grid.position(view.robot);
        let share = |at: u32, count: u32| at as f32 / (count - 1).max(1) as f32;
        self.position
            .copy_from_slice(&[share(position.row, grid.rows()), share(position.column, grid.columns())]);
        self.budget.fill(view.budget);
        field.draw_mask(control, view.robot, self.action_mask);
    }
}

/// The exact belief of a robot in new arrays, by name, as policies read it: shape `[rows, columns]` each, but for its
/// position.
pub(crate) fn belief<'py>(py: Python<'py>, field: &Field, view: &View<'_>) -> PyResult<Bound<'py, PyDict>> {
    use dragnet_search::belief::probability;
    use dragnet_search::evidence::UNITS;
    let scenario = field.scenario();
    let grid = scenario.terrain().grid();
    let of =
        |value: &dyn Fn(dragnet_search::cell::Cell) -> f64| grid.cells().map(value).collect::<Vec<f64>>();
    let evidence = view.belief.evidence();
    let log_odds = of(&|cell| view.belief.log_odds_nats(cell));
    #[expect(clippy::cast_possible_truncation, reason = "a probability for networks")]
    let short = log_odds.iter().map(|&log_odds| probability(log_odds) as f32).collect();
    let dict = PyDict::new(py);
    dict.set_item("log_odds", cells(py, grid, log_odds)?)?;
    dict.set_item("probability", cells(py, grid, short)?)?;
    let precision = of(&|cell| evidence.of(cell).precision as f64 / UNITS);
    dict.set_item("precision", cells(py, grid, precision)?)?;
    let weighted_sum = of(&|cell| evidence.of(cell).weighted_sum as f64 / UNITS);
    dict.set_item("weighted_sum", cells(py, grid, weighted_sum)?)?;
    dict.set_item("distance", cells(py, grid, field.distances(view.robot))?)?;
    let open = grid.cells().map(|cell| i8::from(scenario.terrain().is_traversable(cell))).collect();
    dict.set_item("traversable", cells(py, grid, open)?)?;
    let position = grid.position(view.robot);
    dict.set_item(
        "position",
        PyArray1::from_vec(py, vec![i64::from(position.row), i64::from(position.column)]),
    )?;
    Ok(dict)
}

fn cells<T: Element>(py: Python<'_>, grid: Grid, numbers: Vec<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    PyArray1::from_vec(py, numbers).reshape([grid.rows() as usize, grid.columns() as usize])
}

/// An array of zeros, by `NumPy` itself: what is too large for the memory is an exception.
pub(crate) fn zeros<'py, T: Element, D: Dimension>(
    py: Python<'py>,
    shape: impl IntoPyObject<'py>,
) -> PyResult<Py<PyArray<T, D>>> {
    let array = py.import("numpy")?.call_method1("zeros", (shape, T::get_dtype(py)))?;
    Ok(array.cast_into::<PyArray<T, D>>()?.unbind())
}

/// Another array with the same content.
pub(crate) fn copy<T: Element, D: Dimension>(
    array: &Bound<'_, PyArray<T, D>>,
) -> PyResult<Py<PyArray<T, D>>> {
    let array = array.try_readonly().map_err(|error| {
        PyRuntimeError::new_err(format!("an array of this environment cannot be read: {error}"))
    })?;
    Ok(PyArray::from_array(array.py(), &array.as_array()).unbind())
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
