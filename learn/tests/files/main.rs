//! Files of weights and of demonstrations: they are read as written, and errors are reported.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod demonstrations;
#[path = "../../../tests/mentions/mod.rs"]
mod mentions;
mod parts;
mod weights;
