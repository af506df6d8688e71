//! Maps generated from a seed, for training and testing on many shapes.

use rand::RngExt;

use crate::cell::{Cell, Grid, Offset, Position};
use crate::seed::{Purpose, Stream, stream};
use crate::terrain::{Ground, Terrain, TerrainError};

/// A kind of generated map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Generated {
    /// Winding caves: random cells, smoothed by a majority filter.
    Caves,
    /// Open ground with rectangular blocks, as between buildings.
    Blocks,
    /// Rooms with a door to each neighbor, by recursive division.
    Rooms,
}

/// Share of the cells that is open before caves are smoothed, and how often they are.
const CAVE_OPEN_SHARE: f64 = 0.56;
const CAVE_ROUNDS: u32 = 4;
/// Map cells per block.
const CELLS_A_BLOCK: usize = 60;
/// The longest side of a block, cells: on the largest of maps as well about half of the cells stay open.
const LONGEST_BLOCK: u32 = 12;
/// Rooms are divided until a side is below this, cells.
const LEAST_ROOM: u32 = 9;
/// Width of a door, cells.
const DOOR: u32 = 2;

impl Generated {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Caves, Self::Blocks, Self::Rooms];

    /// The name used in scenarios.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Caves => "caves",
            Self::Blocks => "blocks",
            Self::Rooms => "rooms",
        }
    }

    /// Generates a map with cells of edge `cell_meters`, meters: one connected open area; all other cells are blocked.
    ///
    /// # Errors
    /// If the edge is not a positive length.
    pub fn terrain(self, grid: Grid, cell_meters: f64, seed: u64) -> Result<Terrain, TerrainError> {
        let mut random = stream(seed, Purpose::Map, 0);
        let is_open = match self {
            Self::Caves => caves(grid, &mut random),
            Self::Blocks => blocks(grid, &mut random),
            Self::Rooms => rooms(grid, &mut random),
        };
        let ground = is_open.iter().map(|&is_open| if is_open { Ground::OPEN } else { Ground::BLOCKED });
        let drawn = Terrain::new(grid, cell_meters, ground.collect())?;
        let mut ground = vec![Ground::BLOCKED; grid.cell_count()];
        for cell in drawn.largest_area() {
            ground[cell.index()] = Ground::OPEN;
        }
        if !ground.contains(&Ground::OPEN) {
            // A tiny map of which no cell is open.
            ground.fill(Ground::OPEN);
        }
        Terrain::new(grid, cell_meters, ground)
    }
}

fn caves(grid: Grid, random: &mut Stream) -> Vec<bool> {
    let mut is_open: Vec<bool> = grid.cells().map(|_| random.random::<f64>() < CAVE_OPEN_SHARE).collect();
    for _ in 0..CAVE_ROUNDS {
        let is_majority_open = |cell: Cell| {
            let around = (-1..=1).flat_map(|north| (-1..=1).map(move |east| Offset { north, east }));
            let open =
                around.filter_map(|offset| grid.step(cell, offset)).filter(|cell| is_open[cell.index()]);
            open.count() >= 5
        };
        is_open = grid.cells().map(is_majority_open).collect();
    }
    is_open
}

fn blocks(grid: Grid, random: &mut Stream) -> Vec<bool> {
    let mut is_open = vec![true; grid.cell_count()];
    let longest = (grid.rows().min(grid.columns()) / 5).clamp(2, LONGEST_BLOCK);
    for _ in 0..grid.cell_count() / CELLS_A_BLOCK {
        let (rows, columns) = (random.random_range(1..=longest), random.random_range(1..=longest));
        let (south, west) = (random.random_range(0..grid.rows()), random.random_range(0..grid.columns()));
        close(grid, &mut is_open, south..south + rows, west..west + columns);
    }
    is_open
}

/// Part of a map, ends left out.
#[derive(Clone, Copy)]
struct Area {
    rows: (u32, u32),
    columns: (u32, u32),
}

fn rooms(grid: Grid, random: &mut Stream) -> Vec<bool> {
    let mut is_open = vec![true; grid.cell_count()];
    let mut areas = vec![Area { rows: (0, grid.rows()), columns: (0, grid.columns()) }];
    while let Some(Area { rows, columns }) = areas.pop() {
        let (height, width) = (rows.1 - rows.0, columns.1 - columns.0);
        if height.max(width) < LEAST_ROOM {
            continue;
        }
        // Across the longer side, away from the walls.
        if height >= width {
            let wall = random.random_range(rows.0 + 3..rows.1 - 3);
            let door = random.random_range(columns.0..=columns.1.saturating_sub(DOOR).max(columns.0));
            close(grid, &mut is_open, wall..wall + 1, columns.0..door);
            close(grid, &mut is_open, wall..wall + 1, door + DOOR..columns.1);
            areas
                .extend([Area { rows: (rows.0, wall), columns }, Area { rows: (wall + 1, rows.1), columns }]);
        } else {
            let wall = random.random_range(columns.0 + 3..columns.1 - 3);
            let door = random.random_range(rows.0..=rows.1.saturating_sub(DOOR).max(rows.0));
            close(grid, &mut is_open, rows.0..door, wall..wall + 1);
            close(grid, &mut is_open, door + DOOR..rows.1, wall..wall + 1);
            areas.extend([
                Area { rows, columns: (columns.0, wall) },
                Area { rows, columns: (wall + 1, columns.1) },
            ]);
        }
    }
    is_open
}

/// Closes cells as far as they are on the map.
fn close(grid: Grid, is_open: &mut [bool], rows: std::ops::Range<u32>, columns: std::ops::Range<u32>) {
    for row in rows {
        for column in columns.clone() {
            if let Some(cell) = grid.cell(Position { row, column }) {
                is_open[cell.index()] = false;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(kind: Generated, rows: u32, columns: u32, seed: u64) -> Terrain {
        kind.terrain(Grid::new(rows, columns).unwrap(), 1.0, seed).unwrap()
    }

    #[test]
    fn a_seed_draws_one_connected_area_that_is_neither_all_nor_nothing() {
        for kind in Generated::ALL {
            for seed in 0..50 {
                let terrain = draw(kind, 30, 24, seed);
                let open = terrain.traversable_cells().count();
                assert_eq!(terrain.largest_area().len(), open, "{kind:?} {seed}");
                assert!((100..720).contains(&open), "{kind:?} {seed}: {open}");
                assert_eq!(terrain, draw(kind, 30, 24, seed));
            }
            assert_ne!(draw(kind, 30, 24, 1), draw(kind, 30, 24, 2));
        }
    }

    #[test]
    fn a_large_map_is_as_open_as_a_small_one() {
        for kind in Generated::ALL {
            let open = draw(kind, 400, 300, 1).traversable_cells().count();
            assert!((30_000..110_000).contains(&open), "{kind:?}: {open}");
        }
    }

    #[test]
    fn a_tiny_map_is_open() {
        for kind in Generated::ALL {
            for seed in 0..20 {
                assert!(draw(kind, 1, 2, seed).traversable_cells().next().is_some());
            }
        }
    }
}
