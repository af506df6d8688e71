//! Maps that are mirrored, turned and moved.

use dragnet_search::cell::{Cell, Grid, Position};

/// Where the cells of a map go: mirrored, then turned, then moved by what is added around them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Motion {
    pub(crate) is_mirrored: bool,
    pub(crate) quarter_turns: u8,
    pub(crate) margin: Margin,
}

/// Rows and columns that are added on each side.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Margin {
    pub(crate) south: u32,
    pub(crate) west: u32,
    pub(crate) north: u32,
    pub(crate) east: u32,
}

impl Motion {
    /// All symmetries of a square, beginning with the identity.
    pub(crate) fn of_a_square() -> impl Iterator<Item = Self> {
        (0..8).map(|number| Self {
            is_mirrored: number >= 4,
            quarter_turns: number % 4,
            margin: Margin::default(),
        })
    }

    /// A different motion onto a map of the same size.
    pub(crate) const fn mistaken(self) -> Self {
        Self { is_mirrored: !self.is_mirrored, ..self }
    }

    pub(crate) fn grid(self, grid: Grid) -> Grid {
        let (rows, columns) = self.turned_size(grid);
        let Margin { south, west, north, east } = self.margin;
        Grid::new(south + rows + north, west + columns + east).unwrap()
    }

    pub(crate) fn cell(self, grid: Grid, cell: Cell) -> Cell {
        let Position { mut row, mut column } = grid.position(cell);
        let (mut rows, mut columns) = (grid.rows(), grid.columns());
        if self.is_mirrored {
            column = columns - 1 - column;
        }
        for _ in 0..self.quarter_turns {
            (row, column) = (column, rows - 1 - row);
            (rows, columns) = (columns, rows);
        }
        let moved = Position { row: row + self.margin.south, column: column + self.margin.west };
        self.grid(grid).cell(moved).unwrap()
    }

    const fn turned_size(self, grid: Grid) -> (u32, u32) {
        if self.quarter_turns.is_multiple_of(2) {
            (grid.rows(), grid.columns())
        } else {
            (grid.columns(), grid.rows())
        }
    }
}

#[test]
fn the_eight_motions_of_a_square_are_eight() {
    let grid = Grid::new(3, 3).unwrap();
    let place = |motion: Motion| grid.cells().map(|cell| motion.cell(grid, cell)).collect::<Vec<_>>();
    let mut places: Vec<_> = Motion::of_a_square().map(place).collect();
    assert!(places[0].iter().copied().eq(grid.cells()));
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), 8);
}
