//! Reporting of progress.

/// Receives the progress of long work.
pub trait Progress: Sync {
    /// Begins work of a number of steps; `unit` names a step, such as "episodes". The work ends when the returned value
    /// is dropped.
    fn begin(&self, steps: u64, unit: &str) -> Box<dyn Work>;
}

/// Work in progress.
pub trait Work: Sync {
    /// Reports further completed steps.
    fn advance(&self, steps: u64);

    /// Whether the work is no longer wanted: then no further step begins, and it ends as
    /// [`Cancelled`](crate::ExperimentError::Cancelled).
    fn is_cancelled(&self) -> bool {
        false
    }
}
