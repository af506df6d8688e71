//! Which part of a path keeps a robot apart from its teammates, by their plans, and where it is out of their way.
//!
//! Robots do not negotiate. A robot that decides later keeps out of the way of plans that it knows; the paths themselves stay those
//! of the policy, cut before they come too near. Times are predictions: what they miss, vehicles do by stopping.

use dragnet_search::cell::{Cell, Grid};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::separation::{Separation, swept};

/// Cells of a path that are compared with the plans of others, in each cell that the robot enters: who looks farther ahead waits
/// more often for robots that will be gone.
pub(crate) const AHEAD: usize = 2;
/// Cells that are tried as places out of the way, the nearest first.
const PLACES: usize = 64;

/// What is known of another robot's way.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Other {
    /// The cell that it was in last.
    pub(crate) cell: Cell,
    /// Cells that it is to enter from there; empty: it stands.
    pub(crate) path: Vec<Cell>,
    /// How long ago it entered its cell, seconds.
    pub(crate) elapsed: f64,
    /// Time from a cell to the next beside it, seconds.
    pub(crate) step: f64,
}

/// Where one robot is over some time, in cells.
struct Stay {
    cells: Vec<Cell>,
    /// From and to, seconds from now.
    during: (f64, f64),
}

/// Keeps one robot apart from the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clearance<'a> {
    pub(crate) grid: Grid,
    pub(crate) separation: Separation,
    pub(crate) others: &'a [Other],
    /// Time from a cell to the next beside it, seconds.
    pub(crate) step: f64,
}

impl Clearance<'_> {
    /// How many of the first cells of a path the robot can enter without coming too near to any other, as far as it compares.
    pub(crate) fn clear_cells(&self, from: Cell, path: &[Cell]) -> usize {
        let ahead = &path[..path.len().min(AHEAD)];
        let mut own = stays(self.grid, from, ahead, (self.step, 0.0));
        // It may leave a cell that another is about to enter.
        if let Some(first) = own.first_mut() {
            first.cells.retain(|&cell| cell != from);
        }
        let is_blocked = |stay: &Stay| {
            self.others.iter().any(|other| {
                let margin = self.step.max(other.step);
                let mut theirs = stays(self.grid, other.cell, &other.path, (other.step, other.elapsed));
                // Where it goes next is not known.
                if let Some(last) = theirs.last_mut() {
                    last.during.1 = f64::INFINITY;
                }
                theirs.iter().any(|their| {
                    let is_at_once =
                        their.during.0 <= stay.during.1 + margin && stay.during.0 <= their.during.1 + margin;
                    is_at_once && !self.separation.are_apart(self.grid, &stay.cells, &their.cells)
                })
            })
        };
        match own.iter().position(is_blocked) {
            Some(clear) => clear,
            None => path.len(),
        }
    }

    /// Whether another robot that moves is soon to pass a cell.
    pub(crate) fn is_in_the_way(&self, cell: Cell) -> bool {
        let passes = |other: &Other| {
            other.path.iter().take(AHEAD).any(|&their| !self.separation.is_apart(self.grid, their, cell))
        };
        self.others.iter().any(passes)
    }

    /// The way to the nearest cell that no plan leads past; empty if none is found.
    pub(crate) fn way_aside(&self, ways: &ShortestPathTree) -> Vec<Cell> {
        let is_aside = |&&cell: &&Cell| {
            self.others.iter().all(|other| {
                let all = other.path.iter().chain([&other.cell]);
                all.copied().all(|their| self.separation.is_apart(self.grid, their, cell))
            })
        };
        let mut paths = ways.candidates().iter().filter(is_aside).take(PLACES).map(|&cell| ways.path(cell));
        // One on the robot's side of those who come.
        paths.find(|path| self.clear_cells(ways.root(), path) > 0).unwrap_or_default()
    }
}

/// A robot's stays on its path at this time a cell: each move, from the time that it begins.
fn stays(grid: Grid, from: Cell, path: &[Cell], (step, elapsed): (f64, f64)) -> Vec<Stay> {
    let (mut here, mut time) = (from, -elapsed);
    let mut stays = Vec::with_capacity(path.len());
    for &next in path {
        // Who is late goes on now.
        let arrival = (time + step * grid.offset(here, next).euclidean()).max(0.0);
        stays.push(Stay { cells: swept(grid, here, next), during: (time, arrival) });
        (here, time) = (next, arrival);
    }
    stays
}
