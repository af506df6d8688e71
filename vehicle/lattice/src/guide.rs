//! A coarse map of a large one, for a fast first path.
//!
//! Blocks of 4 x 4 cells are neighbors if a step leads from a free cell of one to a free cell of the other, so that
//! walls of three cells or more block, and every path leads from neighbor to neighbor. The distances are not lower
//! bounds: they guide a search, and are never part of a bound.

use std::ops::Range;

use dragnet_search::cell::Position;

use super::buckets::{Ring, Waiting};
use super::costmap::{CostMap, LETHAL};
use super::guidance::{Guidance, OUT_OF_REACH};
use super::layers::Layers;
use super::metric::UNITS_PER_CELL;

/// Edge of a block, in cells.
const EDGE: usize = 4;

/// Steps to the neighbors as (north, east): the first four and their opposites.
const NEIGHBORS: [(isize, isize); 8] = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// Blocks of a map, and their distances to one goal.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    rows: usize,
    columns: usize,
    /// A bit for each of [`NEIGHBORS`] that can be entered, shape `[blocks]`.
    links: Vec<u8>,
    /// Mean cost of the cells that are not lethal, shape `[blocks]`.
    costs: Vec<u8>,
    distance: Vec<u32>,
    ring: Ring,
}

impl Guidance for Guide {
    const IS_LOWER_BOUND: bool = false;

    #[inline]
    fn at(&self, at: Position) -> u32 {
        self.distance[at.row as usize / EDGE * self.columns + at.column as usize / EDGE]
    }
}

impl Guide {
    pub(super) fn new(map: &CostMap, layers: &Layers) -> Self {
        let (rows, columns) = (layers.rows().div_ceil(EDGE), layers.columns().div_ceil(EDGE));
        let mut guide = Self {
            rows,
            columns,
            links: vec![0; rows * columns],
            costs: vec![0; rows * columns],
            distance: Vec::new(),
            ring: Ring::default(),
        };
        for row in 0..rows {
            guide.join_row(map, layers, row);
        }
        guide
    }

    /// Updates rows of cells that have changed; the distances stay those of before.
    pub(super) fn refresh(&mut self, map: &CostMap, layers: &Layers, changed: Range<usize>) {
        // The row to the south depends on its border.
        let first = (changed.start / EDGE).saturating_sub(1);
        for row in first..changed.end.div_ceil(EDGE).min(self.rows) {
            for column in 0..self.columns {
                self.links[row * self.columns + column] &= !0b0001_1111;
                if row + 1 < self.rows {
                    self.links[(row + 1) * self.columns + column] &= !0b1110_0000;
                }
            }
            self.join_row(map, layers, row);
        }
    }

    /// Connects the blocks of a row to each other and to those of the row to the north.
    fn join_row(&mut self, map: &CostMap, layers: &Layers, row: usize) {
        let mut here = vec![[0_u8; EDGE]; self.columns];
        let mut north = vec![0_u8; self.columns];
        for column in 0..self.columns {
            for (line, free) in here[column].iter_mut().enumerate() {
                *free = free_cells(layers, row * EDGE + line, column * EDGE);
            }
            north[column] = free_cells(layers, (row + 1) * EDGE, column * EDGE);
            self.costs[row * self.columns + column] = mean_cost(map, row * EDGE, column * EDGE);
        }
        // A step may be diagonal, and then enters beside.
        let near = |bits: u8| bits | bits << 1 | bits >> 1;
        let side = |cells: [u8; EDGE], bit: usize| {
            (0..EDGE).fold(0, |all, line| all | (cells[line] >> bit & 1) << line)
        };
        for column in 0..self.columns {
            let top = here[column][EDGE - 1];
            let east = here.get(column + 1).copied().unwrap_or_default();
            let beyond =
                |column: Option<usize>| column.and_then(|column| north.get(column)).copied().unwrap_or(0);
            let linked = [
                side(here[column], EDGE - 1) & near(side(east, 0)) != 0,
                top >> (EDGE - 1) & 1 & beyond(Some(column + 1)) != 0,
                top & near(north[column]) != 0,
                top & 1 & beyond(column.checked_sub(1)) >> (EDGE - 1) != 0,
            ];
            for (direction, _) in linked.iter().enumerate().filter(|(_, linked)| **linked) {
                let block = row * self.columns + column;
                let other = self.neighbor(block, direction);
                self.links[block] |= 1 << direction;
                self.links[other] |= 1 << (direction + 4);
            }
        }
    }

    const fn neighbor(&self, block: usize, direction: usize) -> usize {
        let (north, east) = NEIGHBORS[direction];
        block.wrapping_add_signed(north * self.columns.cast_signed() + east)
    }

    /// Computes the distances of all blocks to these goals.
    #[expect(clippy::cast_possible_truncation, reason = "a map has at most 2^24 cells")]
    pub(super) fn compute(&mut self, goals: &[Position]) {
        let straight = UNITS_PER_CELL * EDGE as u32;
        let diagonal = straight * 99 / 70;
        self.ring.reset(straight, diagonal * u32::from(LETHAL));
        self.distance.clear();
        self.distance.resize(self.links.len(), OUT_OF_REACH);
        for goal in goals {
            let block = goal.row as usize / EDGE * self.columns + goal.column as usize / EDGE;
            self.distance[block] = 0;
            self.ring.push(0, Waiting { cell: block as u32, entered: 0 });
        }
        let mut done = vec![false; self.links.len()];
        while let Some(Waiting { cell, .. }) = self.ring.pop() {
            let block = cell as usize;
            if std::mem::replace(&mut done[block], true) {
                continue;
            }
            let here = self.distance[block];
            for direction in 0..NEIGHBORS.len() {
                if self.links[block] >> direction & 1 == 0 {
                    continue;
                }
                let next = self.neighbor(block, direction);
                let weight = if direction % 2 == 0 { straight } else { diagonal };
                let cost = u32::from(self.costs[block].max(self.costs[next]));
                let length = here.saturating_add(weight * (1 + cost));
                if length < self.distance[next] {
                    self.distance[next] = length;
                    self.ring.push(length, Waiting { cell: next as u32, entered: 0 });
                }
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.rows * self.columns * 6
    }
}

/// The free ones of four cells from this one to the east; the lowest bit for the first.
fn free_cells(layers: &Layers, row: usize, column: usize) -> u8 {
    let is_free = |column: &usize| {
        row < layers.rows() && *column < layers.columns() && !layers.is_blocked(row, *column)
    };
    (0..EDGE).filter(|offset| is_free(&(column + offset))).fold(0, |all, offset| all | 1 << offset)
}

/// Rounded down.
fn mean_cost(map: &CostMap, row: usize, column: usize) -> u8 {
    let (rows, columns) = (map.grid().rows() as usize, map.grid().columns() as usize);
    let (mut sum, mut count) = (0_u32, 0_u32);
    for line in row..(row + EDGE).min(rows) {
        for &cost in &map.costs()[line * columns + column..line * columns + (column + EDGE).min(columns)] {
            if cost < LETHAL {
                sum += u32::from(cost);
                count += 1;
            }
        }
    }
    u8::try_from(sum / count.max(1)).unwrap_or(LETHAL)
}
