//! Properties of a cost map for a set of motions, as bits: lethal cells, blocked cells, and plain ground.

use std::ops::Range;

use dragnet_search::cell::Position;

use super::bits::{Bits, or_shifted};
use super::costmap::{CostMap, LETHAL};
use super::motions::{Motions, Run};

/// Bits in a frame as wide as motions reach, so that cells beside the map can be read: they are lethal.
#[derive(Clone, Debug)]
pub(super) struct Layers {
    frame: usize,
    rows: usize,
    columns: usize,
    lethal: Bits,
    /// A motion from here may sweep a lethal cell.
    near_lethal: Bits,
    /// A motion from here may lead over cells of other costs than this one's.
    near_change: Bits,
    /// Another cost than to the west or to the south; a lethal cell counts as 0.
    change: Bits,
    /// No motion leads over this cell: a cell of the motions' core is lethal.
    blocked: Bits,
}

impl Layers {
    pub(super) fn new(map: &CostMap, motions: &Motions) -> Self {
        let (rows, columns) = (map.grid().rows() as usize, map.grid().columns() as usize);
        let frame = motions.reach_cells();
        let bits = || Bits::new(rows + 2 * frame, columns + 2 * frame);
        let mut layers = Self {
            frame,
            rows,
            columns,
            lethal: bits(),
            near_lethal: bits(),
            near_change: bits(),
            change: bits(),
            blocked: bits(),
        };
        for row in (0..frame).chain(frame + rows..rows + 2 * frame) {
            layers.lethal.row_mut(row).fill(u64::MAX);
        }
        layers.refresh(map, motions, 0..rows);
        layers
    }

    /// Updates rows of the map that have changed.
    pub(super) fn refresh(&mut self, map: &CostMap, motions: &Motions, changed: Range<usize>) {
        let frame = self.frame;
        // The row to the north is compared with the last of them.
        let read = changed.start..(changed.end + 1).min(self.rows);
        for row in read.clone() {
            self.read_row(map, row);
        }
        let first = read.start.saturating_sub(frame);
        let last = (read.end + frame).min(self.rows);
        let width = 2 * frame + 1;
        let from = -frame.cast_signed();
        for row in first..last {
            let framed = row + frame;
            for (source, near) in
                [(&self.lethal, &mut self.near_lethal), (&self.change, &mut self.near_change)]
            {
                let mut all = vec![0; source.row(0).len()];
                for beside in row..row + width {
                    or_shifted(&mut all, source.row(beside), 0);
                }
                near.row_mut(framed).copy_from_slice(&window(&all, from, width));
            }
            let mut blocked = vec![0; self.lethal.row(0).len()];
            for &(north, east) in motions.core() {
                let beside = self.lethal.row(framed.saturating_add_signed(north as isize));
                or_shifted(&mut blocked, beside, east as isize);
            }
            self.blocked.row_mut(framed).copy_from_slice(&blocked);
        }
    }

    fn read_row(&mut self, map: &CostMap, row: usize) {
        let framed = row + self.frame;
        self.lethal.row_mut(framed).fill(u64::MAX);
        self.change.row_mut(framed).fill(0);
        let row_of = |row: usize| &map.costs()[row * self.columns..(row + 1) * self.columns];
        let (own, south) = (row_of(row), row_of(row.saturating_sub(1)));
        let price = |cost: u8| if cost < LETHAL { cost } else { 0 };
        let mut west = price(own[0]);
        for (column, (&cost, &south)) in own.iter().zip(south).enumerate() {
            let framed_column = column + self.frame;
            if cost < LETHAL {
                self.lethal.row_mut(framed)[framed_column / 64] &= !(1 << (framed_column % 64));
            }
            if price(cost) != west || price(cost) != price(south) {
                self.change.set(framed, framed_column);
            }
            west = price(cost);
        }
    }

    pub(super) const fn rows(&self) -> usize {
        self.rows
    }

    pub(super) const fn columns(&self) -> usize {
        self.columns
    }

    #[inline]
    pub(super) fn is_near_lethal(&self, at: Position) -> bool {
        self.near_lethal.get(at.row as usize + self.frame, at.column as usize + self.frame)
    }

    #[inline]
    pub(super) fn is_near_change(&self, at: Position) -> bool {
        self.near_change.get(at.row as usize + self.frame, at.column as usize + self.frame)
    }

    /// Whether all cells within motions' reach are free and cost the same.
    #[inline]
    pub(super) fn is_plain(&self, at: Position) -> bool {
        !self.is_near_lethal(at) && !self.is_near_change(at)
    }

    #[inline]
    pub(super) fn is_blocked(&self, row: usize, column: usize) -> bool {
        self.blocked.get(row + self.frame, column + self.frame)
    }

    /// Calls `call` for each blocked column of a row.
    pub(super) fn for_blocked(&self, row: usize, mut call: impl FnMut(usize)) {
        let words = self.blocked.row(row + self.frame).iter().enumerate();
        for (index, &word) in words.filter(|(_, word)| **word != 0) {
            for bit in (0..64).filter(|bit| word >> bit & 1 == 1) {
                let column = (index * 64 + bit).wrapping_sub(self.frame);
                if column < self.columns {
                    call(column);
                }
            }
        }
    }

    /// Whether none of these cells around one is lethal. They are of a motion, so that the frame contains them.
    #[inline]
    pub(super) fn is_free(&self, at: Position, runs: &[Run]) -> bool {
        let (row, column) = (at.row as usize + self.frame, at.column as usize + self.frame);
        runs.iter().all(|run| {
            let row = row.wrapping_add_signed(run.north as isize);
            !self.lethal.any(row, column.wrapping_add_signed(run.east as isize), run.mask)
        })
    }

    pub(super) fn bytes(&self) -> usize {
        5 * self.lethal.bytes()
    }
}

/// `out[i]`: whether a bit of `row[i + from..i + from + width]` is set. By doubling, like a windowed sum.
fn window(row: &[u64], from: isize, width: usize) -> Vec<u64> {
    let mut all = row.to_vec();
    let mut covered = 1;
    while covered < width {
        let step = covered.min(width - covered);
        let before = all.clone();
        or_shifted(&mut all, &before, step.cast_signed());
        covered += step;
    }
    let mut out = vec![0; row.len()];
    or_shifted(&mut out, &all, from);
    out
}
