//! Line of sight between two cells.

use dragnet_search::cell::{Cell, Offset};
use dragnet_search::terrain::Terrain;

/// Whether no cell on the straight line between two cells is a wall: neither traversable nor searched. Water and roads
/// hide nothing. The line goes from center to center, through the cells nearest to it, one for each step of the longer
/// side.
pub(super) fn is_clear(terrain: &Terrain, from: Cell, offset: Offset) -> bool {
    let steps = offset.north.abs().max(offset.east.abs());
    (1..steps).all(|step| {
        let between = Offset { north: part(offset.north, step, steps), east: part(offset.east, step, steps) };
        let cell = terrain.grid().step(from, between);
        cell.is_none_or(|cell| terrain.is_traversable(cell) || terrain.is_searched(cell))
    })
}

/// `whole * step / steps`, rounded half away from zero.
const fn part(whole: i32, step: i32, steps: i32) -> i32 {
    let rounded = (2 * whole.abs() * step + steps) / (2 * steps);
    rounded * whole.signum()
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Position;

    use super::*;

    /// The cells in sight of the south-western one, as a drawing: `o` in sight, `x` not; its first line is the northern
    /// edge.
    fn seen(drawing: &str) -> String {
        let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
        let grid = terrain.grid();
        let from = grid.cell(Position { row: 0, column: 0 }).unwrap();
        let mark = |row, column| {
            let to = grid.cell(Position { row, column }).unwrap();
            if is_clear(&terrain, from, grid.offset(from, to)) { 'o' } else { 'x' }
        };
        let line = |row| (0..grid.columns()).map(|column| mark(row, column)).collect::<String>();
        (0..grid.rows()).rev().map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn a_wall_throws_a_shadow_and_water_none() {
        let drawing = "......\n......\n..#...\n......\n..~,..";
        assert_eq!(seen(drawing), "oooxxx\noooxxo\noooooo\noooooo\noooooo");
    }
}
