//! Cells and grids: the only place that turns rows and columns into an index and back.

/// A cell of one [`Grid`]: its row-major index, row 0 in the south, column 0 in the west.
///
/// Only a [`Grid`] constructs cells, so every cell is on its map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell(u32);

impl Cell {
    /// Row-major index, `0..grid.cell_count()`.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// The row-major index as it is sent in messages.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.0
    }
}

/// Row and column of a cell: rows count north from the southern edge, columns east from the western edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// `0..rows`, south to north.
    pub row: u32,
    /// `0..columns`, west to east.
    pub column: u32,
}

/// The displacement from one cell to another, in cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Offset {
    /// Cells to the north; negative is south.
    pub north: i32,
    /// Cells to the east; negative is west.
    pub east: i32,
}

impl Offset {
    /// All offsets of at most this Manhattan length, south to north, then west to east.
    pub fn within(radius: u32) -> impl Iterator<Item = Self> {
        let radius = radius.cast_signed();
        (-radius..=radius).flat_map(move |north| {
            let span = radius - north.abs();
            (-span..=span).map(move |east| Self { north, east })
        })
    }

    /// `|north| + |east|`.
    #[must_use]
    pub const fn manhattan(self) -> u32 {
        self.north.unsigned_abs() + self.east.unsigned_abs()
    }

    /// Straight-line length, in cells.
    #[must_use]
    pub fn euclidean(self) -> f64 {
        f64::from(self.north).hypot(f64::from(self.east))
    }
}

/// A rectangle of `rows x columns` square cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    rows: u32,
    columns: u32,
}

/// The requested grid has no cells, or more than [`Grid::MAX_CELLS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a map of {rows} rows and {columns} columns: allowed are 1 to {} cells", Grid::MAX_CELLS)]
pub struct GridSizeError {
    rows: u32,
    columns: u32,
}

impl Grid {
    /// The largest map: 4096 x 4096 cells.
    pub const MAX_CELLS: u64 = 1 << 24;

    /// A grid of `rows` (south to north) by `columns` (west to east).
    ///
    /// # Errors
    /// If the grid has no cells, or more than [`Grid::MAX_CELLS`].
    pub fn new(rows: u32, columns: u32) -> Result<Self, GridSizeError> {
        let cells = u64::from(rows) * u64::from(columns);
        if (1..=Self::MAX_CELLS).contains(&cells) {
            Ok(Self { rows, columns })
        } else {
            Err(GridSizeError { rows, columns })
        }
    }

    /// Rows, south to north.
    #[must_use]
    pub const fn rows(self) -> u32 {
        self.rows
    }

    /// Columns, west to east.
    #[must_use]
    pub const fn columns(self) -> u32 {
        self.columns
    }

    /// `rows * columns`.
    #[must_use]
    pub const fn cell_count(self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// The cell at a position, if it is on the map.
    #[must_use]
    pub const fn cell(self, position: Position) -> Option<Cell> {
        if position.row < self.rows && position.column < self.columns {
            Some(Cell(position.row * self.columns + position.column))
        } else {
            None
        }
    }

    /// The cell that contains a point, given in cells east and north of the map's south-western corner; `None` off the
    /// map and for NaN.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cast saturates, and a map ends"
    )]
    pub fn cell_at(self, east_cells: f64, north_cells: f64) -> Option<Cell> {
        let (row, column) = (north_cells.floor(), east_cells.floor());
        let is_on = row >= 0.0 && column >= 0.0;
        is_on.then(|| self.cell(Position { row: row as u32, column: column as u32 })).flatten()
    }

    /// The cell with a row-major index from a message, if it is on the map.
    #[must_use]
    pub const fn cell_numbered(self, number: u32) -> Option<Cell> {
        if (number as usize) < self.cell_count() { Some(Cell(number)) } else { None }
    }

    /// Row and column of a cell of this grid.
    #[must_use]
    pub const fn position(self, cell: Cell) -> Position {
        Position { row: cell.0 / self.columns, column: cell.0 % self.columns }
    }

    /// All cells, by index.
    pub fn cells(self) -> impl DoubleEndedIterator<Item = Cell> + ExactSizeIterator + Clone {
        (0..self.rows * self.columns).map(Cell)
    }

    /// The cell at an offset from another, if it is on the map.
    #[must_use]
    pub fn step(self, from: Cell, offset: Offset) -> Option<Cell> {
        self.step_from(self.position(from), offset)
    }

    /// The cell at an offset from a position, if it is on the map.
    #[must_use]
    #[inline]
    pub fn step_from(self, from: Position, offset: Offset) -> Option<Cell> {
        let Position { row, column } = from;
        self.cell(Position {
            row: row.checked_add_signed(offset.north)?,
            column: column.checked_add_signed(offset.east)?,
        })
    }

    /// Offset that leads from one cell to another.
    #[must_use]
    #[expect(clippy::cast_possible_wrap, reason = "rows and columns are at most MAX_CELLS")]
    pub const fn offset(self, from: Cell, to: Cell) -> Offset {
        let (a, b) = (self.position(from), self.position(to));
        Offset { north: b.row as i32 - a.row as i32, east: b.column as i32 - a.column as i32 }
    }

    /// Manhattan distance between two cells, in cells.
    #[must_use]
    pub const fn manhattan(self, a: Cell, b: Cell) -> u32 {
        self.offset(a, b).manhattan()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_and_its_position_are_one_to_one() {
        let grid = Grid::new(3, 5).unwrap();
        for (index, cell) in grid.cells().enumerate() {
            assert_eq!(cell.index(), index);
            assert_eq!(grid.cell(grid.position(cell)), Some(cell));
        }
        assert_eq!(grid.cell(Position { row: 2, column: 0 }).unwrap().index(), 10);
        assert_eq!(grid.cell(Position { row: 0, column: 5 }), None);
        assert_eq!(grid.cell_numbered(15), None);
    }

    #[test]
    fn a_point_lies_in_a_cell_or_beside_the_map() {
        let grid = Grid::new(3, 5).unwrap();
        let at = |east, north| grid.cell_at(east, north).map(|cell| grid.position(cell));
        assert_eq!(at(4.9, 2.0), Some(Position { row: 2, column: 4 }));
        assert_eq!(at(0.0, 0.0), Some(Position { row: 0, column: 0 }));
        for (east, north) in [(-0.1, 1.0), (5.0, 1.0), (1.0, 3.0), (1.0, f64::NAN), (f64::INFINITY, 1.0)] {
            assert_eq!(at(east, north), None, "{east} {north}");
        }
    }

    #[test]
    fn a_step_off_the_map_is_no_cell() {
        let grid = Grid::new(3, 5).unwrap();
        let west = grid.cell(Position { row: 1, column: 0 }).unwrap();
        assert_eq!(grid.step(west, Offset { north: 0, east: -1 }), None);
        let north_east = grid.step(west, Offset { north: 1, east: 1 }).unwrap();
        assert_eq!(grid.position(north_east), Position { row: 2, column: 1 });
        assert_eq!(grid.manhattan(west, north_east), 2);
    }

    #[test]
    fn empty_and_enormous_grids_are_rejected() {
        assert!(Grid::new(0, 5).is_err());
        let error = Grid::new(31_623, 31_623).unwrap_err().to_string();
        assert_eq!(error, "a map of 31623 rows and 31623 columns: allowed are 1 to 16777216 cells");
    }
}
