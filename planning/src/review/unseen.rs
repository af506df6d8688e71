//! Ground that no robot sees, as rectangles to draw.

use std::cmp::Reverse;

use dragnet_scenario::map_file::{GeoPoint, Georeference};
use dragnet_search::cell::{Cell, Position};
use dragnet_search::terrain::Terrain;

/// The most rectangles: the largest ones are shown.
const MOST: usize = 1_000;

/// `[south, west, north, east]`, degrees.
pub type Bounds = [f64; 4];

/// Cells beside each other: rows from the south, columns from the west; ends are included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Block {
    rows: [u32; 2],
    columns: [u32; 2],
}

impl Block {
    fn cell_count(self) -> u64 {
        let side = |[first, last]: [u32; 2]| u64::from(last - first + 1);
        side(self.rows) * side(self.columns)
    }
}

/// The ground of these cells, which are ordered by their indices.
pub(super) fn bounds(cells: &[Cell], terrain: &Terrain, frame: &Georeference) -> Vec<Bounds> {
    let grid = terrain.grid();
    let mut blocks = blocks(cells.iter().map(|&cell| grid.position(cell)));
    blocks.sort_by_key(|block| Reverse(block.cell_count()));
    blocks.truncate(MOST);
    let point = |row: u32, column: u32| {
        let edge = terrain.cell_meters();
        let GeoPoint { latitude_degrees, longitude_degrees } =
            frame.point((f64::from(column) * edge, f64::from(row) * edge));
        [latitude_degrees, longitude_degrees]
    };
    let drawn = |Block { rows, columns }: Block| {
        let ([south, west], [north, east]) = (point(rows[0], columns[0]), point(rows[1] + 1, columns[1] + 1));
        [south, west, north, east]
    };
    blocks.into_iter().map(drawn).collect()
}

/// Runs of cells in a row; those of rows one above the other with the same ends are one block.
fn blocks(positions: impl Iterator<Item = Position>) -> Vec<Block> {
    let mut runs: Vec<Block> = Vec::new();
    for Position { row, column } in positions {
        match runs.last_mut() {
            Some(run) if run.rows[0] == row && run.columns[1] + 1 == column => run.columns[1] = column,
            _ => runs.push(Block { rows: [row, row], columns: [column, column] }),
        }
    }
    runs.sort_by_key(|run| (run.columns, run.rows));
    let mut blocks: Vec<Block> = Vec::new();
    for run in runs {
        match blocks.last_mut() {
            Some(block) if block.columns == run.columns && block.rows[1] + 1 == run.rows[0] => {
                block.rows[1] = run.rows[1];
            }
            _ => blocks.push(run),
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows from the south.
    fn check(rows: &[&str], expected: &[([u32; 2], [u32; 2])]) {
        let positions = rows.iter().zip(0..).flat_map(|(line, row)| {
            let marked = line.chars().zip(0..).filter(|(sign, _)| *sign == 'x');
            marked.map(move |(_, column)| Position { row, column })
        });
        let found: Vec<_> = blocks(positions).iter().map(|it| (it.rows, it.columns)).collect();
        assert_eq!(found, expected, "{rows:?}");
    }

    #[test]
    fn cells_beside_each_other_are_one_block() {
        check(&[".xx.", ".xx.", ".xx."], &[([0, 2], [1, 2])]);
        check(&["x..x", "xx.."], &[([0, 0], [0, 0]), ([1, 1], [0, 1]), ([0, 0], [3, 3])]);
        check(&["x", ".", "x"], &[([0, 0], [0, 0]), ([2, 2], [0, 0])]);
        check(&["...x", "x..."], &[([1, 1], [0, 0]), ([0, 0], [3, 3])]);
        check(&["..."], &[]);
    }
}
