//! The benchmark's tracks and results, with policies written in Python among those that are measured.

use std::path::PathBuf;

use dragnet_experiments::ExperimentError;
use dragnet_experiments::benchmark::verify::{self, DifferentEpisode, Place, Sample};
use dragnet_experiments::benchmark::{
    self, Decider, Entry, EpisodeResult, Interface, PolicyResult, Program, Summary,
};
use dragnet_experiments::comparison::{self, Trial};
use dragnet_experiments::progress::{Progress, Work};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::callable;
use crate::compare::{self, Competitor};
use crate::scenario::{Scenario, policy_field};

/// A policy as Python passes it: its label, and its text or a callable for each search.
#[derive(FromPyObject)]
pub(crate) enum Measured {
    Named(String, String),
    Callable(String, Vec<Py<PyAny>>),
}

/// Name, version, summary and number of episodes of each track.
#[pyfunction]
pub(crate) fn benchmark_tracks() -> PyResult<Vec<(&'static str, u32, &'static str, usize)>> {
    let of = |name| {
        let track = benchmark::Track::named(name).map_err(refused)?;
        Ok((name, track.version(), track.about(), track.episodes().count()))
    };
    benchmark::Track::names().map(of).collect()
}

/// A track.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct Track {
    inner: benchmark::Track,
    scenarios: Vec<Scenario>,
}

/// The results of policies on a track.
#[pyclass(frozen, module = "dragnet._dragnet")]
pub(crate) struct BenchmarkResult {
    inner: benchmark::BenchmarkResult,
}

#[pymethods]
impl Track {
    #[new]
    fn new(name: &str) -> PyResult<Self> {
        let inner = benchmark::Track::named(name).map_err(refused)?;
        let scenarios = inner.searches().iter().map(|it| Scenario::new(it.scenario.clone())).collect();
        Ok(Self { inner, scenarios })
    }

    /// The scenario of each search.
    fn scenarios(&self) -> Vec<Scenario> {
        self.scenarios.clone()
    }

    #[getter]
    fn digest(&self) -> String {
        self.inner.digest().to_string()
    }

    /// Runs every policy on every episode: named ones on all cores, callables on one.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn run(
        &self,
        py: Python<'_>,
        policies: Vec<Measured>,
        interface: callable::Interface,
    ) -> PyResult<BenchmarkResult> {
        let entries = policies.iter().map(|it| it.entry(&interface)).collect::<PyResult<Vec<_>>>()?;
        let mut results = Vec::new();
        for (policy, entry) in policies.iter().zip(entries) {
            let episodes: Vec<(usize, u64)> = self.inner.episodes().collect();
            let trials = self.trials(py, &entry, policy, &interface, &episodes)?;
            results.push((entry, trials));
        }
        Ok(BenchmarkResult { inner: benchmark::BenchmarkResult::new(&self.inner, program(), results) })
    }
}

impl Track {
    /// Runs these episodes, each by the index of its search and its seed.
    fn trials(
        &self,
        py: Python<'_>,
        entry: &Entry,
        policy: &Measured,
        interface: &callable::Interface,
        episodes: &[(usize, u64)],
    ) -> PyResult<Vec<Trial>> {
        let Measured::Callable(name, callables) = policy else {
            let cases = entry.cases(&self.inner, None).map_err(refused)?;
            let episodes: Vec<_> = episodes.iter().map(|&(search, seed)| (&cases[search], seed)).collect();
            let done = py.detach(|| comparison::run_episodes(&episodes, None, &Unseen));
            return Ok(done.map_err(refused)?.results);
        };
        let cases = self.scenarios.iter().zip(callables).map(|(scenario, callable)| {
            let competitor = Competitor::Callable(name.clone(), callable.clone_ref(py));
            compare::case(py, scenario, &competitor, interface)
        });
        let cases = cases.collect::<PyResult<Vec<_>>>()?;
        episodes.iter().map(|&(search, seed)| cases[search].call_once(py, seed)).collect()
    }
}

#[pymethods]
impl BenchmarkResult {
    /// Reads a file, and checks that it is whole, unchanged, of this version, and of a track as this version has it.
    #[staticmethod]
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn read(path: PathBuf) -> PyResult<Self> {
        let (inner, _) = benchmark::BenchmarkResult::read(&path, &program()).map_err(refused)?;
        Ok(Self { inner })
    }

    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn write(&self, path: PathBuf) -> PyResult<()> {
        self.inner.write(&path).map_err(|error| std::io::Error::other(error.to_string()).into())
    }

    fn json(&self) -> PyResult<String> {
        self.inner.to_json().map_err(refused)
    }

    #[getter]
    fn track(&self) -> &str {
        self.inner.track_name()
    }

    #[getter]
    fn digest(&self) -> &str {
        self.inner.digest()
    }

    /// The name of each policy; and of a callable observation, frame and control.
    fn policies(&self) -> Vec<(String, Option<callable::Interface>)> {
        let of = |policy: &PolicyResult| {
            let interface = match &policy.decider {
                Decider::Policy { .. } => None,
                Decider::Callable(it) => Some((it.observation.clone(), it.frame.clone(), it.control.clone())),
            };
            (policy.name.clone(), interface)
        };
        self.inner.policies.iter().map(of).collect()
    }

    /// A row for each policy and group of searches.
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let rows = self.inner.policies.iter().flat_map(|policy| {
            policy.summary.iter().map(move |summary| summary_columns(py, &policy.name, summary))
        });
        rows.collect()
    }

    /// Runs its episodes again, or a sample of them; returns those that differ. `callables` has one for each search, by
    /// policy that is a callable.
    #[expect(clippy::needless_pass_by_value, reason = "it comes from Python")]
    fn verify<'py>(
        &self,
        py: Python<'py>,
        callables: Vec<(String, Vec<Py<PyAny>>)>,
        sample: Option<u64>,
        seed: u64,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let track = Track::new(self.inner.track_name())?;
        let episodes: Vec<(usize, u64)> = track.inner.episodes().collect();
        let sample = sample.map(|count| Sample { count, seed });
        let places = verify::places(&self.inner, sample).map_err(refused)?;
        let mut differing = Vec::new();
        for (index, policy) in self.inner.policies.iter().enumerate() {
            let of_policy: Vec<Place> = places.iter().copied().filter(|it| it.policy == index).collect();
            let drawn: Vec<(usize, u64)> = of_policy.iter().map(|it| episodes[it.episode]).collect();
            let (measured, interface) = again(py, policy, &callables)?;
            let trials = track.trials(py, &policy.entry(), &measured, &interface, &drawn)?;
            for ((place, trial), (search, _)) in of_policy.into_iter().zip(&trials).zip(drawn) {
                let search = track.inner.searches()[search].scenario.name();
                let found = EpisodeResult::new(search, trial);
                differing.extend(verify::difference(&self.inner, place, found));
            }
        }
        differing.iter().map(|it| difference_columns(py, it)).collect()
    }
}

impl Measured {
    fn entry(&self, (observation, frame, control): &callable::Interface) -> PyResult<Entry> {
        match self {
            Self::Named(name, text) => {
                Entry::of_policy(name.clone(), &policy_field(text)?, None).map_err(refused)
            }
            Self::Callable(name, _) => Ok(Entry {
                name: name.clone(),
                decider: Decider::Callable(Interface {
                    observation: observation.clone(),
                    frame: frame.clone(),
                    control: control.clone(),
                }),
            }),
        }
    }
}

/// What decides again in a verification.
fn again(
    py: Python<'_>,
    policy: &PolicyResult,
    callables: &[(String, Vec<Py<PyAny>>)],
) -> PyResult<(Measured, callable::Interface)> {
    let name = policy.name.clone();
    match &policy.decider {
        Decider::Policy { policy, .. } => Ok((Measured::Named(name, policy.clone()), Default::default())),
        Decider::Callable(Interface { observation, frame, control }) => {
            let (_, own) = callables.iter().find(|(of, _)| *of == name).ok_or_else(|| {
                PyValueError::new_err(format!("policy {name:?} is a callable; it is needed to verify it"))
            })?;
            let own = own.iter().map(|callable| callable.clone_ref(py)).collect();
            let interface = (observation.clone(), frame.clone(), control.clone());
            Ok((Measured::Callable(name, own), interface))
        }
    }
}

fn summary_columns<'py>(py: Python<'py>, policy: &str, summary: &Summary) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("policy", policy)?;
    columns.set_item("group", &summary.group)?;
    columns.set_item("episodes", summary.episodes)?;
    columns.set_item("reached", summary.reached)?;
    columns.set_item("cells_to_full_recall_restricted_mean", summary.cells_to_full_recall.mean)?;
    columns.set_item("cells_to_full_recall_restricted_sem", summary.cells_to_full_recall.sem)?;
    columns.set_item("average_recall_mean", summary.average_recall.mean)?;
    columns.set_item("average_recall_sem", summary.average_recall.sem)?;
    columns.set_item("decision_ms_p50", summary.decision_ms_p50)?;
    Ok(columns)
}

fn difference_columns<'py>(py: Python<'py>, different: &DifferentEpisode) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    columns.set_item("policy", &different.policy)?;
    columns.set_item("search", &different.claimed.search)?;
    columns.set_item("seed", different.claimed.seed)?;
    for (prefix, episode) in [("claimed", &different.claimed), ("found", &different.found)] {
        columns.set_item(format!("{prefix}_cells_to_full_recall"), episode.cells_to_full_recall)?;
        columns.set_item(format!("{prefix}_average_recall"), episode.average_recall)?;
        columns.set_item(format!("{prefix}_recall"), episode.recall)?;
    }
    Ok(columns)
}

/// The package does not know its commit.
fn program() -> Program {
    Program { version: env!("CARGO_PKG_VERSION").to_owned(), commit: None }
}

fn refused(error: ExperimentError) -> PyErr {
    match error {
        ExperimentError::Input(message) => PyValueError::new_err(message),
        other => PyRuntimeError::new_err(other.to_string()),
    }
}

/// Reports no progress.
struct Unseen;

impl Progress for Unseen {
    fn begin(&self, _steps: u64, _unit: &str) -> Box<dyn Work> {
        Box::new(Self)
    }
}

impl Work for Unseen {
    fn advance(&self, _steps: u64) {}
}
