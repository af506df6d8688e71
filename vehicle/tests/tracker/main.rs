//! The tracker compared with another implementation, and with the truth.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod consistency;
mod filterpy;
#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;
