//! A scenario, checked.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dragnet_scenario::ScenarioError;
use dragnet_scenario::file::PolicyField;
use dragnet_scenario::shipped::ShippedScenario;
use dragnet_search::cell::Cell;
use dragnet_search::route::Connectivity;
use dragnet_sim::single_robot_env::Field;
use numpy::ndarray::Array2;
use numpy::{PyArray2, ToPyArray};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A search that can be run: with a seed, it is an episode.
#[pyclass(frozen, module = "dragnet._dragnet")]
#[derive(Clone)]
pub(crate) struct Scenario {
    field: Arc<Field>,
}

impl Scenario {
    pub(crate) fn inner(&self) -> &dragnet_scenario::Scenario {
        self.field.scenario()
    }

    /// What searches of the scenario share in environments, whose robots move on one map, one cell a step.
    pub(crate) fn field(&self) -> PyResult<Arc<Field>> {
        if self.inner().only_class().is_none_or(|class| class.flies) {
            return Err(PyValueError::new_err(format!(
                "{} has robots of several classes, or that fly; allowed are robots of one class, on the ground",
                self.inner().name()
            )));
        }
        if self.inner().mission().return_reserve.is_some() {
            return Err(PyValueError::new_err(format!(
                "{} has mission.return_to_base, which environments leave to who drives; allowed is false",
                self.inner().name()
            )));
        }
        Ok(self.shared())
    }

    /// What all searches of the scenario share.
    pub(crate) fn shared(&self) -> Arc<Field> {
        Arc::clone(&self.field)
    }

    pub(crate) fn new(scenario: dragnet_scenario::Scenario) -> Self {
        Self { field: Arc::new(Field::new(scenario)) }
    }

    /// A number for each cell, in rows from the south.
    fn cells<'py, T: numpy::Element + Copy>(
        &self,
        py: Python<'py>,
        value: impl Fn(Cell) -> T,
    ) -> Bound<'py, PyArray2<T>> {
        let grid = self.inner().terrain().grid();
        let cells: Vec<Cell> = grid.cells().collect();
        let shape = (grid.rows() as usize, grid.columns() as usize);
        Array2::from_shape_fn(shape, |(row, column)| value(cells[row * shape.1 + column])).to_pyarray(py)
    }
}

#[pymethods]
impl Scenario {
    #[staticmethod]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| dragnet_scenario::Scenario::load(&path).map(Self::new)).map_err(|error| refused(&error))
    }

    #[staticmethod]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn from_text(py: Python<'_>, text: String, path: PathBuf) -> PyResult<Self> {
        py.detach(|| dragnet_scenario::Scenario::from_text(&path, text).map(Self::new))
            .map_err(|error| refused(&error))
    }

    fn with_robots(&self, count: u32) -> PyResult<Self> {
        self.inner().with_robots(count).map(Self::new).map_err(|error| refused(&error))
    }

    fn with_density(&self, density: f64) -> PyResult<Self> {
        self.inner().with_density(density).map(Self::new).map_err(|error| refused(&error))
    }

    fn with_budget_cells(&self, cells: u32) -> PyResult<Self> {
        self.inner().with_budget_cells(cells).map(Self::new).map_err(|error| refused(&error))
    }

    fn with_policy(&self, name: &str) -> PyResult<Self> {
        self.inner().with_policy(policy_field(name)?).map(Self::new).map_err(|error| refused(&error))
    }

    /// The scenario's text as read, and its path.
    #[getter]
    fn source(&self) -> (&str, &Path) {
        let source = self.inner().source();
        (&source.text, &source.path)
    }

    #[getter]
    fn name(&self) -> &str {
        self.inner().name()
    }

    #[getter]
    fn rows(&self) -> u32 {
        self.inner().terrain().grid().rows()
    }

    #[getter]
    fn columns(&self) -> u32 {
        self.inner().terrain().grid().columns()
    }

    #[getter]
    fn cell_meters(&self) -> f64 {
        self.inner().terrain().cell_meters()
    }

    #[getter]
    fn robots(&self) -> usize {
        self.inner().robots().len()
    }

    #[getter]
    fn connectivity(&self) -> usize {
        match self.inner().connectivity() {
            Connectivity::Four => 4,
            Connectivity::Eight => 8,
        }
    }

    #[getter]
    fn detection_threshold(&self) -> f64 {
        self.inner().mission().detection_threshold
    }

    #[getter]
    fn traversable<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<bool>> {
        self.cells(py, |cell| self.inner().terrain().is_traversable(cell))
    }

    #[getter]
    fn searched<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<bool>> {
        self.cells(py, |cell| self.inner().terrain().is_searched(cell))
    }

    #[getter]
    fn prior<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.cells(py, |cell| self.inner().prior().probability(cell))
    }

    /// Moves between cells by index, shape `[2, moves]`, and their lengths in cells, shape `[moves, 1]`.
    fn edges<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray2<i64>>, Bound<'py, PyArray2<f32>>) {
        let grid = self.inner().terrain().grid();
        let of_cell = |from: Cell| {
            let steps = (0..self.field.step_count()).filter_map(move |step| self.field.neighbor(from, step));
            steps.map(move |to| (from, to))
        };
        let moves: Vec<(Cell, Cell)> = grid.cells().flat_map(of_cell).collect();
        let ends = Array2::from_shape_fn((2, moves.len()), |(end, edge)| {
            let (from, to) = moves[edge];
            i64::from(if end == 0 { from } else { to }.number())
        });
        #[expect(clippy::cast_possible_truncation, reason = "1 or the root of 2")]
        let length = |(edge, _): (usize, usize)| grid.offset(moves[edge].0, moves[edge].1).euclidean() as f32;
        (ends.to_pyarray(py), Array2::from_shape_fn((moves.len(), 1), length).to_pyarray(py))
    }

    fn __repr__(&self) -> String {
        format!("Scenario({:?}, {} x {} cells)", self.name(), self.rows(), self.columns())
    }
}

/// Name and summary of each scenario that comes with the package, in the order in which they are listed.
#[pyfunction]
pub(crate) fn scenarios() -> Vec<(&'static str, String)> {
    ShippedScenario::all().map(|scenario| (scenario.name(), scenario.summary())).collect()
}

/// A policy, with parameters in parentheses as the command line takes them.
pub(crate) fn policy_field(text: &str) -> PyResult<PolicyField> {
    text.parse().map_err(|error: dragnet_scenario::PolicyTextError| PyValueError::new_err(error.to_string()))
}

/// A missing file is an `OSError`, anything else a `ValueError`.
pub(crate) fn refused(error: &ScenarioError) -> PyErr {
    match error {
        ScenarioError::Missing { source, .. } | ScenarioError::Read { source, .. } => {
            std::io::Error::new(source.kind(), error.to_string()).into()
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}
