//! The tracker against another's, and against the truth.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod consistency;
mod filterpy;
#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;
