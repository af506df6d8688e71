//! The cost map: the cost of the ground, and cells that a vehicle cannot enter.

use dragnet_search::cell::{Cell, Grid, GridSizeError, Position};
use dragnet_search::terrain::Terrain;

/// Cost from which a cell is lethal: no part of the vehicle may be in it.
pub const LETHAL: u8 = 253;

/// The cost of each cell of a rectangle of ground. A path of length `l` through cells of cost `c` costs `l (1 + c)`.
#[derive(Clone, Debug, PartialEq)]
pub struct CostMap {
    grid: Grid,
    resolution_meters: f64,
    /// Position of the south-western corner.
    origin_meters: (f64, f64),
    /// 0 to 252, or [`LETHAL`] and above, shape `[cells]`, by index.
    costs: Vec<u8>,
}

/// Interpretation of an occupancy grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OccupancyRule {
    /// From this percentage on a cell is [`LETHAL`]; below it costs its percentage. 1 to 100.
    pub lethal_percent: u8,
    /// Cost of unknown cells, 0 to 255.
    pub unknown_cost: u8,
}

/// Why a cost map is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CostMapError {
    /// The grid has no cells, or too many.
    #[error(transparent)]
    Size(#[from] GridSizeError),
    /// The resolution is not a positive length.
    #[error("a resolution of {0} m: allowed is a finite length above 0")]
    Resolution(f64),
    /// The origin is not finite.
    #[error("an origin of ({0} m, {1} m): allowed are finite numbers")]
    Origin(f64, f64),
    /// The list of cells and the grid differ in length.
    #[error("costs of {given} cells for a grid of {expected}; a map of another size is a new map")]
    CellCount {
        /// Cells given.
        given: usize,
        /// Cells of the grid.
        expected: usize,
    },
    /// Terrain cells divided into 0 parts.
    #[error("each cell of the terrain cut into {0} x {0}: allowed is 1 or more")]
    Parts(u32),
    /// An invalid percentage.
    #[error("lethal from {0} % on: allowed are 1 to 100")]
    LethalPercent(u8),
    /// An invalid occupancy.
    #[error("occupancy {value} of cell {index}: allowed are 0 to 100, and -1 for unknown")]
    Occupancy {
        /// Row-major index.
        index: usize,
        /// The given value.
        value: i8,
    },
    /// A cell that is not on this map.
    #[error("cell {number} of a map of {cells} cells: a map of another size is a new map")]
    Cell {
        /// Row-major number.
        number: u32,
        /// Cells of the map.
        cells: usize,
    },
}

impl CostMap {
    /// A map from the cost of each cell, shape `[cells]`, by index: rows from south to north, each from west to east.
    ///
    /// # Errors
    /// If the list does not fit the grid, or resolution or origin are invalid.
    pub fn new(
        grid: Grid,
        resolution_meters: f64,
        origin_meters: (f64, f64),
        costs: Vec<u8>,
    ) -> Result<Self, CostMapError> {
        if !(resolution_meters.is_finite() && resolution_meters > 0.0) {
            return Err(CostMapError::Resolution(resolution_meters));
        }
        if !(origin_meters.0.is_finite() && origin_meters.1.is_finite()) {
            return Err(CostMapError::Origin(origin_meters.0, origin_meters.1));
        }
        if costs.len() != grid.cell_count() {
            return Err(CostMapError::CellCount { given: costs.len(), expected: grid.cell_count() });
        }
        Ok(Self { grid, resolution_meters, origin_meters, costs })
    }

    /// The map of a terrain, each of its cells divided into `parts x parts`: free if traversable, else lethal. Its
    /// origin is the terrain's south-western corner.
    ///
    /// # Errors
    /// If `parts` is 0, or the map had too many cells.
    pub fn from_terrain(terrain: &Terrain, parts: u32) -> Result<Self, CostMapError> {
        if parts == 0 {
            return Err(CostMapError::Parts(parts));
        }
        let coarse = terrain.grid();
        let grid = Grid::new(coarse.rows().saturating_mul(parts), coarse.columns().saturating_mul(parts))?;
        let cost = |cell| {
            let Position { row, column } = grid.position(cell);
            let ground = coarse.cell(Position { row: row / parts, column: column / parts });
            if ground.is_some_and(|ground| terrain.is_traversable(ground)) { 0 } else { LETHAL }
        };
        let costs = grid.cells().map(cost).collect();
        Self::new(grid, terrain.cell_meters() / f64::from(parts), (0.0, 0.0), costs)
    }

    /// The map of a ROS occupancy grid: percent, -1 where unknown, rows from south to north.
    ///
    /// # Errors
    /// As [`CostMap::new`], and if a byte or the rule is out of its range.
    pub fn from_occupancy(
        grid: Grid,
        resolution_meters: f64,
        origin_meters: (f64, f64),
        occupancy: &[i8],
        rule: OccupancyRule,
    ) -> Result<Self, CostMapError> {
        if !(1..=100).contains(&rule.lethal_percent) {
            return Err(CostMapError::LethalPercent(rule.lethal_percent));
        }
        let cost = |(index, &value): (usize, &i8)| match u8::try_from(value) {
            Ok(percent) if percent > 100 => Err(CostMapError::Occupancy { index, value }),
            Ok(percent) if percent >= rule.lethal_percent => Ok(LETHAL),
            Ok(percent) => Ok(percent),
            Err(_) if value == -1 => Ok(rule.unknown_cost),
            Err(_) => Err(CostMapError::Occupancy { index, value }),
        };
        let costs = occupancy.iter().enumerate().map(cost).collect::<Result<_, _>>()?;
        Self::new(grid, resolution_meters, origin_meters, costs)
    }

    /// The grid of cells.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Edge of a cell, meters.
    #[must_use]
    pub const fn resolution_meters(&self) -> f64 {
        self.resolution_meters
    }

    /// Position of the south-western corner, meters.
    #[must_use]
    pub const fn origin_meters(&self) -> (f64, f64) {
        self.origin_meters
    }

    /// Costs by index, shape `[cells]`.
    #[must_use]
    pub fn costs(&self) -> &[u8] {
        &self.costs
    }

    /// Whether a cell is lethal: no part of a vehicle may be in it.
    #[must_use]
    pub fn is_lethal(&self, cell: Cell) -> bool {
        self.costs[cell.index()] >= LETHAL
    }

    /// The cell at a position in meters, if it is on the map.
    #[must_use]
    pub fn cell_at(&self, x_meters: f64, y_meters: f64) -> Option<Cell> {
        let (east_meters, north_meters) = (x_meters - self.origin_meters.0, y_meters - self.origin_meters.1);
        self.grid.cell_at(east_meters / self.resolution_meters, north_meters / self.resolution_meters)
    }

    /// Center of a cell, meters.
    #[must_use]
    pub fn center_meters(&self, cell: Cell) -> (f64, f64) {
        let Position { row, column } = self.grid.position(cell);
        (
            self.origin_meters.0 + (f64::from(column) + 0.5) * self.resolution_meters,
            self.origin_meters.1 + (f64::from(row) + 0.5) * self.resolution_meters,
        )
    }

    /// Whether something lethal lies between two positions, meters: on the straight line from one to the other a lethal cell is
    /// followed by one that is not. What surrounds the first position hides nothing, and what is inside of an obstacle is as
    /// visible as the side of it that faces the first position. Beyond the map nothing is known to hide.
    #[must_use]
    pub fn hides(&self, from_meters: (f64, f64), to_meters: (f64, f64)) -> bool {
        self.hidden_from(from_meters, to_meters).is_some()
    }

    /// The part of the straight line between two positions, 0 to 1, from which on it is hidden by [`CostMap::hides`]; `None` if it
    /// is nowhere.
    #[must_use]
    pub fn hidden_from(&self, from_meters: (f64, f64), to_meters: (f64, f64)) -> Option<f64> {
        let mut was_free = false;
        let mut is_blocked = false;
        for (part, square) in self.squares_between(from_meters, to_meters) {
            let is_lethal = square.is_some_and(|cell| self.is_lethal(cell));
            if is_blocked && !is_lethal {
                return Some(part);
            }
            is_blocked = was_free && is_lethal;
            was_free |= !is_lethal;
        }
        None
    }

    /// The cells that a straight line passes through, in order, `None` beyond the map, each with the part of the line at which it
    /// enters it: the traversal of Amanatides and Woo (1987).
    fn squares_between(
        &self,
        from: (f64, f64),
        to: (f64, f64),
    ) -> impl Iterator<Item = (f64, Option<Cell>)> + '_ {
        let place = |meters: f64, origin_meters: f64| (meters - origin_meters) / self.resolution_meters;
        let (east, north) = self.origin_meters;
        let mut lines = [
            Line::new(place(from.0, east), place(to.0, east)),
            Line::new(place(from.1, north), place(to.1, north)),
        ];
        let steps = lines.iter().map(|line| line.steps).sum::<u64>();
        (0..=steps).map(move |step| {
            let [across, up] = &mut lines;
            let part = if step > 0 { across.next.min(up.next) } else { 0.0 };
            if step > 0 {
                if across.next < up.next { across.step() } else { up.step() }
            }
            (part, self.grid.cell_at(across.square + 0.5, up.square + 0.5))
        })
    }

    /// Sets the cost of one cell.
    ///
    /// # Errors
    /// If the cell is not on this map.
    pub fn set(&mut self, cell: Cell, cost: u8) -> Result<(), CostMapError> {
        let cells = self.costs.len();
        let known = self.costs.get_mut(cell.index());
        *known.ok_or(CostMapError::Cell { number: cell.number(), cells })? = cost;
        Ok(())
    }
}

/// One coordinate of a straight line over squares with sides of 1.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// The lower border of the current square.
    square: f64,
    /// Squares to go.
    steps: u64,
    /// 1 or -1.
    direction: f64,
    /// The part of the line at which it leaves the square, and the part that a square takes.
    next: f64,
    part: f64,
}

impl Line {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "of maps, whose sides are bounded"
    )]
    fn new(from: f64, to: f64) -> Self {
        let square = from.floor();
        let direction = if to < from { -1.0 } else { 1.0 };
        let part = 1.0 / (to - from).abs();
        let left = if direction > 0.0 { square + 1.0 - from } else { from - square };
        let steps = (to.floor() - square).abs() as u64;
        // A line along the other axis never leaves.
        let next = if steps == 0 { f64::INFINITY } else { left * part };
        Self { square, steps, direction, next, part }
    }

    fn step(&mut self) {
        self.square += self.direction;
        self.steps -= 1;
        self.next = if self.steps == 0 { f64::INFINITY } else { self.next + self.part };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    #[test]
    fn a_wall_hides_what_is_behind_it_and_not_itself() {
        // Of 1 m squares; the origin is 10 m west and 20 m south.
        let terrain = Terrain::from_ascii("......\n..#...\n..#...\n..#...\n......", 1.0).unwrap();
        let costs = CostMap::from_terrain(&terrain, 1).unwrap().costs().to_vec();
        let map = CostMap::new(terrain.grid(), 1.0, (-10.0, -20.0), costs).unwrap();
        let check = |from: (f64, f64), to: (f64, f64), expected: bool| {
            let [from, to] = [from, to].map(|(x, y)| (x - 10.0, y - 20.0));
            assert_eq!(map.hides(from, to), expected, "{from:?} {to:?}");
        };
        check((0.5, 2.5), (1.9, 2.5), false);
        check((0.5, 2.5), (2.5, 2.5), false);
        check((0.5, 2.5), (3.1, 2.5), true);
        check((5.5, 2.5), (0.5, 2.5), true);
        assert_eq!(map.hidden_from((-9.5, -17.5), (-5.5, -17.5)), Some(2.5 / 4.0));
        // Past its end, and across a corner.
        check((0.5, 0.5), (5.5, 0.5), false);
        check((0.5, 0.5), (4.5, 0.9), false);
        check((0.5, 0.5), (4.5, 4.5), true);
        check((1.5, 4.9), (3.5, 4.1), false);
        check((2.5, 4.5), (2.5, 0.5), true);
        // A vehicle that its own map covers still sees.
        check((2.5, 2.5), (5.5, 2.5), false);
        check((2.5, 2.5), (2.5, 0.5), false);
        // Beyond the map, and without a way.
        check((0.5, 2.5), (-90.0, 2.5), false);
        check((0.5, 2.5), (0.5, 2.5), false);
        check((-3.0, 2.5), (9.0, 2.5), true);
    }

    #[test]
    fn a_line_passes_through_neighboring_squares_from_end_to_end() {
        let map = CostMap::new(Grid::new(40, 40).unwrap(), 1.0, (0.0, 0.0), vec![0; 1600]).unwrap();
        let mut number = 0.0_f64;
        let mut draw = || {
            number += 0.618_033_988_749_895;
            number.fract() * 40.0
        };
        for _ in 0..2000 {
            let (from, to) = ((draw(), draw()), (draw(), draw()));
            let squares: Vec<Position> =
                map.squares_between(from, to).map(|(_, cell)| map.grid.position(cell.unwrap())).collect();
            let of = |(x, y): (f64, f64)| map.grid.position(map.cell_at(x, y).unwrap());
            assert_eq!((squares[0], squares[squares.len() - 1]), (of(from), of(to)));
            let apart = |pair: &[Position]| {
                pair[0].row.abs_diff(pair[1].row) + pair[0].column.abs_diff(pair[1].column)
            };
            assert!(squares.windows(2).all(|pair| apart(pair) == 1), "{from:?} {to:?} {squares:?}");
            // None is farther from the line than its corners.
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            for square in squares {
                let (x, y) = (f64::from(square.column) + 0.5 - from.0, f64::from(square.row) + 0.5 - from.1);
                assert!((x * dy - y * dx).abs() / dx.hypot(dy) < 0.7072, "{square:?}");
            }
        }
    }

    #[test]
    fn a_terrain_is_cut_finer() {
        let terrain = Terrain::from_ascii("#.\n,~\n", 30.0).unwrap();
        let map = CostMap::from_terrain(&terrain, 2).unwrap();
        let south = [0, 0, LETHAL, LETHAL];
        let north = [LETHAL, LETHAL, 0, 0];
        assert_eq!(map.costs(), [south, south, north, north].concat());
        assert!((map.resolution_meters() - 15.0).abs() < 1e-12);
        assert_eq!(map.cell_at(31.0, 1.0).unwrap().index(), 2);
        assert_eq!(map.center_meters(map.cell_at(31.0, 16.0).unwrap()), (37.5, 22.5));
        assert_eq!(map.cell_at(60.0, 1.0), None);
        assert_eq!(map.cell_at(-0.1, 1.0), None);
        assert_eq!(map.cell_at(f64::NAN, 1.0), None);
        assert!(CostMap::from_terrain(&terrain, 0).is_err());
        assert!(CostMap::from_terrain(&terrain, u32::MAX).is_err());
    }

    #[test]
    fn occupancy_is_percent() {
        let grid = Grid::new(1, 4).unwrap();
        let rule = OccupancyRule { lethal_percent: 65, unknown_cost: 10 };
        let map = |bytes: &[i8]| CostMap::from_occupancy(grid, 0.1, (-1.0, 2.0), bytes, rule);
        assert_eq!(map(&[-1, 0, 64, 65]).unwrap().costs(), [10, 0, 64, LETHAL]);
        let message = |bytes: &[i8]| map(bytes).unwrap_err().to_string();
        assert_mentions(&message(&[0, 101, 0, 0]), "101 .. cell 1 .. 0 to 100 .. -1");
        assert_mentions(&message(&[0, 0, -2, 0]), "-2 .. cell 2 .. 0 to 100 .. -1");
        assert_mentions(&message(&[0]), "1 cells .. 4");
    }
}
