//! A mission of two robots on a drawn map, exported to every format and read by independent libraries.
#![expect(
    clippy::unwrap_used,
    reason = "a test fails by a panic; Clippy knows only functions marked as tests"
)]

mod account;
mod dates;
#[path = "../../../tests/python/interpreter.rs"]
mod interpreter;
mod marks;
mod mission;
mod plan;
mod positions;
mod readers;
mod verdicts;
mod zones;
