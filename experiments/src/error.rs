//! What can go wrong with an experiment.

use std::fmt;

/// Why an experiment has no results.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// What was asked for cannot be done, or the files that it needs are not what they should be.
    #[error("{0}")]
    Input(String),
    /// It could be done, and it went wrong.
    #[error("{0}")]
    Run(String),
}

impl ExperimentError {
    pub(crate) fn input(message: impl fmt::Display) -> Self {
        Self::Input(message.to_string())
    }

    pub(crate) fn run(message: impl fmt::Display) -> Self {
        Self::Run(message.to_string())
    }
}
