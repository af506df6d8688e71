//! The simulator and the policies as Python sees them: a thin layer without an algorithm of its own.
//!
//! The package `dragnet` beside this crate is what users import; it has the interfaces of Gymnasium and `PettingZoo`, checks
//! types and shapes, and keeps these classes to itself:
//!
//! - `scenario`: a scenario, checked;
//! - `batch`: many searches of one robot each, stepped side by side, seen in arrays that stay where they are;
//! - `team`: one search of a team;
//! - `pool`: threads that outlive `fork`;
//! - `policy`, `compare`, `recording`: decisions, comparisons and recordings.
//!
//! The interpreter is let go wherever a search moves on.

mod arrays;
mod batch;
mod choice;
mod compare;
mod policy;
mod pool;
mod recording;
mod scenario;
mod team;

/// What the package `dragnet` is built on; nothing here is for others.
#[pyo3::pymodule]
mod _dragnet {
    #[pymodule_export]
    use crate::batch::Batch;
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::policy::{Policy, policy_names};
    #[pymodule_export]
    use crate::recording::read_recording;
    #[pymodule_export]
    use crate::scenario::Scenario;
    #[pymodule_export]
    use crate::team::Team;
}
