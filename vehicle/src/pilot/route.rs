//! The agent's route: the cells still to be entered.

use dragnet_search::cell::{Cell, Grid, Offset};

/// Distance from its route at which a vehicle has left it.
const LEFT_CELLS: u32 = 2;

/// Cells to enter, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Route {
    cells: Vec<Cell>,
    /// Number of `cells` that were entered or skipped.
    done: usize,
}

impl Route {
    pub(super) const fn new(cells: Vec<Cell>) -> Self {
        Self { cells, done: 0 }
    }

    fn rest(&self) -> &[Cell] {
        &self.cells[self.done..]
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest().is_empty()
    }

    pub(super) fn contains(&self, cell: Cell) -> bool {
        self.rest().contains(&cell)
    }

    /// Marks a cell as entered, and those before it as passed; returns whether it is on the route.
    pub(super) fn enter(&mut self, cell: Cell) -> bool {
        let place = self.rest().iter().position(|&next| next == cell);
        self.done += place.map_or(0, |place| place + 1);
        place.is_some()
    }

    /// Whether a cell is too far from all remaining ones; true if none remain.
    pub(super) fn is_left(&self, grid: Grid, cell: Cell) -> bool {
        let is_far = |&next: &Cell| {
            let Offset { north, east } = grid.offset(cell, next);
            north.unsigned_abs().max(east.unsigned_abs()) > LEFT_CELLS
        };
        self.rest().iter().all(is_far)
    }

    /// Number of the next cells in one direction, from the vehicle's cell.
    fn run_length(&self, grid: Grid, here: Option<Cell>) -> usize {
        let rest = self.rest();
        let (Some(here), Some(&first)) = (here, rest.first()) else { return rest.len().min(1) };
        let direction = grid.offset(here, first);
        1 + rest.windows(2).take_while(|pair| grid.offset(pair[0], pair[1]) == direction).count()
    }

    /// The cells of the next straight run, at least one, and the direction into the last, radians.
    pub(super) fn run(&self, grid: Grid, here: Option<Cell>) -> Option<(&[Cell], f64)> {
        let run = &self.rest()[..self.run_length(grid, here)];
        let (&target, before) = run.split_last()?;
        let before = before.last().copied().or(here).unwrap_or(target);
        let Offset { north, east } = grid.offset(before, target);
        Some((run, f64::from(north).atan2(f64::from(east))))
    }

    /// Skips the next straight run.
    pub(super) fn skip_run(&mut self, grid: Grid, here: Option<Cell>) {
        self.done += self.run_length(grid, here);
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Position;

    use super::*;

    fn cells(places: &[(u32, u32)]) -> Vec<Cell> {
        let grid = Grid::new(9, 9).unwrap();
        places.iter().map(|&(row, column)| grid.cell(Position { row, column }).unwrap()).collect()
    }

    #[test]
    fn a_route_is_driven_in_straight_runs() {
        let grid = Grid::new(9, 9).unwrap();
        let path = cells(&[(0, 0), (0, 1), (0, 2), (1, 3), (2, 4), (3, 4)]);
        let mut route = Route::new(path[1..].to_vec());
        let mut here = path[0];
        for (end, degrees) in [(2, 0.0), (4, 45.0), (5, 90.0)] {
            let (run, heading) = route.run(grid, Some(here)).unwrap();
            let target = run[run.len() - 1];
            assert_eq!((target, heading.to_degrees().round()), (path[end], degrees));
            assert!(route.enter(target));
            here = target;
        }
        assert!(route.is_empty() && route.run(grid, Some(here)).is_none());
    }

    #[test]
    fn cells_beside_the_route_are_not_on_it_and_far_ones_have_left_it() {
        let grid = Grid::new(9, 9).unwrap();
        let mut route = Route::new(cells(&[(0, 1), (0, 2), (0, 3)]));
        for (place, left) in [((1, 1), false), ((2, 5), false), ((3, 1), true)] {
            let cell = cells(&[place])[0];
            assert_eq!((route.enter(cell), route.is_left(grid, cell)), (false, left), "{place:?}");
        }
        assert!(route.enter(cells(&[(0, 2)])[0]), "a corner was cut");
        assert!(!route.contains(cells(&[(0, 1)])[0]));
    }
}
