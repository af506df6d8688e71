//! A lower bound on the cost to the goal, over the grid.
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
//! On plain ground, free and of one cost, a shortest path that enters a cell by one step leaves it by the same or by
//! one of the two adjacent ones: any other pair of steps is longer than the direct path, by steps between them. So only
//! three of the 32 are followed there, for any of several best paths.
//!
//! If the cost of a path is known, only cells over which a cheaper one could lead are visited: those whose distance to
//! the goal and whose distance over free ground from the start add up to less. States elsewhere need not be visited
//! either.

use dragnet_search::cell::Position;

use super::bits::Bits;
use super::buckets::{Ring, Waiting};
use super::costmap::{CostMap, LETHAL};
use super::guidance::{Guidance, OUT_OF_REACH};
use super::layers::Layers;
use super::metric::{Metric, STEP_REACH, steps};
use super::motions::Motions;
use super::stopped::Stopped;

/// Cells visited between two calls of `go_on`.
const CELLS_PER_QUESTION: u64 = 1 << 14;

/// A goal is entered by no step.
const ANY: u8 = u8::MAX;

/// The cost of a known path: only cheaper ones count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limit {
    pub(super) start: Position,
    pub(super) cost: u32,
}

/// `distance[cell]`: lower bound on the cost to the goal, in units, in a frame of blocked cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Heuristic {
    stride: usize,
    /// 0 in blocked cells during the computation, so that they are never improved.
    distance: Vec<u32>,
    /// Cells whose distance is final.
    done: Bits,
    /// All nearer cells are done.
    reached: u32,
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
        motions: &Motions,
        goals: &[Position],
        limit: Option<Limit>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<(), Stopped> {
        let metric = motions.metric();
        self.reached = 0;
        let sees_blocked = motions.reach_beyond_core();
        self.open(layers);
        let longest = metric.weights.iter().max().map_or(1, |&weight| weight * u32::from(LETHAL));
        self.ring.reset(metric.weights[0], longest);
        for goal in goals {
            let index = self.index(goal.row as usize, goal.column as usize);
            self.distance[index] = 0;
            self.push(0, index, ANY);
        }
        let stride = self.stride.cast_signed();
        let steps: Vec<(isize, u32)> = steps()
            .iter()
            .map(|step| (step.north as isize * stride + step.east as isize, metric.weights[step.kind]))
            .collect();
        let mut looked_at = 0_u64;
        while let Some(Waiting { cell, entered }) = self.ring.pop() {
            looked_at += 1;
            if looked_at.is_multiple_of(CELLS_PER_QUESTION) && !go_on() {
                return Err(Stopped);
            }
            let index = cell as usize;
            let here = self.distance[index];
            // A cell is queued once for each decrease of its distance; the lowest comes first.
            if self.done.replace(index) {
                continue;
            }
            self.reached = self.ring.least();
            let at = self.position(index);
            if limit.is_some_and(|limit| limit.excludes(at, here, metric)) {
                continue;
            }
            if sees_blocked && entered != ANY && layers.is_plain(at) {
                self.cross(map, index, at, usize::from(entered), &steps);
            } else {
                self.relax(map, index, at, &steps);
            }
        }
        Ok(())
    }

    /// The guaranteed lower bound of a cell's distance when computing was stopped.
    pub(super) fn at_least(&self, at: Position) -> u32 {
        self.at(at).min(self.reached)
    }

    /// Follows the steps that continue on plain ground.
    #[inline]
    fn cross(&mut self, map: &CostMap, index: usize, at: Position, entered: usize, steps: &[(isize, u32)]) {
        let own =
            1 + u32::from(map.costs()[at.row as usize * map.grid().columns() as usize + at.column as usize]);
        let here = self.distance[index];
        for kind in [entered + steps.len() - 1, entered, entered + 1] {
            let kind = kind % steps.len();
            let (by, weight) = steps[kind];
            self.lower(index.wrapping_add_signed(by), here.saturating_add(weight * own), kind);
        }
    }

    #[inline]
    fn relax(&mut self, map: &CostMap, index: usize, at: Position, steps: &[(isize, u32)]) {
        let columns = map.grid().columns() as usize;
        let cost = |row: usize, column: usize| u32::from(map.costs()[row * columns + column]);
        let here = self.distance[index];
        let own = 1 + cost(at.row as usize, at.column as usize);
        for (kind, &(by, weight)) in steps.iter().enumerate() {
            let next = index.wrapping_add_signed(by);
            // The other cell's cost is read only where it could matter.
            if here.saturating_add(weight * own) >= self.distance[next] {
                continue;
            }
            let to = self.position(next);
            let cost = own.max(1 + cost(to.row as usize, to.column as usize));
            self.lower(next, here.saturating_add(weight * cost), kind);
        }
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "there are 32 steps")]
    fn lower(&mut self, index: usize, distance: u32, kind: usize) {
        if distance < self.distance[index] {
            self.distance[index] = distance;
            self.push(distance, index, kind as u8);
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a map has at most 2^24 cells, and a narrow frame")]
    fn push(&mut self, distance: u32, index: usize, entered: u8) {
        self.ring.push(distance, Waiting { cell: index as u32, entered });
    }

    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "a map has at most 2^24 cells, and a narrow frame")]
    const fn position(&self, index: usize) -> Position {
        let (index, stride) = (index as u32, self.stride as u32);
        Position { row: index / stride - STEP_REACH as u32, column: index % stride - STEP_REACH as u32 }
    }

    fn open(&mut self, layers: &Layers) {
        self.done = Bits::new(1, (layers.columns() + 2 * STEP_REACH) * (layers.rows() + 2 * STEP_REACH));
        self.stride = layers.columns() + 2 * STEP_REACH;
        self.distance.clear();
        self.distance.resize(self.stride * (layers.rows() + 2 * STEP_REACH), 0);
        for row in 0..layers.rows() {
            let first = self.index(row, 0);
            let distances = &mut self.distance[first..first + layers.columns()];
            distances.fill(OUT_OF_REACH);
            layers.for_blocked(row, |column| distances[column] = 0);
        }
    }

    pub(super) fn bytes(&self) -> usize {
        self.distance.capacity() * 4 + self.done.bytes()
    }
}

impl Limit {
    #[inline]
    fn excludes(self, at: Position, distance: u32, metric: Metric) -> bool {
        let path = metric.cost(
            at.column.cast_signed() - self.start.column.cast_signed(),
            at.row.cast_signed() - self.start.row.cast_signed(),
        );
        path + u64::from(distance) >= u64::from(self.cost)
    }
}

#[cfg(test)]
mod tests {
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    use dragnet_search::cell::Grid;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::footprint::Footprint;
    use crate::maneuvers::{Headings, Maneuvers};

    const SIDE: u32 = 90;

    /// Some boxes of cost or of lethal ground.
    fn boxes(draw: &mut ChaCha8Rng) -> CostMap {
        let mut costs = vec![draw.random_range(0..3_u8); (SIDE * SIDE) as usize];
        for _ in 0..draw.random_range(0..6) {
            let (south, west) = (draw.random_range(0..SIDE), draw.random_range(0..SIDE));
            let (height, width) = (draw.random_range(1..40), draw.random_range(1..40));
            let cost = if draw.random_bool(0.5) { LETHAL } else { draw.random_range(0..9) };
            for row in south..(south + height).min(SIDE) {
                for column in west..(west + width).min(SIDE) {
                    costs[(row * SIDE + column) as usize] = cost;
                }
            }
        }
        CostMap::new(Grid::new(SIDE, SIDE).unwrap(), 0.5, (0.0, 0.0), costs).unwrap()
    }

    /// Dijkstra that follows every step.
    fn by_every_step(map: &CostMap, layers: &Layers, metric: Metric, goal: Position) -> Vec<u32> {
        let index = |at: Position| (at.row * SIDE + at.column) as usize;
        let mut distance = vec![OUT_OF_REACH; (SIDE * SIDE) as usize];
        distance[index(goal)] = 0;
        let mut queue = BinaryHeap::from([Reverse((0_u32, goal))]);
        while let Some(Reverse((here, at))) = queue.pop() {
            for step in steps() {
                let to = Position {
                    row: at.row.wrapping_add_signed(step.north),
                    column: at.column.wrapping_add_signed(step.east),
                };
                if to.row >= SIDE
                    || to.column >= SIDE
                    || layers.is_blocked(to.row as usize, to.column as usize)
                {
                    continue;
                }
                let cost = map.costs()[index(at)].max(map.costs()[index(to)]);
                let length = here + metric.weights[step.kind] * (1 + u32::from(cost));
                if length < distance[index(to)] {
                    distance[index(to)] = length;
                    queue.push(Reverse((length, to)));
                }
            }
        }
        distance
    }

    #[test]
    fn three_steps_on_plain_ground_and_a_limit_lose_nothing() {
        let maneuvers = Maneuvers {
            resolution_meters: 0.5,
            headings: Headings::Sixteen,
            turning_radius_meters: 1.0,
            reverse: None,
            turn_in_place: None,
        };
        let motions = Motions::new(&maneuvers.primitives().unwrap(), &Footprint::rectangle(2.0, 1.2));
        assert!(motions.reach_beyond_core());
        let (mut plain, mut excluded) = (0, 0);
        for seed in 0..60 {
            let mut draw = ChaCha8Rng::seed_from_u64(seed);
            let map = boxes(&mut draw);
            let layers = Layers::new(&map, &motions);
            let open: Vec<Position> = map
                .grid()
                .cells()
                .map(|cell| map.grid().position(cell))
                .filter(|at| !layers.is_blocked(at.row as usize, at.column as usize))
                .collect();
            let goal = open[draw.random_range(0..open.len())];
            let start = open[draw.random_range(0..open.len())];
            let expected = by_every_step(&map, &layers, motions.metric(), goal);
            let of = |at: &Position| expected[(at.row * SIDE + at.column) as usize];
            let mut heuristic = Heuristic::default();
            heuristic.compute(&map, &layers, &motions, &[goal], None, &mut || true).unwrap();
            assert!(open.iter().all(|at| heuristic.at(*at) == of(at)), "seed {seed}");
            plain += open.iter().filter(|at| layers.is_plain(**at)).count();
            let limit = Limit { start, cost: of(&start).saturating_add(3_000) };
            heuristic.compute(&map, &layers, &motions, &[goal], Some(limit), &mut || true).unwrap();
            for at in &open {
                // Excluded cells are too far away to matter.
                let is_out = limit.excludes(*at, of(at), motions.metric());
                assert!(heuristic.at(*at) == of(at) || is_out && heuristic.at(*at) > of(at), "seed {seed}");
                excluded += usize::from(is_out);
            }
        }
        assert!(plain > 10_000 && excluded > 10_000, "{plain} {excluded}");
    }
}
