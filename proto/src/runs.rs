//! Cells as runs of row-major numbers.

use dragnet_search::cell::Cell;

/// Neighbors in row-major order that are equal in something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run<T> {
    /// The number of its first cell.
    pub first: u32,
    /// Number of cells, at least 1.
    pub count: u32,
    /// What they are equal in.
    pub value: T,
}

/// The runs of cells that ascend.
#[must_use]
pub fn runs<T: PartialEq>(cells: impl IntoIterator<Item = (Cell, T)>) -> Vec<Run<T>> {
    let mut runs: Vec<Run<T>> = Vec::new();
    for (cell, value) in cells {
        match runs.last_mut() {
            Some(run) if run.first + run.count == cell.number() && run.value == value => run.count += 1,
            _ => runs.push(Run { first: cell.number(), count: 1, value }),
        }
    }
    runs
}
