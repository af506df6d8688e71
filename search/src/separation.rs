//! How far apart robots keep, on the grid.

use crate::cell::{Cell, Grid, Position};
use crate::route::ShortestPathTree;

/// The separation of a team: how many cells lie at least between the centers of two robots, along rows or columns.
///
/// A robot is in one cell while it stands, and in all cells of [`swept`] while it moves. If those of any two robots are apart at
/// all times ([`Separation::are_apart`]), the straight-line distance of their centers is never below the separation: the cells
/// of a move fill a box, and of two boxes of cells the distance along one axis at least is that of two of their cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Separation {
    cells: u32,
}

impl Separation {
    /// Robots may be in one cell at one time.
    pub const NONE: Self = Self { cells: 0 };

    /// The least separation, in whole cells, whose distance is at least `meters`; of no meters, [`Separation::NONE`]. Both
    /// are finite and at least 0, a cell's edge above it.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it saturates")]
    pub fn of_meters(meters: f64, cell_meters: f64) -> Self {
        Self { cells: (meters / cell_meters).ceil() as u32 }
    }

    /// Cells between the centers of two robots; 0: robots may be in one cell.
    #[must_use]
    pub const fn cells(self) -> u32 {
        self.cells
    }

    /// Whether robots keep apart at all.
    #[must_use]
    pub const fn is_kept(self) -> bool {
        self.cells > 0
    }

    /// The separation with this number of cells more.
    #[must_use]
    pub const fn wider(self, by: u32) -> Self {
        Self { cells: self.cells.saturating_add(by) }
    }

    /// Whether two cells are as far apart as two robots have to be.
    #[must_use]
    pub fn is_apart(self, grid: Grid, a: Cell, b: Cell) -> bool {
        let offset = grid.offset(a, b);
        offset.north.unsigned_abs().max(offset.east.unsigned_abs()) >= self.cells
    }

    /// Whether each cell of one robot is apart from each of another.
    #[must_use]
    pub fn are_apart(self, grid: Grid, a: &[Cell], b: &[Cell]) -> bool {
        a.iter().all(|&a| b.iter().all(|&b| self.is_apart(grid, a, b)))
    }

    /// The first cell on the shortest paths from a cell, itself included, that is apart from all of these; `None`: there is none.
    #[must_use]
    pub fn first_apart(self, grid: Grid, routes: &ShortestPathTree, taken: &[Cell]) -> Option<Cell> {
        let is_free = |&cell: &Cell| taken.iter().all(|&other| self.is_apart(grid, cell, other));
        routes.reached().iter().copied().find(is_free)
    }

    /// Cells in which no other robot may be while one is in this cell, which is one of them.
    pub fn around(self, grid: Grid, cell: Cell) -> impl Iterator<Item = Cell> {
        let Position { row, column } = grid.position(cell);
        let reach = self.cells.saturating_sub(1);
        let span = |center: u32, size: u32| {
            center.saturating_sub(reach)..=(center.saturating_add(reach)).min(size - 1)
        };
        let rows = if self.is_kept() { Some(span(row, grid.rows())) } else { None };
        let columns = span(column, grid.columns());
        rows.into_iter().flatten().flat_map(move |row| {
            columns.clone().filter_map(move |column| grid.cell(Position { row, column }))
        })
    }
}

/// The cells of a move to a neighboring cell: both, and on a diagonal those beside it. Of a longer one only both ends.
#[must_use]
pub fn swept(grid: Grid, from: Cell, to: Cell) -> Vec<Cell> {
    let (a, b) = (grid.position(from), grid.position(to));
    let beside = [Position { row: a.row, column: b.column }, Position { row: b.row, column: a.column }];
    let offset = grid.offset(from, to);
    let is_diagonal = offset.north.abs() == 1 && offset.east.abs() == 1;
    let beside = beside.into_iter().filter(|_| is_diagonal).filter_map(|it| grid.cell(it));
    let mut cells: Vec<Cell> = [from, to].into_iter().chain(beside).collect();
    cells.dedup();
    cells
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn grid() -> Grid {
        Grid::new(7, 6).unwrap()
    }

    fn cell(row: u32, column: u32) -> Cell {
        grid().cell(Position { row, column }).unwrap()
    }

    #[test]
    fn meters_are_whole_cells() {
        let cells = |meters| Separation::of_meters(meters, 2.0).cells();
        assert_eq!([0.0, 0.1, 2.0, 2.1, 1e300].map(cells), [0, 1, 1, 2, u32::MAX]);
        assert_eq!(Separation::of_meters(0.0, 2.0), Separation::NONE);
        assert!(Separation::NONE.is_apart(grid(), cell(1, 1), cell(1, 1)));
        assert_eq!(Separation::of_meters(1e300, 2.0).around(grid(), cell(1, 1)).count(), 42);
        assert_eq!(Separation::NONE.around(grid(), cell(1, 1)).count(), 0);
    }

    #[test]
    fn cells_around_a_robot_are_those_that_are_not_apart() {
        for cells in 0..4 {
            let separation = Separation { cells };
            for from in grid().cells() {
                let around: Vec<Cell> = separation.around(grid(), from).collect();
                let near: Vec<Cell> =
                    grid().cells().filter(|&to| !separation.is_apart(grid(), from, to)).collect();
                assert_eq!(around, near, "{cells} cells around {from:?}");
            }
        }
    }

    /// Two points that move along their edges at any speeds: the nearest that they can come.
    fn nearest(a: (Cell, Cell), b: (Cell, Cell)) -> f64 {
        let point = |(from, to): (Cell, Cell), share: f64| {
            let [from, to] = [from, to].map(|it| grid().position(it));
            let between = |from: u32, to: u32| f64::from(from) + share * (f64::from(to) - f64::from(from));
            (between(from.row, to.row), between(from.column, to.column))
        };
        let shares = || (0..=20).map(|part| f64::from(part) / 20.0);
        let distance = |(here, there): (f64, f64)| {
            let (a, b) = (point(a, here), point(b, there));
            (a.0 - b.0).hypot(a.1 - b.1)
        };
        shares()
            .flat_map(|here| shares().map(move |there| (here, there)))
            .map(distance)
            .fold(f64::INFINITY, f64::min)
    }

    proptest! {
        #[test]
        fn moves_that_are_apart_never_bring_two_robots_nearer(
            cells in 1_u32..4,
            (a, b) in (0_u32..42, 0_u32..42),
            (to_a, to_b) in ((-1_i32..=1, -1_i32..=1), (-1_i32..=1, -1_i32..=1)),
        ) {
            let separation = Separation { cells };
            let edge = |from: u32, (north, east): (i32, i32)| {
                let from = grid().cell_numbered(from)?;
                Some((from, grid().step(from, crate::cell::Offset { north, east })?))
            };
            let (Some(a), Some(b)) = (edge(a, to_a), edge(b, to_b)) else { return Ok(()) };
            let is_apart = separation.are_apart(grid(), &swept(grid(), a.0, a.1), &swept(grid(), b.0, b.1));
            if is_apart {
                prop_assert!(nearest(a, b) >= f64::from(cells) - 1e-9);
            }
        }
    }
}
