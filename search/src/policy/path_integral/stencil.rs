//! The gain of an observation at the end of a straight run.
//!
//! A cell that lies `a` cells ahead of the robot and `d` beside its line has been observed from all cells of the run
//! behind that see it. So the precision that it has before and after the observation depends on `(a, d)` only, and with
//! `K(a, d)` the precision of all observations from `a` on,
//!
//! `gain(x) = sum over (a, d) of I(L_c, k_c + K(a, d)) - I(L_c, k_c + K(a + 1, d))`
//!
//! where `c` is the cell at `(a, d)` from `x` and `k_c` what teammates plan. The differences are looked up once per cell of
//! the map and place `(a, d)`, whatever the direction; the rest is addition, row by row. All is looked up and added as in
//! the traversal, in the same order: the sums are the same bits.

use std::ops::Range;

use super::runs::{Kind, MOVES};
use crate::cell::{Cell, Offset};
use crate::route::ShortestPathTree;
use crate::situation::Situation;
use crate::utility::{Column, SATURATION, UtilityTable};
use crate::utility_gain::{CellGain, Frame, UtilityGain, saturated};

/// Adds the utility of the paths to all cells on straight runs; `utility` holds that of all others, shape `[cells]`.
pub(super) fn score(
    situation: &Situation<'_>,
    gain: &UtilityGain<'_>,
    routes: &ShortestPathTree,
    kinds: &[Kind],
    utility: &mut [f32],
) {
    let is_straight = |cell: &Cell| matches!(kinds[cell.index()], Kind::Straight(_));
    if !routes.candidates().iter().any(is_straight) {
        return;
    }
    put_gains(situation, gain, kinds, utility);
    for &cell in routes.candidates().iter().filter(|it| is_straight(it)) {
        utility[cell.index()] += utility[routes.parent(cell).index()];
    }
}

/// Puts the gain of the observation from each cell on a straight run in its place.
fn put_gains(situation: &Situation<'_>, gain: &UtilityGain<'_>, kinds: &[Kind], gains: &mut [f32]) {
    let mut band = Band::new(situation, gain);
    let columns = situation.terrain.grid().columns() as usize;
    let of_rows = kinds.chunks_exact(columns).zip(gains.chunks_exact_mut(columns));
    for (row, (kinds, gains)) in of_rows.enumerate() {
        for (step, &toward) in (0..).zip(MOVES) {
            let is_of = |kind: &Kind| *kind == Kind::Straight(step);
            let Some(first) = kinds.iter().position(is_of) else { continue };
            let end = kinds.iter().rposition(is_of).map_or(first, |last| last + 1);
            let sums = band.sums(row, first..end, toward);
            for ((gain, sum), kind) in gains[first..end].iter_mut().zip(sums).zip(&kinds[first..end]) {
                if is_of(kind) {
                    *gain = *sum;
                }
            }
        }
    }
}

/// The differences of some rows of the map, as many as a footprint has.
struct Band<'g> {
    table: &'g UtilityTable,
    frame: Frame,
    cells: &'g [CellGain],
    radius: usize,
    /// Offsets of the footprint, in its order.
    offsets: Vec<Offset>,
    /// Of each distance beside the line: precision after the first observation of a cell there, the second, and so on.
    stages: Vec<Vec<Stage>>,
    /// Differences of each place and column of the frame, of the row that is this one modulo their number.
    rows: Vec<Vec<f32>>,
    /// Row of the frame that is filled next.
    next: usize,
    sums: Vec<f32>,
}

impl<'g> Band<'g> {
    fn new(situation: &Situation<'_>, gain: &'g UtilityGain<'_>) -> Self {
        let sensor = situation.sensor;
        let radius = sensor.radius() as usize;
        let mut by_distance = vec![0; radius + 1];
        for observation in sensor.footprint() {
            by_distance[observation.offset.manhattan() as usize] = saturated(observation.precision);
        }
        let stages: Vec<Vec<Stage>> = (0..=radius)
            .map(|beside| {
                let ahead = radius - beside;
                let mut sum = 0_i32;
                (0..=2 * ahead)
                    .map(|stage| {
                        sum = (sum + by_distance[beside + stage.abs_diff(ahead)]).min(SATURATION);
                        Stage { precision: sum, column: UtilityTable::column(sum) }
                    })
                    .collect()
            })
            .collect();
        let frame = gain.frame();
        let places = (radius + 1).pow(2);
        Self {
            table: gain.table(),
            frame,
            cells: gain.cells(),
            radius,
            offsets: sensor.footprint().iter().map(|it| it.offset).collect(),
            stages,
            rows: vec![vec![0.0; places * frame.stride()]; 2 * radius + 1],
            next: 0,
            sums: Vec::new(),
        }
    }

    /// Gains of the last observations of straight runs to the cells of a part of a row, by a move.
    fn sums(&mut self, row: usize, columns: Range<usize>, toward: Offset) -> &[f32] {
        self.fill_to(row);
        self.sums.clear();
        self.sums.resize(columns.len(), 0.0);
        for offset in &self.offsets {
            let ahead = offset.north * toward.north + offset.east * toward.east;
            let beside = (offset.manhattan() - ahead.unsigned_abs()) as usize;
            let stage = (self.radius - beside).wrapping_add_signed(-(ahead as isize));
            // Of all places nearer to the line: an odd number each.
            let place = beside * (2 * self.radius + 2 - beside) + stage;
            let source =
                &self.rows[(row + self.radius).wrapping_add_signed(offset.north as isize) % self.rows.len()];
            let start = place * self.frame.stride()
                + self.radius.wrapping_add_signed(offset.east as isize)
                + columns.start;
            for (sum, difference) in self.sums.iter_mut().zip(&source[start..]) {
                *sum += difference;
            }
        }
        &self.sums
    }

    /// Makes the rows that footprints in a row of the map reach.
    fn fill_to(&mut self, row: usize) {
        self.next = self.next.max(row);
        while self.next <= row + 2 * self.radius {
            self.fill(self.next);
            self.next += 1;
        }
    }

    fn fill(&mut self, row: usize) {
        let stride = self.frame.stride();
        let cells = &self.cells[row * stride..][..stride];
        let slot = row % self.rows.len();
        let rows = &mut self.rows[slot];
        let mut column = 0;
        let mut values = vec![0.0; (self.radius + 1).pow(2)];
        for like in cells.chunk_by(|a, b| a.row == b.row && a.precision == b.precision) {
            differences(self.table, &self.stages, like[0], &mut values);
            for (place, &value) in values.iter().enumerate() {
                rows[place * stride + column..][..like.len()].fill(value);
            }
            column += like.len();
        }
    }
}

fn differences(table: &UtilityTable, stages: &[Vec<Stage>], cell: CellGain, values: &mut [f32]) {
    if cell.precision >= SATURATION {
        values.fill(0.0);
        return;
    }
    let mut values = values.iter_mut();
    for beside in stages {
        let mut before = cell.utility;
        for (stage, value) in beside.iter().zip(&mut values) {
            let column = match cell.precision {
                0 => stage.column,
                planned => UtilityTable::column(planned + stage.precision),
            };
            let after = table.at(cell.row, column);
            *value = after - before;
            before = after;
        }
    }
}

/// What the observations of a cell so far amount to.
struct Stage {
    precision: i32,
    column: Column,
}
