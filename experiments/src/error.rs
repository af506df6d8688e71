//! Errors of experiments.

use std::fmt;

/// Why an experiment failed.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// The request or the files that it needs are invalid.
    #[error("{0}")]
    Input(String),
    /// The request is valid and its execution failed.
    #[error("{0}")]
    Run(String),
    /// The work was no longer wanted.
    #[error("cancelled")]
    Cancelled,
}

impl ExperimentError {
    pub(crate) fn input(message: impl fmt::Display) -> Self {
        Self::Input(message.to_string())
    }

    pub(crate) fn run(message: impl fmt::Display) -> Self {
        Self::Run(message.to_string())
    }
}
