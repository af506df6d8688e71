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

/// East, north, west and south.
const SIDES: [Offset; 4] = [
    Offset { north: 0, east: 1 },
    Offset { north: 1, east: 0 },
    Offset { north: 0, east: -1 },
    Offset { north: -1, east: 0 },
];

/// Which neighboring cells' floors are connected, and which cells are closed.
struct Ways {
    grid: Grid,
    /// By side, shape `[cells]`.
    is_joined: Vec<[bool; 4]>,
    is_closed: Vec<bool>,
}

impl Ways {
    fn new(grid: Grid) -> Self {
        let count = grid.cell_count();
        Self { grid, is_joined: vec![[false; 4]; count], is_closed: vec![false; count] }
    }

    /// The neighbors to the east and to the north.
    fn ahead(&self, cell: Cell) -> impl Iterator<Item = (usize, Cell)> + use<> {
        let grid = self.grid;
        (0..2).filter_map(move |side| Some((side, grid.step(cell, SIDES[side])?)))
    }

    fn join(&mut self, cell: Cell, side: usize, next: Cell) {
        self.is_joined[cell.index()][side] = true;
        self.is_joined[next.index()][(side + 2) % 4] = true;
    }

    /// The open neighbors whose floors are connected with a cell's.
    fn joined(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        let joined = (0..4).filter(move |&side| self.is_joined[cell.index()][side]);
        let next = joined.filter_map(move |side| self.grid.step(cell, SIDES[side]));
        next.filter(|next| !self.is_closed[next.index()])
    }

    /// Whether the neighbors that a cell connects are also connected by the eight cells around it.
    fn is_spare(&self, cell: Cell) -> bool {
        let is_around = |next: &Cell| {
            let Offset { north, east } = self.grid.offset(cell, *next);
            north.abs().max(east.abs()) == 1
        };
        let mut reached: Vec<Cell> = self.joined(cell).take(1).collect();
        let mut next = 0;
        while let Some(&at) = reached.get(next) {
            next += 1;
            for beside in self.joined(at).filter(is_around) {
                if !reached.contains(&beside) {
                    reached.push(beside);
                }
            }
        }
        self.joined(cell).all(|beside| reached.contains(&beside))
    }
}

impl Raster {
    /// Open cells that are not to be entered: without them no two neighboring open cells are left whose floors, the largest
    /// connected parts of their free pixels, no free pixels of the two connect.
    ///
    /// Of two such neighbors it is the one without which the cells around it are still connected, so that no way is cut; else the
    /// one that can be entered from more sides, so that a corridor of single cells stays open; else the one with the
    /// smaller floor, where most of the wall is; else the northern or eastern one.
    pub(super) fn cells_at_walls(&self, grid: Grid, ground: &[Ground], pixels_per_cell: f64) -> Vec<Cell> {
        let mut floods = Floods { raster: self, reached: vec![0; self.is_free.len()], count: 0 };
        let floor = |cell: Cell| {
            let window = self.window(grid.position(cell), pixels_per_cell);
            ground[cell.index()].traversable.then(|| floods.floor(window))?
        };
        let floor_of: Vec<Option<Floor>> = grid.cells().map(floor).collect();
        let mut ways = Ways::new(grid);
        let mut parted = Vec::new();
        for cell in grid.cells() {
            for (side, next) in ways.ahead(cell) {
                let (Some(a), Some(b)) = (&floor_of[cell.index()], &floor_of[next.index()]) else { continue };
                if floods.connect(a, b) {
                    ways.join(cell, side, next);
                } else {
                    parted.push((cell, next));
                }
            }
        }
        let sides: Vec<usize> = grid.cells().map(|cell| ways.joined(cell).count()).collect();
        let room = |ways: &Ways, cell: Cell| {
            let pixels = floor_of[cell.index()].as_ref().map_or(0, |floor| floor.pixels);
            (!ways.is_spare(cell), Reverse(sides[cell.index()]), pixels)
        };
        for (cell, next) in parted {
            if !ways.is_closed[cell.index()] && !ways.is_closed[next.index()] {
                let closed = if room(&ways, cell) < room(&ways, next) { cell } else { next };
                ways.is_closed[closed.index()] = true;
            }
        }
        grid.cells().filter(|cell| ways.is_closed[cell.index()]).collect()
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
    use std::path::Path;

    use super::super::Extent;
    use super::super::tests::check;
    use super::*;

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

    /// A floor of a building in pixels of 0.1 m: a corridor of 1.9 m with rooms of 6 m on both sides, walls of 0.1 m, and doors of
    /// 1.8 m; `beside` and `below` pixels of more wall in the west and in the south.
    fn building(beside: u32, below: u32) -> Raster {
        let (columns, rows) = (241 + beside, 161 + below);
        let is_wall = |row: u32, column: u32| {
            let is_divider = column.is_multiple_of(60) && !(71..90).contains(&row);
            let is_door = (21..39).contains(&(column % 60));
            is_divider || row.is_multiple_of(160) || (row == 70 || row == 90) && !is_door
        };
        let is_free = |pixel: u32| {
            let (row, column) = (pixel / columns, pixel % columns);
            row >= below && column >= beside && !is_wall(row - below, column - beside)
        };
        let extent = Extent { columns, rows, pixel_meters: 0.1 };
        Raster { extent, is_free: (0..rows * columns).map(is_free).collect() }
    }

    #[test]
    fn all_rooms_of_a_building_stay_connected_wherever_its_walls_lie_in_the_cells() {
        for (beside, below) in (0..10).flat_map(|beside| (0..10).map(move |below| (beside, below))) {
            let terrain = building(beside, below).terrain(Path::new("building.png"), 1.0).unwrap();
            let areas = terrain.connected_areas();
            assert_eq!(
                areas.len(),
                1,
                "{beside} {below}: {:?}",
                areas.iter().map(Vec::len).collect::<Vec<_>>()
            );
        }
    }
}
