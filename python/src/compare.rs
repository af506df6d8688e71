//! Policies against each other, as the command line compares them, and policies written in Python among them.

use std::sync::Arc;

use dragnet_scenario::file::PolicyField;
use dragnet_search::policy::Policy;
use dragnet_search::utility::UtilityTable;
use dragnet_sim::comparison::{self, Difference, Row, Setting, Trial, Verdict};
use dragnet_sim::single_robot_env::Field;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::callable::{Callable, Caller, Interface};
use crate::pool;
use crate::scenario::{Scenario, policy_field, refused};

/// A policy as Python passes it: its label, and its text or what decides.
#[derive(FromPyObject)]
pub(crate) enum Competitor {
    Named(String, String),
    Callable(String, Py<PyAny>),
}

/// One policy on one scenario.
pub(crate) struct Case {
    setting: Setting,
    field: Arc<Field>,
    scenario: dragnet_scenario::Scenario,
    /// What decides, if it is in Python.
    callable: Option<Arc<Callable>>,
}

/// A table, a dictionary for each row.
type Rows<'py> = Vec<Bound<'py, PyDict>>;

/// Runs every policy on every scenario with every seed; returns a row each, with the columns of the command line's
/// `summary.csv`, and the differences to the baseline, by default the first policy, with those of `differences.csv`.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scenarios: Vec<Bound<'py, Scenario>>,
    policies: Vec<Competitor>,
    seeds: Vec<u64>,
    baseline: Option<String>,
    interface: Interface,
) -> PyResult<(Rows<'py>, Rows<'py>)> {
    if seeds.is_empty() {
        return Err(PyValueError::new_err("no seed; allowed is at least one"));
    }
    let labels = policies.iter().map(Competitor::label);
    let baseline = comparison::baseline(labels, baseline.as_deref()).map_err(|allowed| {
        PyValueError::new_err(format!("baseline={}; {allowed}", baseline.as_deref().unwrap_or_default()))
    })?;
    let mut cases = Vec::new();
    for scenario in &scenarios {
        for policy in &policies {
            cases.push(case(py, scenario.get(), policy, &interface)?);
        }
    }
    // Shared tables are built before any decision is timed.
    let _ = UtilityTable::information();
    let threads = pool::threads(py);
    let mut rows = Vec::new();
    for case in &cases {
        rows.push(if case.callable.is_some() {
            case.call(py, &seeds)?
        } else {
            let row = py.detach(|| match &threads {
                Some(threads) => threads.install(|| case.run_side_by_side(&seeds)),
                None => case.run(&seeds),
            });
            row.map_err(PyRuntimeError::new_err)?
        });
    }
    let differences = comparison::differences(&rows, baseline);
    Ok((
        rows.iter().map(|row| columns(py, row)).collect::<PyResult<_>>()?,
        differences.iter().map(|it| difference_columns(py, it)).collect::<PyResult<_>>()?,
    ))
}

/// The text of a policy as tables name it.
#[pyfunction]
pub(crate) fn policy_label(text: &str) -> PyResult<String> {
    Ok(policy_field(text)?.to_string())
}

/// A policy on a scenario.
pub(crate) fn case(
    py: Python<'_>,
    scenario: &Scenario,
    policy: &Competitor,
    interface: &Interface,
) -> PyResult<Case> {
    let of_robots = |field: PolicyField| scenario.inner().with_policy(field).map_err(|error| refused(&error));
    let (scenario_of_case, callable) = match policy {
        Competitor::Named(_, text) => (of_robots(policy_field(text)?)?, None),
        Competitor::Callable(_, decide) => {
            // One that decides at its waypoints only; what decides in its place is the callable.
            let scenario_of_case = of_robots(policy_field("greedy")?)?;
            let callable = Callable::new(py, decide, &*scenario.field()?, interface)?;
            (scenario_of_case, Some(Arc::new(callable)))
        }
    };
    Ok(Case {
        setting: Setting::new(&scenario_of_case, policy.label().to_owned()),
        field: scenario.shared(),
        scenario: scenario_of_case,
        callable,
    })
}

impl Competitor {
    fn label(&self) -> &str {
        match self {
            Self::Named(label, _) | Self::Callable(label, _) => label,
        }
    }
}

impl Case {
    /// Runs episodes in parallel, as many at a time as there are threads.
    fn run_side_by_side(&self, seeds: &[u64]) -> Result<Row, String> {
        self.row(seeds.par_iter().map(|&seed| self.trial(seed)).collect())
    }

    fn run(&self, seeds: &[u64]) -> Result<Row, String> {
        self.row(seeds.iter().map(|&seed| self.trial(seed)).collect())
    }

    fn trial(&self, seed: u64) -> Result<Trial, String> {
        comparison::run(&self.setting, &self.scenario, seed).map_err(|error| error.to_string())
    }

    /// Runs episodes one after the other, since there is one interpreter; the first exception ends them.
    fn call(&self, py: Python<'_>, seeds: &[u64]) -> PyResult<Row> {
        let trials = seeds.iter().map(|&seed| self.call_once(py, seed)).collect::<PyResult<_>>()?;
        Ok(Row::new(&self.setting, trials))
    }

    /// Runs the episode of a seed; its first exception ends it.
    pub(crate) fn call_once(&self, py: Python<'_>, seed: u64) -> PyResult<Trial> {
        let Some(callable) = &self.callable else {
            return self.trial(seed).map_err(PyRuntimeError::new_err);
        };
        py.check_signals()?;
        callable.reset(py, seed)?;
        let caller =
            |robot| -> Box<dyn Policy + Send> { Box::new(Caller::new(callable, &self.field, seed, robot)) };
        let trial = comparison::run_with(&self.setting, &self.scenario, seed, caller);
        if let Some(failure) = callable.failure() {
            return Err(failure);
        }
        trial.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    fn row(&self, trials: Result<Vec<Trial>, String>) -> Result<Row, String> {
        trials.map(|trials| Row::new(&self.setting, trials))
    }
}

fn columns<'py>(py: Python<'py>, row: &Row) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("scenario", &row.scenario)?;
    columns.set_item("map", &row.map)?;
    columns.set_item("policy", &row.policy)?;
    columns.set_item("robots", row.robots)?;
    columns.set_item("seeds", row.seeds)?;
    columns.set_item("budget_cells", row.budget_cells)?;
    columns.set_item("auc_f1_mean", row.auc_f1.mean)?;
    columns.set_item("auc_f1_sem", row.auc_f1.sem)?;
    columns.set_item("average_recall_mean", row.average_recall.mean)?;
    columns.set_item("average_recall_sem", row.average_recall.sem)?;
    let full = &row.cells_to_full_recall;
    columns.set_item("cells_to_full_recall_mean", full.mean)?;
    columns.set_item("cells_to_full_recall_sem", full.sem)?;
    columns.set_item("cells_to_full_recall_reached", full.reached)?;
    columns.set_item("cells_to_full_recall_restricted_mean", full.restricted_mean)?;
    columns.set_item("cells_to_full_recall_restricted_sem", full.restricted_sem)?;
    for part in &row.cells_to_recall {
        let percent = part.recall * 100.0;
        columns.set_item(format!("cells_to_{percent:.0}_recall_restricted_mean"), part.restricted_mean)?;
    }
    columns.set_item("remaining_mean", row.remaining.mean)?;
    columns.set_item("remaining_sem", row.remaining.sem)?;
    columns.set_item("expected_remaining_mean", row.expected_remaining.mean)?;
    columns.set_item("expected_remaining_sem", row.expected_remaining.sem)?;
    columns.set_item("seeds_with_remaining", row.seeds_with_remaining)?;
    columns.set_item("seeds_without_object", row.seeds_without_object)?;
    columns.set_item("tail_s_mean", row.tail_s.mean)?;
    columns.set_item("tail_s_sem", row.tail_s.sem)?;
    columns.set_item("decision_ms_p50", row.decision_ms.p50)?;
    columns.set_item("decision_ms_p99", row.decision_ms.p99)?;
    Ok(columns)
}

fn difference_columns<'py>(py: Python<'py>, difference: &Difference) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("scenario", &difference.scenario)?;
    columns.set_item("policy", &difference.policy)?;
    columns.set_item("baseline", &difference.baseline)?;
    let intervals = [
        ("cells_to_full_recall", difference.cells_to_full_recall),
        ("average_recall", difference.average_recall),
        ("auc_f1", difference.auc_f1),
    ];
    for (name, interval) in intervals {
        columns.set_item(format!("{name}_mean"), interval.mean)?;
        columns.set_item(format!("{name}_low"), interval.low)?;
        columns.set_item(format!("{name}_high"), interval.high)?;
        columns.set_item(format!("{name}_verdict"), interval.verdict.map(Verdict::as_str))?;
    }
    Ok(columns)
}
