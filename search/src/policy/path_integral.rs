//! The joint information of all observations along a path.
//!
//! Paper, Eq. 3 read with its text ("after assimilating all en-route observations"), weighted by Eq. 4. Readings of one
//! cell are independent given its state, so the joint information of a path is exactly `U(x) = sum_c I(L_c, k_c(path))`
//! with `k_c` the summed precision. One depth-first traversal of the tree of shortest paths adds precision on descent
//! and restores it on return: every candidate is scored exactly, and no path is traversed twice. Departure: the
//! observation from the robot's own cell is not part of the path, since it has already been made.

use super::{Decision, LEAST_NATS, Policy, path_length_weight};
use crate::cell::Cell;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::Situation;
use crate::utility::{SATURATION, Tables, Utility, UtilityTable};
use crate::utility_gain::{CellGain, Frame, UtilityGain, saturated};

pub(super) struct Path {
    path_length_weight: f64,
    tables: Tables,
}

impl Path {
    pub(super) const fn new(path_length_weight: f64, utility: Utility) -> Self {
        Self { path_length_weight, tables: Tables::new(utility) }
    }
}

impl Policy for Path {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let gain = UtilityGain::new(self.tables.of(situation), situation);
        best_within(situation, self.path_length_weight, &gain, &routes)
    }

    /// Exact, by a bound: the information gain of a path is at most that of all cells together, and its weight falls with its
    /// length. Candidates are scored up to some path length, which is doubled until no longer path can score more.
    fn choose(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let gain = UtilityGain::new(self.tables.of(situation), situation);
        let most = gain.most() * ROUNDING + LEAST_NATS;
        let mut longest = FIRST_RADII * situation.sensor.radius().max(1) as f32;
        loop {
            let routes =
                ShortestPathTree::within(situation.terrain, situation.connectivity, situation.robot, longest);
            let decision = best_within(situation, self.path_length_weight, &gain, &routes);
            let best = decision.scores[decision.chosen.index()].max(LEAST_NATS / ROUNDING);
            let farther = path_length_weight(self.path_length_weight, longest) * most;
            if !routes.is_cut() || farther < best {
                return decision;
            }
            longest *= 2.0;
        }
    }
}

/// The first path length up to which candidates are scored, sensor radii.
const FIRST_RADII: f32 = 4.0;
/// Factor on the bound: scores are sums of 32-bit numbers, and the table of gains is interpolated.
const ROUNDING: f64 = 1.01;

/// The best of the paths of a tree.
fn best_within(
    situation: &Situation<'_>,
    weight_per_cell: f64,
    gain: &UtilityGain<'_>,
    routes: &ShortestPathTree,
) -> Decision {
    let cell_count = situation.terrain.grid().cell_count();
    let mut scores = vec![f64::NEG_INFINITY; cell_count];
    let mut walk = Walk::new(situation, gain);
    for visit in depth_first(routes, cell_count) {
        let utility = walk.enter(visit);
        let weight = path_length_weight(weight_per_cell, routes.length(visit.cell));
        scores[visit.cell.index()] = weight * f64::from(utility);
    }
    Decision::most_informative(routes, scores)
}

/// A cell of the tree in the order of a depth-first walk.
#[derive(Clone, Copy)]
struct Visit {
    cell: Cell,
    /// Moves from the root, from 1.
    depth: usize,
}

/// All candidates, each followed by its whole subtree.
fn depth_first(routes: &ShortestPathTree, cell_count: usize) -> Vec<Visit> {
    let mut size = vec![1_usize; cell_count];
    for &cell in routes.candidates().iter().rev() {
        size[routes.parent(cell).index()] += size[cell.index()];
    }
    // The position of a cell's next child: after the subtrees of its earlier children.
    let mut next = vec![0_usize; cell_count];
    let mut depth = vec![0_usize; cell_count];
    let mut visits = vec![Visit { cell: routes.root(), depth: 0 }; routes.candidates().len()];
    for &cell in routes.candidates() {
        let parent = routes.parent(cell);
        let place = next[parent.index()];
        next[parent.index()] += size[cell.index()];
        next[cell.index()] = place + 1;
        depth[cell.index()] = depth[parent.index()] + 1;
        visits[place] = Visit { cell, depth: depth[cell.index()] };
    }
    visits
}

/// The state of the traversal: precision of every cell, and what to restore on return.
struct Walk<'t> {
    table: &'t UtilityTable,
    gains: Vec<CellGain>,
    frame: Frame,
    observations: Vec<(isize, i32)>,
    changed: Vec<(u32, CellGain)>,
    /// Of each cell on the path: changes made before it, and utility of the path up to it.
    path: Vec<(usize, f32)>,
}

impl<'t> Walk<'t> {
    fn new(situation: &Situation<'_>, gain: &UtilityGain<'t>) -> Self {
        let frame = gain.frame();
        let observations = situation
            .sensor
            .footprint()
            .iter()
            .map(|observation| (frame.stride_of(observation.offset), saturated(observation.precision)))
            .collect();
        Self {
            table: gain.table(),
            gains: gain.cells().to_vec(),
            frame,
            observations,
            changed: Vec::new(),
            path: vec![],
        }
    }

    /// Utility of the path to the next cell of a depth-first walk.
    fn enter(&mut self, visit: Visit) -> f32 {
        while self.path.len() >= visit.depth {
            self.leave();
        }
        let before = self.path.last().map_or(0.0, |&(_, utility)| utility);
        self.path.push((self.changed.len(), 0.0));
        let utility = before + self.observation(self.frame.index(visit.cell));
        if let Some(last) = self.path.last_mut() {
            last.1 = utility;
        }
        utility
    }

    fn observation(&mut self, from: usize) -> f32 {
        let table = self.table;
        let mut gain = 0.0;
        for &(offset, precision) in &self.observations {
            let index = from.wrapping_add_signed(offset);
            let cell = &mut self.gains[index];
            if cell.precision >= SATURATION {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, reason = "a framed map has fewer than 2^32 cells")]
            self.changed.push((index as u32, *cell));
            cell.precision = (cell.precision + precision).min(SATURATION);
            let utility = table.utility(cell.row, cell.precision);
            gain += utility - cell.utility;
            cell.utility = utility;
        }
        gain
    }

    fn leave(&mut self) {
        if let Some((changes, _)) = self.path.pop() {
            while self.changed.len() > changes {
                if let Some((index, before)) = self.changed.pop() {
                    self.gains[index as usize] = before;
                }
            }
        }
    }
}
