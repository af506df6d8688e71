//! Which cells are seen from which, where walls hide what is behind them.
//!
//! It holds for robots on the ground, and follows from the walls alone: not from a robot's heading, and from its sensor only as
//! far as that reaches. It is computed once for a map, by [`LineOfSight::behind_walls`] from the cells that are walls, or from
//! anything finer by [`LineOfSight::from_fn`], and kept in the [`Terrain`] that all policies plan on.

mod views;

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use crate::cell::{Cell, Grid, Offset, Position};
use crate::sensor::{FootprintCell, Sensor};
use crate::terrain::Terrain;

pub(crate) use views::Views;

/// Cells without a hidden cell have no row.
const NONE: u32 = u32::MAX;
/// Bits of a word.
const BITS: usize = 64;

/// What is hidden from each cell of a map, within a Manhattan radius. Beyond it nothing is said to be hidden. Copies share it.
#[derive(Clone, Debug, Default)]
pub struct LineOfSight(Option<Arc<Hidden>>);

#[derive(Clone, Debug, PartialEq)]
struct Hidden {
    radius: i32,
    /// Of each cell, the number of its row; [`NONE`] if all is seen from it. Shape `[cells]`.
    row: Vec<u32>,
    /// Words of a row: a bit for each cell of the square around its cell.
    words: usize,
    /// Shape `[rows, words]`.
    bits: Vec<u64>,
}

/// What is hidden from one cell.
#[derive(Clone, Copy, Debug)]
pub struct Shadows<'a> {
    radius: i32,
    bits: &'a [u64],
}

impl LineOfSight {
    /// The most pairs of cells that it is computed for: those of the map, each with those within the radius.
    pub const MAX_PAIRS: u64 = 1 << 27;

    /// Nothing is hidden.
    #[must_use]
    pub const fn everywhere() -> Self {
        Self(None)
    }

    /// Opaque cells hide what is behind them ([`Terrain::is_opaque`]). Water and roads hide nothing, and a wall is seen itself.
    #[must_use]
    pub fn behind_walls(terrain: &Terrain, radius: u32) -> Self {
        let grid = terrain.grid();
        let is_opaque: Vec<bool> = grid.cells().map(|cell| terrain.is_opaque(cell)).collect();
        let is_opaque = |cell: Cell| is_opaque[cell.index()];
        let walls = Walls::of(grid, is_opaque);
        let span = |at: u32, step: i32| {
            let other = at.saturating_add_signed(step);
            at.min(other) as usize..at.max(other) as usize + 1
        };
        Self::from_fn(grid, radius, |from, offset| {
            let Position { row, column } = grid.position(from);
            walls.is_any_in(span(row, offset.north), span(column, offset.east))
                && !is_clear(grid, from, offset, is_opaque)
        })
    }

    /// Whether a map has more than [`LineOfSight::MAX_PAIRS`] pairs of cells that are no farther apart than a radius, cells.
    #[must_use]
    pub fn is_too_large(grid: Grid, radius: u32) -> bool {
        let seen = 1 + 2 * u64::from(radius) * (u64::from(radius) + 1);
        u64::from(grid.rows()) * u64::from(grid.columns()) * seen > Self::MAX_PAIRS
    }

    /// From a function that says whether the cell at an offset is hidden from another. Both are on the map, and no farther
    /// apart than the radius, cells.
    #[must_use]
    pub fn from_fn(grid: Grid, radius: u32, is_hidden: impl FnMut(Cell, Offset) -> bool) -> Self {
        Self::everywhere().renewed(grid, radius, |_| true, is_hidden)
    }

    /// The same of equal radius, computed anew from some cells, as by [`LineOfSight::from_fn`].
    #[must_use]
    pub fn renewed(
        &self,
        grid: Grid,
        radius: u32,
        is_from: impl Fn(Cell) -> bool,
        mut is_hidden: impl FnMut(Cell, Offset) -> bool,
    ) -> Self {
        let mut hidden = Hidden::nothing(grid, radius);
        for from in grid.cells() {
            if !is_from(from) {
                if let Some(shadows) = self.shadows(from) {
                    hidden.copy(from, shadows);
                }
                continue;
            }
            for offset in Offset::within(radius) {
                if grid.step(from, offset).is_some() && is_hidden(from, offset) {
                    hidden.hide(from, offset);
                }
            }
        }
        hidden.into()
    }

    /// The same with more that is hidden: pairs of a cell and one that is hidden from it, no farther apart than the radius, cells.
    #[must_use]
    pub fn with_hidden(&self, grid: Grid, radius: u32, pairs: &BTreeSet<(Cell, Cell)>) -> Self {
        if pairs.is_empty() {
            return self.clone();
        }
        let mut hidden = Hidden::nothing(grid, radius);
        let mut pairs = pairs.iter().peekable();
        for from in grid.cells() {
            if let Some(shadows) = self.shadows(from) {
                hidden.copy(from, shadows);
            }
            while let Some(&(_, cell)) = pairs.next_if(|&&(it, _)| it == from) {
                hidden.hide(from, grid.offset(from, cell));
            }
        }
        hidden.into()
    }

    /// Whether nothing is hidden from any cell.
    #[must_use]
    pub const fn is_everywhere(&self) -> bool {
        self.0.is_none()
    }

    /// The radius within which it is known, cells, if anything is hidden.
    #[must_use]
    pub fn radius(&self) -> Option<u32> {
        self.0.as_ref().map(|hidden| hidden.radius.unsigned_abs())
    }

    /// What is hidden from a cell, if anything is.
    #[must_use]
    #[inline]
    pub fn shadows(&self, from: Cell) -> Option<Shadows<'_>> {
        self.0.as_ref()?.shadows(from)
    }

    /// Whether the cell at an offset is hidden from another.
    #[must_use]
    #[inline]
    pub fn hides(&self, from: Cell, offset: Offset) -> bool {
        self.shadows(from).is_some_and(|shadows| shadows.hide(offset))
    }

    /// The cells on a map that a sensor sees from a cell, in the order of its footprint.
    pub fn seen<'a>(
        &'a self,
        grid: Grid,
        sensor: &'a Sensor,
        from: Cell,
    ) -> impl Iterator<Item = (Cell, &'a FootprintCell)> {
        let (position, shadows) = (grid.position(from), self.shadows(from));
        let is_seen = move |place: &&FootprintCell| shadows.is_none_or(|shadows| !shadows.hide(place.offset));
        let seen = sensor.footprint().iter().filter(is_seen);
        seen.filter_map(move |place| Some((grid.step_from(position, place.offset)?, place)))
    }
}

impl PartialEq for LineOfSight {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(own), Some(others)) => Arc::ptr_eq(own, others) || own == others,
            (None, None) => true,
            _ => false,
        }
    }
}

impl From<Hidden> for LineOfSight {
    fn from(hidden: Hidden) -> Self {
        Self(Some(Arc::new(hidden)).filter(|hidden| !hidden.bits.is_empty()))
    }
}

impl Hidden {
    fn nothing(grid: Grid, radius: u32) -> Self {
        let side = 2 * radius as usize + 1;
        let words = (side * side).div_ceil(BITS);
        Self { radius: radius.cast_signed(), row: vec![NONE; grid.cell_count()], words, bits: Vec::new() }
    }

    /// What is hidden from a cell, as if of the same radius.
    #[expect(clippy::cast_possible_truncation, reason = "a map has fewer than 2^32 cells")]
    fn copy(&mut self, from: Cell, shadows: Shadows<'_>) {
        self.row[from.index()] = (self.bits.len() / self.words) as u32;
        self.bits.extend_from_slice(shadows.bits);
    }

    fn shadows(&self, from: Cell) -> Option<Shadows<'_>> {
        let row = self.row[from.index()];
        let bits = (row != NONE).then(|| &self.bits[row as usize * self.words..][..self.words])?;
        Some(Shadows { radius: self.radius, bits })
    }

    #[expect(clippy::cast_possible_truncation, reason = "a map has fewer than 2^32 cells")]
    fn hide(&mut self, from: Cell, offset: Offset) {
        let row = &mut self.row[from.index()];
        if *row == NONE {
            *row = (self.bits.len() / self.words) as u32;
            self.bits.resize(self.bits.len() + self.words, 0);
        }
        let bit = bit(self.radius, offset);
        self.bits[*row as usize * self.words + bit / BITS] |= 1 << (bit % BITS);
    }
}

impl Shadows<'_> {
    /// Whether the cell at an offset is hidden.
    #[must_use]
    #[inline]
    pub fn hide(self, offset: Offset) -> bool {
        if offset.north.abs() > self.radius || offset.east.abs() > self.radius {
            return false;
        }
        let bit = bit(self.radius, offset);
        self.bits[bit / BITS] >> (bit % BITS) & 1 == 1
    }
}

/// The place of an offset in a row.
#[inline]
const fn bit(radius: i32, offset: Offset) -> usize {
    ((offset.north + radius) * (2 * radius + 1) + offset.east + radius).unsigned_abs() as usize
}

/// How many cells of a grid are walls: south-west of each corner of a cell, so that a rectangle takes four numbers.
#[derive(Clone, Debug)]
pub struct Walls {
    stride: usize,
    /// Shape `[rows + 1, columns + 1]`.
    sums: Vec<u32>,
}

impl Walls {
    /// By a function that says which cells are walls.
    #[must_use]
    pub fn of(grid: Grid, is_wall: impl Fn(Cell) -> bool) -> Self {
        let stride = grid.columns() as usize + 1;
        let mut sums = vec![0; (grid.rows() as usize + 1) * stride];
        for cell in grid.cells() {
            let Position { row, column } = grid.position(cell);
            let north_east = (row as usize + 1) * stride + column as usize + 1;
            let south_west = north_east - stride - 1;
            sums[north_east] =
                sums[north_east - 1] + sums[south_west + 1] - sums[south_west] + u32::from(is_wall(cell));
        }
        Self { stride, sums }
    }

    /// Whether there is one in these rows and columns, which are on the grid.
    #[must_use]
    pub fn is_any_in(&self, rows: Range<usize>, columns: Range<usize>) -> bool {
        let south_west_of = |row: usize, column: usize| self.sums[row * self.stride + column];
        let outside = south_west_of(rows.end, columns.start) + south_west_of(rows.start, columns.end);
        south_west_of(rows.end, columns.end) + south_west_of(rows.start, columns.start) > outside
    }
}

/// Whether no cell on the straight line between two cells is opaque. The line goes from center to center, through the cells
/// nearest to it, one for each step of the longer side; not between two opaque cells that touch at a corner, but to see such a
/// cell in the corner itself.
#[must_use]
pub fn is_clear(grid: Grid, from: Cell, offset: Offset, is_opaque: impl Fn(Cell) -> bool) -> bool {
    let steps = offset.north.abs().max(offset.east.abs());
    let at =
        |step: i32| Offset { north: part(offset.north, step, steps), east: part(offset.east, step, steps) };
    let is_wall = |offset: Offset| grid.step(from, offset).is_some_and(&is_opaque);
    (0..steps).all(|step| {
        let (here, next, is_last) = (at(step), at(step + 1), step + 1 == steps);
        if !is_last && is_wall(next) {
            return false;
        }
        let corners = [Offset { east: here.east, ..next }, Offset { north: here.north, ..next }];
        let is_between = next != corners[0] && next != corners[1] && corners.into_iter().all(is_wall);
        !is_between || (is_last && is_wall(next))
    })
}

/// `whole * step / steps`, rounded half away from zero.
const fn part(whole: i32, step: i32, steps: i32) -> i32 {
    let rounded = (2 * whole.abs() * step + steps) / (2 * steps);
    rounded * whole.signum()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::terrain::Ground;

    /// The cells in sight of the south-western one, as a drawing: `o` in sight, `x` not; its first line is the northern
    /// edge.
    fn seen(drawing: &str) -> String {
        seen_on(&Terrain::from_ascii(drawing, 1.0).unwrap())
    }

    fn seen_on(terrain: &Terrain) -> String {
        let grid = terrain.grid();
        let from = grid.cell(Position { row: 0, column: 0 }).unwrap();
        let line_of_sight = LineOfSight::behind_walls(terrain, 9);
        let mark = |row, column| {
            let to = grid.cell(Position { row, column }).unwrap();
            if line_of_sight.hides(from, grid.offset(from, to)) { 'x' } else { 'o' }
        };
        let line = |row| (0..grid.columns()).map(|column| mark(row, column)).collect::<String>();
        (0..grid.rows()).rev().map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn a_wall_throws_a_shadow_and_water_none() {
        let drawing = "......\n......\n..#...\n......\n..~,..";
        assert_eq!(seen(drawing), "oooxxx\noooxxo\noooooo\noooooo\noooooo");
    }

    #[test]
    fn a_wall_thinner_than_a_cell_hides_what_is_behind_it_and_is_seen_itself() {
        let terrain = Terrain::from_ascii("....\n~~~~\n....\n....", 1.0).unwrap();
        assert_eq!(seen_on(&terrain), "oooo\noooo\noooo\noooo");
        let along: Vec<Cell> = terrain.grid().cells().filter(|&cell| !terrain.is_traversable(cell)).collect();
        assert_eq!(seen_on(&terrain.with_thin_walls(along)), "xxxx\noooo\noooo\noooo");
    }

    #[test]
    fn no_line_leads_between_walls_that_touch_at_a_corner_but_to_their_corner() {
        assert_eq!(seen("....\n.#..\n..#.\n...."), "oxxx\nooxx\nooox\noooo");
        assert_eq!(seen("..##\n..##\n...#\n...."), "ooox\noooo\noooo\noooo");
    }

    #[test]
    fn without_a_wall_nothing_is_kept() {
        let terrain = Terrain::from_ascii("..~\n.,.", 1.0).unwrap();
        let line_of_sight = LineOfSight::behind_walls(&terrain, 2);
        assert!(line_of_sight.is_everywhere());
        assert_eq!(line_of_sight, LineOfSight::everywhere());
    }

    proptest! {
        #[test]
        fn what_is_hidden_is_what_no_clear_line_leads_to_within_the_radius(
            rows in 1_u32..12, columns in 1_u32..12, radius in 1_u32..9,
            walls in prop::collection::vec(prop::bool::weighted(0.2), 144),
        ) {
            let grid = Grid::new(rows, columns).unwrap();
            let ground = walls.iter().take(grid.cell_count());
            let ground = ground.map(|&is_wall| if is_wall { Ground::BLOCKED } else { Ground::OPEN });
            let terrain = Terrain::new(grid, 1.0, ground.collect()).unwrap();
            let line_of_sight = LineOfSight::behind_walls(&terrain, radius);
            for from in grid.cells() {
                for to in grid.cells() {
                    let offset = grid.offset(from, to);
                    let is_hidden = offset.manhattan() <= radius && !is_clear(grid, from, offset, |cell| terrain.is_wall(cell));
                    prop_assert_eq!(line_of_sight.hides(from, offset), is_hidden, "{:?} {:?}", from, to);
                }
            }
        }
    }
}
