//! Which cells are traversable and which are searched.

use std::collections::BTreeSet;
use std::sync::Arc;

use xxhash_rust::xxh3::Xxh3;

use crate::cell::{Cell, Grid, GridSizeError, Offset, Position};
use crate::evidence::Digest;
use crate::line_of_sight::LineOfSight;
use crate::sensor::{FootprintCell, Sensor};

/// The ground of one cell. The two properties are independent: a lake can hold an object that no ground robot
/// reaches, and the road to the search area holds none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ground {
    /// A robot can be here.
    pub traversable: bool,
    /// An object can be here: inside the search polygon. Elsewhere the prior is 0.
    pub searched: bool,
}

impl Ground {
    /// Traversable and searched.
    pub const OPEN: Self = Self { traversable: true, searched: true };
    /// Neither traversable nor searched.
    pub const BLOCKED: Self = Self { traversable: false, searched: false };
    /// Searched, not traversable: an object can be here that is only seen from other cells.
    pub const OUT_OF_REACH: Self = Self { traversable: false, searched: true };
    /// Traversable, not searched.
    pub const PASSAGE: Self = Self { traversable: true, searched: false };
}

/// A map: its grid, the edge of a cell, the ground of each cell, and which cells walls hide from which.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    grid: Grid,
    cell_meters: f64,
    ground: Vec<Ground>,
    /// Ascending.
    thin_walls: Arc<[Cell]>,
    line_of_sight: LineOfSight,
}

/// Why a terrain is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TerrainError {
    /// The grid has no cells, or too many.
    #[error(transparent)]
    Size(#[from] GridSizeError),
    /// The edge of a cell is not a positive length.
    #[error("cell edge {0} m: allowed is a finite length above 0")]
    CellEdge(f64),
    /// The list of cells and the grid differ in length.
    #[error("ground of {given} cells for a grid of {expected}")]
    CellCount {
        /// Cells given.
        given: usize,
        /// Cells of the grid.
        expected: usize,
    },
    /// A character of the drawing has no meaning.
    #[error(
        "line {line}, column {column}: {found:?} is no ground; allowed are '.' open, '#' blocked, '~' out of reach, ',' passage"
    )]
    Character {
        /// From 1.
        line: usize,
        /// From 1.
        column: usize,
        /// The character.
        found: char,
    },
    /// Lines of the drawing have different lengths.
    #[error("line {line} has {given} cells, the first line has {expected}")]
    Ragged {
        /// From 1.
        line: usize,
        /// Cells in that line.
        given: usize,
        /// Cells in the first line.
        expected: usize,
    },
}

impl Terrain {
    /// A terrain from the ground of each cell, shape `[cells]`, by index. Its walls hide nothing.
    ///
    /// # Errors
    /// If the list does not fit the grid, or the edge is not a positive length.
    pub fn new(grid: Grid, cell_meters: f64, ground: Vec<Ground>) -> Result<Self, TerrainError> {
        if !(cell_meters.is_finite() && cell_meters > 0.0) {
            return Err(TerrainError::CellEdge(cell_meters));
        }
        if ground.len() != grid.cell_count() {
            return Err(TerrainError::CellCount { given: ground.len(), expected: grid.cell_count() });
        }
        Ok(Self {
            grid,
            cell_meters,
            ground,
            thin_walls: Arc::new([]),
            line_of_sight: LineOfSight::everywhere(),
        })
    }

    /// Reads a drawing, its first line the northern edge: `.` open, `#` blocked, `~` out of reach (searched, not
    /// traversable), `,` passage (traversable, not searched). Blank lines and spaces at a line's end are ignored.
    ///
    /// # Errors
    /// If the lines differ in length, or a character is none of these: with its line and column.
    pub fn from_ascii(drawing: &str, cell_meters: f64) -> Result<Self, TerrainError> {
        let lines: Vec<(usize, &str)> = drawing
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, line.trim_end()))
            .filter(|(_, line)| !line.is_empty())
            .collect();
        let expected = lines.first().map_or(0, |(_, line)| line.chars().count());
        let size = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let grid = Grid::new(size(lines.len()), size(expected))?;
        let mut ground = Vec::with_capacity(grid.cell_count());
        for &(line, text) in lines.iter().rev() {
            let given = text.chars().count();
            if given != expected {
                return Err(TerrainError::Ragged { line, given, expected });
            }
            for (index, found) in text.chars().enumerate() {
                ground.push(match found {
                    '.' => Ground::OPEN,
                    '#' => Ground::BLOCKED,
                    '~' => Ground::OUT_OF_REACH,
                    ',' => Ground::PASSAGE,
                    _ => return Err(TerrainError::Character { line, column: index + 1, found }),
                });
            }
        }
        Self::new(grid, cell_meters, ground)
    }

    /// The grid of cells.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Edge of a cell, meters.
    #[must_use]
    pub const fn cell_meters(&self) -> f64 {
        self.cell_meters
    }

    /// The ground of one cell.
    #[must_use]
    pub fn ground(&self, cell: Cell) -> Ground {
        self.ground[cell.index()]
    }

    /// Whether a robot can be in this cell.
    #[must_use]
    pub fn is_traversable(&self, cell: Cell) -> bool {
        self.ground[cell.index()].traversable
    }

    /// Whether an object can be in this cell.
    #[must_use]
    pub fn is_searched(&self, cell: Cell) -> bool {
        self.ground[cell.index()].searched
    }

    /// Whether this cell is a wall: no robot and no object can be here.
    #[must_use]
    pub fn is_wall(&self, cell: Cell) -> bool {
        self.ground(cell) == Ground::BLOCKED
    }

    /// Cells that are no walls, and that a wall thinner than a cell leads along: sensors see them, and do not see through them
    /// where they need a line of sight. Ascending.
    #[must_use]
    pub fn thin_walls(&self) -> &[Cell] {
        &self.thin_walls
    }

    /// The same map with such cells. What is hidden stays the same.
    #[must_use]
    pub fn with_thin_walls(self, cells: impl IntoIterator<Item = Cell>) -> Self {
        let cells: BTreeSet<Cell> = cells.into_iter().collect();
        Self { thin_walls: cells.into_iter().collect(), ..self }
    }

    /// Whether this cell hides what is behind it where sensors need a line of sight: it is a wall, or a thin one leads along it.
    #[must_use]
    pub fn is_opaque(&self, cell: Cell) -> bool {
        self.is_wall(cell) || self.thin_walls.binary_search(&cell).is_ok()
    }

    /// Which cells are hidden from which.
    #[must_use]
    pub const fn line_of_sight(&self) -> &LineOfSight {
        &self.line_of_sight
    }

    /// The same map with other cells hidden.
    #[must_use]
    pub fn with_line_of_sight(self, line_of_sight: LineOfSight) -> Self {
        Self { line_of_sight, ..self }
    }

    /// The same map, whose opaque cells hide what is behind them within a radius, cells.
    #[must_use]
    pub fn with_opaque_walls(self, radius: u32) -> Self {
        let line_of_sight = LineOfSight::behind_walls(&self, radius);
        self.with_line_of_sight(line_of_sight)
    }

    /// The cells on the map that a sensor on the ground sees from a cell, in the order of its footprint.
    pub fn in_sight<'a>(
        &'a self,
        sensor: &'a Sensor,
        from: Cell,
    ) -> impl Iterator<Item = (Cell, &'a FootprintCell)> {
        self.line_of_sight.seen(self.grid, sensor, from)
    }

    /// Whether a sensor on the ground sees a cell from another.
    #[must_use]
    pub fn is_in_sight(&self, sensor: &Sensor, from: Cell, cell: Cell) -> bool {
        let offset = self.grid.offset(from, cell);
        offset.manhattan() <= sensor.radius() && !self.line_of_sight.hides(from, offset)
    }

    /// XXH3-128 of size, cell edge and ground, by index: different maps have different digests. What is hidden does not count.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut hash = Xxh3::new();
        hash.update(&self.grid.rows().to_le_bytes());
        hash.update(&self.grid.columns().to_le_bytes());
        hash.update(&self.cell_meters.to_le_bytes());
        for ground in &self.ground {
            hash.update(&[u8::from(ground.traversable), u8::from(ground.searched)]);
        }
        Digest(hash.digest128())
    }

    /// Whether another map differs in what is hidden at most.
    #[must_use]
    pub fn is_equal_ground(&self, other: &Self) -> bool {
        let Self { grid, cell_meters, ground, thin_walls: _, line_of_sight: _ } = self;
        (grid, cell_meters, ground) == (&other.grid, &other.cell_meters, &other.ground)
    }

    /// Traversable cells, by index.
    pub fn traversable_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.grid.cells().filter(|&cell| self.is_traversable(cell))
    }

    /// Adds this cell to the search area.
    pub(crate) fn search(&mut self, cell: Cell) {
        self.ground[cell.index()].searched = true;
    }

    /// The same map with other ground in these cells.
    #[must_use]
    pub fn with_ground(&self, cells: impl IntoIterator<Item = (Cell, Ground)>) -> Self {
        let mut terrain = self.clone();
        for (cell, ground) in cells {
            terrain.ground[cell.index()] = ground;
        }
        terrain
    }

    /// The map of a robot that crosses every cell, and from which nothing is hidden.
    #[must_use]
    pub fn from_above(&self) -> Self {
        let ground = self.ground.iter().map(|ground| Ground { traversable: true, ..*ground });
        Self { ground: ground.collect(), line_of_sight: LineOfSight::everywhere(), ..self.clone() }
    }

    /// Searched cells, by index.
    pub fn searched_cells(&self) -> impl Iterator<Item = Cell> + '_ {
        self.grid.cells().filter(|&cell| self.is_searched(cell))
    }

    /// Cells of the largest connected traversable area, by index; of two equal ones the one with the smallest cell.
    #[must_use]
    pub fn largest_area(&self) -> Vec<Cell> {
        self.connected_areas().into_iter().next().unwrap_or_default()
    }

    /// The cells of each connected traversable area, by index; the largest area first, and of equal ones the one with the
    /// smallest cell. Connection is by the 4 neighbors.
    #[must_use]
    pub fn connected_areas(&self) -> Vec<Vec<Cell>> {
        let mut seen = vec![false; self.grid.cell_count()];
        let mut areas = Vec::new();
        for start in self.traversable_cells() {
            if std::mem::replace(&mut seen[start.index()], true) {
                continue;
            }
            let mut area = vec![start];
            let mut next = 0;
            while next < area.len() {
                for (north, east) in [(-1, 0), (0, -1), (0, 1), (1, 0)] {
                    if let Some(cell) = self.grid.step(area[next], Offset { north, east })
                        && self.is_traversable(cell)
                        && !std::mem::replace(&mut seen[cell.index()], true)
                    {
                        area.push(cell);
                    }
                }
                next += 1;
            }
            area.sort_unstable();
            areas.push(area);
        }
        // Stable: they were met by their smallest cells.
        areas.sort_by_key(|area| std::cmp::Reverse(area.len()));
        areas
    }

    /// Center of a cell, meters east and north of the map's south-western corner.
    #[must_use]
    pub fn center_meters(&self, cell: Cell) -> (f64, f64) {
        let Position { row, column } = self.grid.position(cell);
        ((f64::from(column) + 0.5) * self.cell_meters, (f64::from(row) + 0.5) * self.cell_meters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_line_of_a_drawing_is_the_northern_edge() {
        let terrain = Terrain::from_ascii("#.\n,~\n", 30.0).unwrap();
        let ground: Vec<Ground> = terrain.grid().cells().map(|cell| terrain.ground(cell)).collect();
        assert_eq!(ground, [Ground::PASSAGE, Ground::OUT_OF_REACH, Ground::BLOCKED, Ground::OPEN]);
        let south_east = terrain.grid().cell_numbered(1).unwrap();
        assert_eq!(terrain.center_meters(south_east), (45.0, 15.0));
    }

    #[test]
    fn a_bad_drawing_names_its_line() {
        let check = |drawing: &str, message: &str| {
            let error = Terrain::from_ascii(drawing, 1.0).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        check("..\n.x\n", "line 2, column 2: 'x' is no ground");
        check("..\n...\n", "line 2 has 3 cells, the first line has 2");
        check("\n\n", "0 rows");
    }

    #[test]
    fn areas_are_connected_and_the_largest_is_the_first() {
        let terrain = Terrain::from_ascii("..#.\n..#.\n###.\n.#..\n", 1.0).unwrap();
        let indices = |area: &Vec<Cell>| area.iter().map(|cell| cell.index()).collect::<Vec<_>>();
        let areas: Vec<_> = terrain.connected_areas().iter().map(indices).collect();
        assert_eq!(areas, [vec![2, 3, 7, 11, 15], vec![8, 9, 12, 13], vec![0]]);
        assert_eq!(indices(&terrain.largest_area()), areas[0]);
        // Of two equal ones.
        let terrain = Terrain::from_ascii("..#..\n", 1.0).unwrap();
        assert_eq!(indices(&terrain.largest_area()), [0, 1]);
    }
}
