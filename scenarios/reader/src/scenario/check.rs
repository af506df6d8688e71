//! Checks of single values. Each error names the key, its value and the allowed values; NaN is never valid.

use std::fmt::Display;
use std::time::Duration;

use dragnet_search::cell::{Cell, Grid, Position};

use crate::toml_text::shortened;

/// An invalid value of a scenario.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} is {found}; allowed is {allowed}")]
pub struct Invalid {
    /// Path of the key, such as `network.partitions[0].groups`.
    pub key: String,
    /// The value.
    pub found: String,
    /// The allowed values.
    pub allowed: String,
}

impl Invalid {
    pub(super) fn new(key: impl Display, found: impl Display, allowed: impl Display) -> Self {
        Self { key: key.to_string(), found: shortened(&found.to_string()), allowed: allowed.to_string() }
    }
}

/// The longest time in a scenario, seconds: thirty years.
const MAX_SECONDS: f64 = 1e9;

pub(super) fn integer(key: impl Display, value: i64, low: u32, high: u32) -> Result<u32, Invalid> {
    u32::try_from(value)
        .ok()
        .filter(|value| (low..=high).contains(value))
        .ok_or_else(|| Invalid::new(key, value, format!("a whole number from {low} to {high}")))
}

/// A finite number from 0 to a largest one.
pub(super) fn at_least_zero(key: impl Display, value: f64, high: f64) -> Result<f64, Invalid> {
    check(key, value, (0.0..=high).contains(&value), || format!("from 0 to {high}"))
}

/// A number between two others, both included.
pub(super) fn within(key: impl Display, value: f64, low: f64, high: f64) -> Result<f64, Invalid> {
    check(key, value, (low..=high).contains(&value), || format!("from {low} to {high}"))
}

/// A number above 0, up to a maximum.
pub(super) fn positive(key: impl Display, value: f64, high: f64) -> Result<f64, Invalid> {
    check(key, value, value > 0.0 && value <= high, || format!("above 0, up to {high}"))
}

/// A number between two others, neither included.
pub(super) fn between(key: impl Display, value: f64, low: f64, high: f64) -> Result<f64, Invalid> {
    check(key, value, value > low && value < high, || format!("above {low} and below {high}"))
}

/// A probability of a fault.
pub(super) fn chance(key: impl Display, value: f64) -> Result<f64, Invalid> {
    check(key, value, (0.0..1.0).contains(&value), || "at least 0 and below 1".to_owned())
}

/// A time of at least 0 seconds.
pub(super) fn seconds(key: impl Display, value: f64) -> Result<Duration, Invalid> {
    at_least_zero(key, value, MAX_SECONDS).map(Duration::from_secs_f64)
}

/// A time above 0 seconds, at least the nanosecond that clocks count.
pub(super) fn positive_seconds(key: impl Display, value: f64) -> Result<Duration, Invalid> {
    let is_valid = (1e-9..=MAX_SECONDS).contains(&value);
    let allowed = || format!("from 0.000000001 to {MAX_SECONDS} seconds");
    check(key, value, is_valid, allowed).map(Duration::from_secs_f64)
}

/// The shortest period, seconds.
const MIN_PERIOD_SECONDS: f64 = 0.01;

/// A period that is long enough for a mission to make progress.
pub(super) fn period(key: impl Display, value: f64) -> Result<Duration, Invalid> {
    let is_valid = (MIN_PERIOD_SECONDS..=MAX_SECONDS).contains(&value);
    let allowed = || format!("from {MIN_PERIOD_SECONDS} to {MAX_SECONDS} seconds");
    check(key, value, is_valid, allowed).map(Duration::from_secs_f64)
}

/// A cell of the map, from `[row, column]`.
pub(super) fn cell(key: impl Display, [row, column]: [i64; 2], grid: Grid) -> Result<Cell, Invalid> {
    let position = u32::try_from(row).ok().zip(u32::try_from(column).ok());
    position.and_then(|(row, column)| grid.cell(Position { row, column })).ok_or_else(|| {
        let (rows, columns) = (grid.rows() - 1, grid.columns() - 1);
        let allowed = format!("[row, column] from [0, 0] to [{rows}, {columns}]");
        Invalid::new(key, format!("[{row}, {column}]"), allowed)
    })
}

fn check(
    key: impl Display,
    value: f64,
    is_valid: bool,
    allowed: impl Fn() -> String,
) -> Result<f64, Invalid> {
    if is_valid { Ok(value) } else { Err(Invalid::new(key, written(value), allowed())) }
}

/// A number as people write it: without hundreds of zeros.
pub(super) fn written(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() > 20 { format!("{value:e}") } else { plain }
}
