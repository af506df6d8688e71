//! The cells of each pattern, in order.

use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

use super::spacing::tracks;
use crate::cell::{Cell, Grid, Position};
use crate::route::ShortestPathTree;
use crate::situation::Situation;
use crate::terrain::Terrain;

/// A search pattern of the IAMSAR Manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Parallel tracks along the longer side of the area in reach; along the rows if it is square.
    ParallelTrack,
    /// Parallel tracks along the shorter side.
    CreepingLine,
    /// A square spiral around the most probable cell.
    ExpandingSquare,
    /// Six triangles through the most probable cell, and six more between them.
    Sector,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 4] = [Self::ParallelTrack, Self::CreepingLine, Self::ExpandingSquare, Self::Sector];

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::ParallelTrack => "parallel_track",
            Self::CreepingLine => "creeping_line",
            Self::ExpandingSquare => "expanding_square",
            Self::Sector => "sector",
        }
    }

    /// The cells in reach that the pattern enters, in order, with tracks at this spacing (cells); then those that serve
    /// what tracks leave out because they are blocked.
    pub(super) fn cells(
        self,
        situation: &Situation<'_>,
        routes: &ShortestPathTree,
        spacing: u32,
    ) -> [Vec<Cell>; 2] {
        let (terrain, grid) = (situation.terrain, situation.terrain.grid());
        match self {
            Self::ParallelTrack => parallel(terrain, routes, spacing, false),
            Self::CreepingLine => parallel(terrain, routes, spacing, true),
            Self::ExpandingSquare => {
                [expanding_square(grid, routes, datum(situation, routes), spacing), Vec::new()]
            }
            Self::Sector => [sector(grid, routes, datum(situation, routes)), Vec::new()],
        }
    }
}

/// The cell in reach of the highest probability; of equal ones the nearest by path.
fn datum(situation: &Situation<'_>, routes: &ShortestPathTree) -> Cell {
    let odds = |cell: Cell| situation.belief.log_odds_nats(cell);
    let searched = routes.reached().iter().copied().filter(|&cell| situation.terrain.is_searched(cell));
    let best = searched.max_by(|&a, &b| {
        let nearer = routes.length(b).total_cmp(&routes.length(a));
        odds(a).total_cmp(&odds(b)).then(nearer).then(b.cmp(&a))
    });
    best.unwrap_or(routes.root())
}

/// A coordinate of a cell.
type Axis = fn(Position) -> u32;

/// Tracks back and forth, from the south or west, and legs for what they leave out: each searched cell in reach is at
/// most half a spacing, across the tracks, from a cell of the two.
fn parallel(terrain: &Terrain, routes: &ShortestPathTree, spacing: u32, is_creeping: bool) -> [Vec<Cell>; 2] {
    let grid = terrain.grid();
    let positions = || routes.reached().iter().map(|&cell| grid.position(cell));
    let range = |values: &dyn Fn(Position) -> u32| {
        let least = positions().map(values).min().unwrap_or(0);
        (least, positions().map(values).max().unwrap_or(0) - least + 1)
    };
    let (rows, columns) = (range(&|position| position.row), range(&|position| position.column));
    let is_tall = rows.1 > columns.1;
    // Tracks are rows, numbered northward, or columns, numbered eastward.
    let are_rows = is_tall == is_creeping;
    let (track, along): (Axis, Axis) = if are_rows {
        (|position| position.row, |position| position.column)
    } else {
        (|position| position.column, |position| position.row)
    };
    let (first, extent) = if are_rows { rows } else { columns };
    let line = |cell: Cell| track(grid.position(cell)) - first;
    let along = |cell: Cell| along(grid.position(cell));
    let places: Vec<u32> = tracks(extent, spacing).collect();
    let nearest =
        |line: u32| (0..places.len()).min_by_key(|&number| places[number].abs_diff(line)).unwrap_or(0);
    let of_line: Vec<usize> = (0..extent).map(nearest).collect();
    // The cells that each track serves.
    let mut bands: Vec<Vec<Cell>> = vec![Vec::new(); places.len()];
    for &cell in routes.reached() {
        bands[of_line[line(cell) as usize]].push(cell);
    }
    let (mut tracks, mut left) = (Legs::default(), Legs::default());
    for (mut band, place) in bands.into_iter().zip(places) {
        band.sort_unstable_by_key(|&cell| (along(cell), line(cell).abs_diff(place), cell));
        let entered: Vec<Cell> = band.iter().copied().filter(|&cell| line(cell) == place).collect();
        let is_served = |cell: Cell| entered.binary_search_by_key(&along(cell), |&it| along(it)).is_ok();
        band.retain(|&cell| !is_served(cell) && terrain.is_searched(cell));
        tracks.push(entered);
        // Through the cells nearest to the track; those that this leaves too far away get another leg.
        while !band.is_empty() {
            let mut leg: Vec<Cell> = Vec::new();
            band.retain(|&cell| match leg.last() {
                Some(&last) if along(last) == along(cell) => line(cell).abs_diff(line(last)) > spacing / 2,
                _ => {
                    leg.push(cell);
                    false
                }
            });
            left.push(leg);
        }
    }
    [tracks.cells, left.cells]
}

/// Legs back and forth.
#[derive(Default)]
struct Legs {
    cells: Vec<Cell>,
    count: usize,
}

impl Legs {
    fn push(&mut self, mut leg: Vec<Cell>) {
        if !self.count.is_multiple_of(2) {
            leg.reverse();
        }
        self.count += 1;
        self.cells.extend(leg);
    }
}

/// Legs of 1, 1, 2, 2, 3, 3 and more spacings, turning right by 90 degrees, the first northward.
fn expanding_square(grid: Grid, routes: &ShortestPathTree, datum: Cell, spacing: u32) -> Vec<Cell> {
    let mut track = Track::new(grid, routes, datum);
    let spacing = i64::from(spacing);
    let mut direction = (1, 0);
    // Legs from the datum pass every cell of the map before they are twice as long as its longer side.
    let longest = 2 * i64::from(grid.rows().max(grid.columns())) + spacing;
    let legs = (1..).map(|leg: i64| (leg + 1) / 2 * spacing);
    for length in legs.take_while(|&length| length <= longest) {
        for _ in 0..length {
            track.enter((track.at.0 + direction.0, track.at.1 + direction.1));
        }
        let (north, east) = direction;
        direction = (-east, north);
    }
    track.cells
}

/// Legs of one radius, turning right by 120 degrees, three triangles through the datum; then the same turned by 30
/// degrees. The radius reaches the farthest side of what is in reach.
fn sector(grid: Grid, routes: &ShortestPathTree, datum: Cell) -> Vec<Cell> {
    let mut track = Track::new(grid, routes, datum);
    let center = track.at;
    let radius = routes
        .reached()
        .iter()
        .map(|&cell| {
            let (north, east) = place(grid.position(cell));
            (north - center.0).abs().max((east - center.1).abs())
        })
        .max()
        .unwrap_or(0);
    for turn in [0.0, FRAC_PI_6] {
        // Bearings, in sixths of a circle, of the corners of each triangle.
        for corners in [[0.0, 1.0], [4.0, 5.0], [2.0, 3.0]] {
            for corner in corners {
                let bearing = corner * FRAC_PI_3 + turn;
                let part = |share: f64| {
                    #[expect(clippy::cast_possible_truncation, reason = "at most the side of a map")]
                    let cells = (radius as f64 * share).round() as i64;
                    cells
                };
                track.go((center.0 + part(libm::cos(bearing)), center.1 + part(libm::sin(bearing))));
            }
            track.go(center);
        }
    }
    track.cells
}

/// North and east, cells; beyond the map too.
type Place = (i64, i64);

fn place(position: Position) -> Place {
    (i64::from(position.row), i64::from(position.column))
}

/// A track over the plane, and the cells in reach that it enters.
struct Track<'a> {
    grid: Grid,
    routes: &'a ShortestPathTree,
    at: Place,
    cells: Vec<Cell>,
}

impl<'a> Track<'a> {
    fn new(grid: Grid, routes: &'a ShortestPathTree, start: Cell) -> Self {
        Self { grid, routes, at: place(grid.position(start)), cells: vec![start] }
    }

    fn enter(&mut self, at: Place) {
        self.at = at;
        let position = (u32::try_from(at.0), u32::try_from(at.1));
        let (Ok(row), Ok(column)) = position else { return };
        let cell = self.grid.cell(Position { row, column });
        self.cells.extend(cell.filter(|&cell| self.routes.length(cell).is_finite()));
    }

    /// Straight to a place, through the cells nearest to the line.
    fn go(&mut self, to: Place) {
        let from = self.at;
        let steps = (to.0 - from.0).abs().max((to.1 - from.1).abs());
        for step in 1..=steps {
            let on = |from: i64, to: i64| from + (2 * (to - from) * step + steps).div_euclid(2 * steps);
            self.enter((on(from.0, to.0), on(from.1, to.1)));
        }
    }
}
