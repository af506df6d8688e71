//! Walls that are thinner than a cell, which half of a cell's pixels do not show.

use std::cmp::Reverse;
use std::ops::Range;

use dragnet_search::cell::{Cell, Grid, Offset, Position};
use dragnet_search::terrain::Ground;

use super::{Raster, pixels_of, to_index};

/// A window of pixels.
struct Window {
    rows: Range<u64>,
    columns: Range<u64>,
}

impl Window {
    /// The smallest one with two others in it: of neighboring cells nothing else.
    fn with(&self, other: &Self) -> Self {
        let both = |a: &Range<u64>, b: &Range<u64>| a.start.min(b.start)..a.end.max(b.end);
        Self { rows: both(&self.rows, &other.rows), columns: both(&self.columns, &other.columns) }
    }

    fn pixels(&self, width: u32) -> impl Iterator<Item = usize> + '_ {
        let pixel = move |row: u64, column: u64| to_index(row * u64::from(width) + column);
        self.rows.clone().flat_map(move |row| self.columns.clone().map(move |column| pixel(row, column)))
    }
}

/// The largest connected part of a cell's free pixels.
struct Floor {
    window: Window,
    pixels: usize,
    /// One of them.
    pixel: usize,
}

/// Finds connected free pixels. Pixels that touch at a corner are not connected, so a diagonal line of single pixels is a wall.
struct Floods<'a> {
    raster: &'a Raster,
    /// The number of the last flood that has reached a pixel, shape `[pixels]`; 0 if none has.
    reached: Vec<u32>,
    count: u32,
}

impl Floods<'_> {
    /// The number of free pixels of a window that are connected with one of them, if no flood after number `since` has
    /// reached it.
    fn flood(&mut self, window: &Window, from: usize, since: u32) -> usize {
        self.count += 1;
        let mut region = Vec::new();
        self.reach(from, since, &mut region);
        let width = to_index(u64::from(self.raster.extent.columns));
        let mut next = 0;
        while let Some(&pixel) = region.get(next) {
            next += 1;
            let (row, column) = ((pixel / width) as u64, (pixel % width) as u64);
            let sides = [
                (row > window.rows.start).then(|| pixel - width),
                (row + 1 < window.rows.end).then(|| pixel + width),
                (column > window.columns.start).then(|| pixel - 1),
                (column + 1 < window.columns.end).then(|| pixel + 1),
            ];
            for side in sides.into_iter().flatten() {
                self.reach(side, since, &mut region);
            }
        }
        region.len()
    }

    fn reach(&mut self, pixel: usize, since: u32, region: &mut Vec<usize>) {
        if self.raster.is_free[pixel] && self.reached[pixel] <= since {
            self.reached[pixel] = self.count;
            region.push(pixel);
        }
    }

    /// Whether all pixels of a window are free, as in most of a map: then they are connected.
    fn is_free(&self, window: &Window) -> bool {
        window.pixels(self.raster.extent.columns).all(|pixel| self.raster.is_free[pixel])
    }

    /// The largest connected part of a window, of equally large ones the first.
    fn floor(&mut self, window: Window) -> Option<Floor> {
        let since = self.count;
        let mut pixels = window.pixels(self.raster.extent.columns);
        let (pixels, pixel) = if self.is_free(&window) {
            let first = pixels.next()?;
            (1 + pixels.count(), first)
        } else {
            let size = |pixel| (self.flood(&window, pixel, since), pixel);
            pixels.map(size).max_by_key(|&(size, pixel)| (size, Reverse(pixel)))?
        };
        Some(Floor { window, pixels, pixel })
    }

    /// Whether free pixels of two neighboring cells connect their floors.
    fn connect(&mut self, a: &Floor, b: &Floor) -> bool {
        let since = self.count;
        let window = a.window.with(&b.window);
        if self.is_free(&window) {
            return true;
        }
        self.flood(&window, a.pixel, since);
        self.reached[b.pixel] > since
    }
}

impl Raster {
    /// Open cells that are not to be entered: without them no two neighboring open cells are left whose floors, the largest
    /// connected parts of their free pixels, no free pixels of the two connect.
    ///
    /// Of two such neighbors it is the one that can be entered from more sides, so that a corridor of single cells stays open;
    /// else the one with the smaller floor, where most of the wall is; else the northern or eastern one.
    pub(super) fn cells_at_walls(&self, grid: Grid, ground: &[Ground], pixels_per_cell: f64) -> Vec<Cell> {
        let mut floods = Floods { raster: self, reached: vec![0; self.is_free.len()], count: 0 };
        let floor = |cell: Cell| {
            let window = self.window(grid.position(cell), pixels_per_cell);
            ground[cell.index()].traversable.then(|| floods.floor(window))?
        };
        let floor_of: Vec<Option<Floor>> = grid.cells().map(floor).collect();
        let mut sides = vec![0_u8; grid.cell_count()];
        let mut parted = Vec::new();
        for cell in grid.cells() {
            for offset in [Offset { north: 0, east: 1 }, Offset { north: 1, east: 0 }] {
                let Some(next) = grid.step(cell, offset) else { continue };
                let (Some(a), Some(b)) = (&floor_of[cell.index()], &floor_of[next.index()]) else { continue };
                if floods.connect(a, b) {
                    sides[cell.index()] += 1;
                    sides[next.index()] += 1;
                } else {
                    parted.push((cell, next));
                }
            }
        }
        let room = |cell: Cell| {
            let pixels = floor_of[cell.index()].as_ref().map_or(0, |floor| floor.pixels);
            (Reverse(sides[cell.index()]), pixels)
        };
        let mut is_closed = vec![false; grid.cell_count()];
        for (cell, next) in parted {
            if !is_closed[cell.index()] && !is_closed[next.index()] {
                let closed = if room(cell) < room(next) { cell } else { next };
                is_closed[closed.index()] = true;
            }
        }
        grid.cells().filter(|cell| is_closed[cell.index()]).collect()
    }

    /// The pixels of a cell.
    fn window(&self, Position { row, column }: Position, pixels_per_cell: f64) -> Window {
        let within = |line: u32, all: u32| {
            let pixels = pixels_of(line, pixels_per_cell);
            pixels.start.min(u64::from(all))..pixels.end.min(u64::from(all))
        };
        Window { rows: within(row, self.extent.rows), columns: within(column, self.extent.columns) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::check;

    #[test]
    fn cells_with_a_wall_in_them_are_not_entered() {
        let rows = |line: &str| [line; 12].join("/");
        let cells = |line: &str| [line; 3].join("/");
        check(&rows("................"), 4.0, &cells("...."));
        check(&rows(".......#........"), 4.0, &cells(".~.."));
        check(&rows("........#......."), 4.0, &cells("..~."));
        // The larger part of the third cell is beyond the wall, and so is entered from there.
        check(&rows(".........#......"), 4.0, &cells("..~."));
        // Half of a cell shows the wall.
        check(&rows("........###....."), 4.0, &cells("..#."));
    }

    #[test]
    fn a_door_stays_open() {
        check("....#.../......../....#.../....#...", 4.0, "..");
    }

    #[test]
    fn a_diagonal_line_of_single_pixels_is_a_wall() {
        check(".....#/....#./...#../..#.../.#..../#.....", 3.0, ".~/~.");
    }

    #[test]
    fn a_corridor_of_single_cells_between_thin_walls_stays_open() {
        let [free, wall] = [".", "#"].map(|pixel| pixel.repeat(16));
        let room = [free.as_str(); 7].join("/");
        let corridor = format!("{wall}/{wall}/{free}/{free}/{wall}/{wall}");
        // The walls lie half in the corridor's cells.
        check(&format!("{room}/{corridor}/{room}"), 4.0, "..../~~~~/..../~~~~/....");
    }
}
