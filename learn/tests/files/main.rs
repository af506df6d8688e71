//! Files of weights and of demonstrations: they come back as they were, and what is wrong with one is said.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod demonstrations;
mod parts;
mod weights;
