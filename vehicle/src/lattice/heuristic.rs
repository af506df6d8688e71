//! How far it is at least to the goal, by way of the ground.
//!
//! Cells whose core is free ([`super::motions::Motions::core`]) are joined by the 32 steps of [`super::metric`]; a step
//! costs its weight times one more than the larger cost of the two cells. Dijkstra from the goal gives `h`.
//!
//! It is consistent, hence admissible. Let a motion lead from state `s` to `t`. Its weights were chosen
//! ([`super::motions::Motions::metric`]) so that a chain of steps over cells that its reference point crosses costs at
//! most as much over free ground. If the motion is free, the core is free around each of those cells, so the chain is
//! in this graph; and the motion's cost counts the largest cost of all of them, each step's only that of two of them.
//! So `h(s) <= chain + h(t) <= cost(s, t) + h(t)`. At a goal `h` is 0.
//!
//! If a way of known cost is at hand, only cells over which a cheaper one could lead are looked at: those whose
//! distance to the goal and whose distance over free ground from the start are together less. A state elsewhere need
//! not be looked at either.

use dragnet_search::cell::Position;

use super::bits::Bits;
use super::buckets::Ring;
use super::costmap::{CostMap, LETHAL};
use super::guidance::{Guidance, OUT_OF_REACH};
use super::layers::Layers;
use super::metric::{Metric, STEP_REACH, steps};
use super::run::Stopped;

/// Cells looked at between two questions whether to go on.
const CELLS_PER_QUESTION: u64 = 1 << 14;

/// A way that is known: only what could be cheaper counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    pub(super) start: Position,
    pub(super) cost: u32,
}

/// `distance[cell]`: cost to the goal at least, in units, in a frame of blocked cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Heuristic {
    stride: usize,
    /// 0 in blocked cells while it is computed: nothing is nearer.
    distance: Vec<u32>,
    /// Cells whose distance is final.
    done: Bits,
    ring: Ring,
}

impl Guidance for Heuristic {
    const IS_LOWER_BOUND: bool = true;

    #[inline]
    fn at(&self, at: Position) -> u32 {
        self.distance[self.index(at.row as usize, at.column as usize)]
    }
}

impl Heuristic {
    #[inline]
    const fn index(&self, row: usize, column: usize) -> usize {
        (row + STEP_REACH) * self.stride + column + STEP_REACH
    }

    /// Computes it anew for these goals, none of them blocked.
    pub(super) fn compute(
        &mut self,
        map: &CostMap,
        layers: &Layers,
        metric: Metric,
        goals: &[Position],
        limit: Option<Limit>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<(), Stopped> {
        self.open(layers);
        let longest = metric.weights.iter().max().map_or(1, |&weight| weight * u32::from(LETHAL));
        self.ring.reset(metric.weights[0], longest);
        for goal in goals {
            let index = self.index(goal.row as usize, goal.column as usize);
            self.distance[index] = 0;
            self.push(0, index);
        }
        let stride = self.stride.cast_signed();
        let steps: Vec<(isize, u32)> = steps()
            .iter()
            .map(|step| (step.north as isize * stride + step.east as isize, metric.weights[step.kind]))
            .collect();
        let mut looked_at = 0_u64;
        while let Some(cell) = self.ring.pop() {
            looked_at += 1;
            if looked_at.is_multiple_of(CELLS_PER_QUESTION) && !go_on() {
                return Err(Stopped);
            }
            let index = cell as usize;
            let here = self.distance[index];
            // A cell waits once for each time that its distance fell.
            if self.done.replace(index) {
                continue;
            }
            let at = self.position(index);
            if limit.is_some_and(|limit| limit.excludes(at, here, metric)) {
                continue;
            }
            self.relax(map, index, at, &steps);
        }
        Ok(())
    }

    #[inline]
    fn relax(&mut self, map: &CostMap, index: usize, at: Position, steps: &[(isize, u32)]) {
        let columns = map.grid().columns() as usize;
        let cost = |row: usize, column: usize| u32::from(map.costs()[row * columns + column]);
        let here = self.distance[index];
        let own = 1 + cost(at.row as usize, at.column as usize);
        for &(by, weight) in steps {
            let next = index.wrapping_add_signed(by);
            let known = self.distance[next];
            // What the other cell costs is looked up only where it could matter.
            if here.saturating_add(weight * own) >= known {
                continue;
            }
            let to = self.position(next);
            let length = here.saturating_add(weight * own.max(1 + cost(to.row as usize, to.column as usize)));
            if length < known {
                self.distance[next] = length;
                self.push(length, next);
            }
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a map has at most 2^24 cells, and a narrow frame")]
    fn push(&mut self, distance: u32, index: usize) {
        self.ring.push(distance, index as u32);
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "rows and columns fit 32 bits")]
    const fn position(&self, index: usize) -> Position {
        let (row, column) = (index / self.stride, index % self.stride);
        Position { row: (row - STEP_REACH) as u32, column: (column - STEP_REACH) as u32 }
    }

    fn open(&mut self, layers: &Layers) {
        self.done = Bits::new(1, (layers.columns() + 2 * STEP_REACH) * (layers.rows() + 2 * STEP_REACH));
        self.stride = layers.columns() + 2 * STEP_REACH;
        self.distance.clear();
        self.distance.resize(self.stride * (layers.rows() + 2 * STEP_REACH), 0);
        for row in 0..layers.rows() {
            let first = self.index(row, 0);
            for (column, distance) in self.distance[first..first + layers.columns()].iter_mut().enumerate() {
                *distance = if layers.is_blocked(row, column) { 0 } else { OUT_OF_REACH };
            }
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.distance.capacity() * 4 + self.done.bytes()
    }
}

impl Limit {
    #[inline]
    fn excludes(self, at: Position, distance: u32, metric: Metric) -> bool {
        let way = metric.cost(
            at.column.cast_signed() - self.start.column.cast_signed(),
            at.row.cast_signed() - self.start.row.cast_signed(),
        );
        way + u64::from(distance) >= u64::from(self.cost)
    }
}
