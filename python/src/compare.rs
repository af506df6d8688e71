//! Policies against each other, as the command line compares them.

use dragnet_learn::policy::PolicyName;
use dragnet_search::information::InformationTable;
use dragnet_sim::comparison::{self, Row, Setting, Trial};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::pool;
use crate::scenario::{Scenario, refused};

/// One policy on one scenario.
struct Case {
    setting: Setting,
    scenario: dragnet_scenario::Scenario,
}

/// Runs every policy on every scenario with every seed; returns a row each, with the columns of the command line's
/// `summary.csv`.
#[pyfunction]
#[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    scenarios: Vec<Bound<'py, Scenario>>,
    policies: Vec<String>,
    seeds: Vec<u64>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    if seeds.is_empty() {
        return Err(PyValueError::new_err("no seed; allowed is at least one"));
    }
    let mut cases = Vec::new();
    for scenario in &scenarios {
        for policy in &policies {
            cases.push(case(scenario.get(), policy)?);
        }
    }
    // Shared tables are built before any decision is timed.
    let _ = InformationTable::shared();
    let threads = pool::threads(py);
    let rows = py.detach(|| {
        let rows = cases.iter().map(|case| match &threads {
            Some(threads) => threads.install(|| case.run_side_by_side(&seeds)),
            None => case.run(&seeds),
        });
        rows.collect::<Result<Vec<Row>, String>>()
    });
    rows.map_err(PyRuntimeError::new_err)?.iter().map(|row| columns(py, row)).collect()
}

fn case(scenario: &Scenario, policy: &str) -> PyResult<Case> {
    let name = policy.parse::<PolicyName>().map_err(|error| PyValueError::new_err(error.to_string()))?;
    let scenario = scenario.inner().with_policy(name).map_err(|error| refused(&error))?;
    Ok(Case { setting: Setting::new(&scenario, policy.to_owned()), scenario })
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
    columns.set_item("cells_to_full_recall_mean", row.cells_to_full_recall.mean)?;
    columns.set_item("cells_to_full_recall_sem", row.cells_to_full_recall.sem)?;
    columns.set_item("cells_to_full_recall_reached", row.cells_to_full_recall.reached)?;
    columns.set_item("remaining_mean", row.remaining.mean)?;
    columns.set_item("remaining_sem", row.remaining.sem)?;
    columns.set_item("expected_remaining_mean", row.expected_remaining.mean)?;
    columns.set_item("expected_remaining_sem", row.expected_remaining.sem)?;
    columns.set_item("seeds_with_remaining", row.seeds_with_remaining)?;
    columns.set_item("tail_s_mean", row.tail_s.mean)?;
    columns.set_item("tail_s_sem", row.tail_s.sem)?;
    columns.set_item("decision_ms_p50", row.decision_ms.p50)?;
    columns.set_item("decision_ms_p99", row.decision_ms.p99)?;
    Ok(columns)
}
