//! Files of weights and of demonstrations: they are read as written, and errors are reported.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod demonstrations;
mod parts;
mod weights;
