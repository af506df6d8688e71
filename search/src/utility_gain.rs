//! The utility gain of a further observation of each cell, shared by all policies that score it and the learned ones.

use std::ops::Range;

use crate::cell::{Cell, Grid, Offset};
use crate::line_of_sight::{Shadows, Views};
use crate::route::ShortestPathTree;
use crate::sensor::FootprintCell;
use crate::situation::Situation;
use crate::utility::{Row, SATURATION, UtilityTable};

/// Per cell: its row of a utility table, the precision that teammates plan to add, and the utility of that precision.
///
/// The map is framed by `radius` cells of certainty on each side, so that a footprint never leaves the array.
pub struct UtilityGain<'t> {
    table: &'t UtilityTable,
    frame: Frame,
    cells: Vec<CellGain>,
}

/// The state of one cell while a path is scored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellGain {
    /// Its log-odds, as a row of the table.
    pub(crate) row: Row,
    /// Precision counted so far, units of evidence, at most [`SATURATION`]; [`SATURATION`] for a cell that can yield
    /// nothing.
    pub(crate) precision: i32,
    /// Utility of that precision.
    pub(crate) utility: f32,
}

/// Indices of the framed map.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    grid: Grid,
    radius: usize,
    stride: usize,
}

impl Frame {
    pub(crate) fn new(grid: Grid, radius: u32) -> Self {
        let radius = radius as usize;
        Self { grid, radius, stride: grid.columns() as usize + 2 * radius }
    }

    /// Cells of a row, with the frame.
    pub(crate) const fn stride(self) -> usize {
        self.stride
    }

    pub(crate) fn cell_count(self) -> usize {
        (self.grid.rows() as usize + 2 * self.radius) * self.stride
    }

    /// Index of a cell within the frame.
    pub(crate) fn index(self, cell: Cell) -> usize {
        let position = self.grid.position(cell);
        (position.row as usize + self.radius) * self.stride + position.column as usize + self.radius
    }

    /// Indices of the cells that lie at an offset within the radius from those of each row of the map.
    pub(crate) fn rows_at(self, offset: Offset) -> impl Iterator<Item = Range<usize>> {
        let columns = self.grid.columns() as usize;
        (0..self.grid.rows() as usize).map(move |row| {
            let start = (row + self.radius) * self.stride + self.radius;
            let start = start.wrapping_add_signed(self.stride_of(offset));
            start..start + columns
        })
    }

    /// The sum of `gain` over what is seen in an observation from each cell of the map, shape `[cells]`; `gain` of a cell
    /// of the frame depends on the precision of its reading only, and so is computed once per ring.
    pub(crate) fn sum_over_footprints<C>(
        self,
        situation: &Situation<'_>,
        cells: &[C],
        gain: impl Fn(&C, i64) -> f32,
    ) -> Vec<f32> {
        let columns = self.grid.columns() as usize;
        let mut sums = vec![0.0_f32; self.grid.cell_count()];
        let mut ring_gain = vec![0.0_f32; cells.len()];
        let views = Views::of(situation);
        let mut limited = Limited::new(self, views.as_ref(), 0.0_f32);
        for ring in situation.sensor.rings() {
            let precision = ring[0].precision;
            for (ring_gain, cell) in ring_gain.iter_mut().zip(cells) {
                *ring_gain = gain(cell, precision);
            }
            limited.add(&ring, |sum, seen| *sum += ring_gain[seen]);
            for observation in ring {
                for (sums, seen) in sums.chunks_exact_mut(columns).zip(self.rows_at(observation.offset)) {
                    for (sum, gain) in sums.iter_mut().zip(&ring_gain[seen]) {
                        *sum += gain;
                    }
                }
            }
        }
        for (from, sum) in limited.sums() {
            sums[from.index()] = sum;
        }
        sums
    }

    /// What to add to an index to move by an offset that is within the radius.
    #[expect(clippy::cast_possible_wrap, reason = "a framed map has fewer than 2^31 cells")]
    pub(crate) fn stride_of(self, offset: Offset) -> isize {
        offset.north as isize * self.stride as isize + offset.east as isize
    }
}

/// Sums over what is seen from each cell from which walls hide something, ring by ring.
pub(crate) struct Limited<'v, S> {
    frame: Frame,
    views: Option<&'v Views<'v>>,
    cells: Vec<LimitedCell<'v, S>>,
}

struct LimitedCell<'v, S> {
    cell: Cell,
    /// Its index within the frame.
    index: usize,
    shadows: Shadows<'v>,
    sum: S,
}

impl<'v, S: Clone> Limited<'v, S> {
    /// Each begins with a sum.
    pub(crate) fn new(frame: Frame, views: Option<&'v Views<'v>>, sum: S) -> Self {
        let limited = views.into_iter().flat_map(|views| views.limited(frame.grid));
        let begin =
            |(cell, shadows)| LimitedCell { cell, index: frame.index(cell), shadows, sum: sum.clone() };
        Self { frame, views, cells: limited.map(begin).collect() }
    }

    /// Adds to each sum all cells of a ring of the footprint that are seen, by their indices within the frame.
    pub(crate) fn add(&mut self, ring: &[FootprintCell], add: impl Fn(&mut S, usize)) {
        let Some(views) = self.views else { return };
        let of = |it: &FootprintCell| (views.place(it.offset), self.frame.stride_of(it.offset));
        let ring: Vec<(usize, isize)> = ring.iter().map(of).collect();
        for LimitedCell { index, shadows, sum, .. } in &mut self.cells {
            for &(_, step) in ring.iter().filter(|(place, _)| !shadows.hide_place(*place)) {
                add(sum, index.wrapping_add_signed(step));
            }
        }
    }

    /// The cells, by index, with their sums.
    pub(crate) fn sums(self) -> impl Iterator<Item = (Cell, S)> {
        self.cells.into_iter().map(|it| (it.cell, it.sum))
    }
}

impl UtilityGain<'static> {
    /// The information gain of a situation.
    #[must_use]
    pub fn information(situation: &Situation<'_>) -> Self {
        Self::new(UtilityTable::information(), situation)
    }
}

impl<'t> UtilityGain<'t> {
    /// The utility gain of a situation, by a table.
    #[must_use]
    pub fn new(table: &'t UtilityTable, situation: &Situation<'_>) -> Self {
        let frame = Frame::new(situation.terrain.grid(), situation.sensor.radius());
        let certain = CellGain { row: table.row(f64::INFINITY), precision: SATURATION, utility: 0.0 };
        let mut cells = vec![certain; frame.cell_count()];
        for cell in situation.terrain.grid().cells() {
            let precision = saturated(situation.planned_precision.precision(cell));
            if precision >= SATURATION {
                continue;
            }
            let row = table.row(situation.belief.log_odds_nats(cell));
            if row.is_certain() {
                continue;
            }
            let utility = table.utility(row, precision);
            cells[frame.index(cell)] = CellGain { row, precision, utility };
        }
        Self { table, frame, cells }
    }

    /// Utility gain of all cells together: an upper bound for any path.
    pub(crate) fn most(&self) -> f64 {
        self.cells.iter().map(|cell| f64::from(self.left_of(cell))).sum()
    }

    /// Utility gain of each cell if it became certain, row by row.
    pub(crate) fn left(&self) -> impl Iterator<Item = impl Iterator<Item = f32>> {
        let rows = self.frame.rows_at(Offset { north: 0, east: 0 });
        rows.map(|row| self.cells[row].iter().map(|cell| self.left_of(cell)))
    }

    /// The same of some cells together, by their indices within the frame.
    pub(crate) fn left_in(&self, cells: impl Iterator<Item = usize>) -> f64 {
        cells.map(|cell| f64::from(self.left_of(&self.cells[cell]))).sum()
    }

    fn left_of(&self, cell: &CellGain) -> f32 {
        if cell.precision >= SATURATION {
            return 0.0;
        }
        // The table rises with the precision but for what interpolation leaves.
        (self.table.utility(cell.row, SATURATION) - cell.utility).max(0.0)
    }

    pub(crate) const fn table(&self) -> &'t UtilityTable {
        self.table
    }

    pub(crate) const fn frame(&self) -> Frame {
        self.frame
    }

    pub(crate) fn cells(&self) -> &[CellGain] {
        &self.cells
    }

    /// The table, and the cells to count precision in.
    pub(crate) fn table_and_cells(&mut self) -> (&'t UtilityTable, &mut [CellGain]) {
        (self.table, &mut self.cells)
    }

    /// Utility of one observation from each cell, beyond what teammates plan to observe, shape `[cells]` (paper, Eq. 2
    /// with the tables of [`crate::utility`]); `-inf` for cells that are not candidates.
    ///
    /// All cells at one distance are observed with one precision, so a cell's gain is looked up once per ring; the rest
    /// is addition, row by row.
    #[must_use]
    pub fn observation_gains(&self, situation: &Situation<'_>, routes: &ShortestPathTree) -> Vec<f64> {
        let sums = self.sum_of_rings(situation);
        let mut gains = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for &cell in routes.candidates() {
            gains[cell.index()] = f64::from(sums[cell.index()]);
        }
        gains
    }

    fn sum_of_rings(&self, situation: &Situation<'_>) -> Vec<f32> {
        let table = self.table;
        self.frame.sum_over_footprints(situation, &self.cells, |cell, precision| {
            if cell.precision < SATURATION {
                table.utility(cell.row, cell.precision + saturated(precision)) - cell.utility
            } else {
                0.0
            }
        })
    }
}

/// A precision as far as it can matter, so that the sum of two fits 32 bits.
#[expect(clippy::cast_possible_truncation, reason = "at most SATURATION")]
pub(crate) fn saturated(precision: i64) -> i32 {
    precision.min(i64::from(SATURATION)) as i32
}
