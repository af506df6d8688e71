//! The simulator and the policies for Python: a thin layer without algorithms of its own.
//!
//! Users import the package `dragnet` beside this crate; it has the interfaces of Gymnasium and `PettingZoo`, checks
//! types and shapes, and keeps these classes private:
//!
//! - `scenario`: a scenario, checked;
//! - `batch`: many searches of one robot each, stepped in parallel, with arrays that stay in place;
//! - `team`: the same of teams, stepped by one move of every robot at a time;
//! - `lanes`, `actions`, `arrays`, `measures`: what both are made of;
//! - `pool`: threads that survive `fork`;
//! - `policy`, `compare`, `benchmark`, `recording`: decisions, comparisons, results on frozen tracks, and recordings;
//! - `callable`: a policy that is a callable in Python.
//!
//! The interpreter lock is released while a search advances.

mod actions;
mod arrays;
mod batch;
mod benchmark;
mod callable;
mod choice;
mod compare;
mod lanes;
mod measures;
mod policy;
mod pool;
mod recording;
mod scenario;
mod team;

/// The native part of the package `dragnet`; private.
#[pyo3::pymodule]
mod _dragnet {
    #[pymodule_export]
    use crate::batch::Batch;
    #[pymodule_export]
    use crate::benchmark::{BenchmarkResult, Track, benchmark_tracks};
    #[pymodule_export]
    use crate::compare::{compare, policy_label};
    #[pymodule_export]
    use crate::measures::reasons;
    #[pymodule_export]
    use crate::policy::{Policy, policy_names};
    #[pymodule_export]
    use crate::recording::read_recording;
    #[pymodule_export]
    use crate::scenario::{Scenario, scenarios};
    #[pymodule_export]
    use crate::team::TeamBatch;

    /// Of the package, as Cargo has it.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
