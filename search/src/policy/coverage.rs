//! Parallel lanes over all cells in reach, in an order fixed at the first decision.

use super::worth::without_plans;
use super::{Decision, Policy};
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::{Place, Situation};

/// A boustrophedon over lanes from west to east and back, south to north. A team shares the order: each robot takes an
/// equal, contiguous part.
pub(super) struct Coverage {
    lane_spacing_cells: u32,
    order: Option<Vec<Cell>>,
    next: usize,
}

impl Coverage {
    pub(super) const fn new(lane_spacing_cells: u32) -> Self {
        Self { lane_spacing_cells, order: None, next: 0 }
    }
}

impl Policy for Coverage {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for cell in routes.candidates() {
            scores[cell.index()] = 0.0;
        }
        let lane_spacing_cells = self.lane_spacing_cells;
        let order = self.order.get_or_insert_with(|| lanes(situation, &routes, lane_spacing_cells));
        while order.get(self.next).is_some_and(|&cell| cell == situation.robot) {
            self.next += 1;
        }
        if self.next >= order.len() {
            // All is covered: start again.
            self.next = order.iter().position(|&cell| cell != situation.robot).unwrap_or(0);
        }
        if let Some(&waypoint) = order.get(self.next)
            && waypoint != situation.robot
        {
            scores[waypoint.index()] = 1.0;
            self.next += 1;
        }
        let nothing = PlannedPrecision::nothing(situation.terrain);
        Decision::best(&routes, scores).unless_all_is_known(&without_plans(situation, &nothing), &routes)
    }
}

/// The robot's part of the lanes. The first lane lies half a lane inside the southernmost row in reach.
fn lanes(situation: &Situation<'_>, routes: &ShortestPathTree, lane_spacing_cells: u32) -> Vec<Cell> {
    let row = |cell: Cell| situation.terrain.grid().position(cell).row;
    let southernmost = routes.reached().iter().map(|&cell| row(cell)).min().unwrap_or(0);
    let first = southernmost + lane_spacing_cells / 2;
    let mut reached: Vec<Cell> = routes.reached().to_vec();
    reached.sort_unstable();
    let mut order = Vec::new();
    for lane in reached.chunk_by(|&a, &b| row(a) == row(b)) {
        let Some(from_first) = row(lane[0]).checked_sub(first) else { continue };
        if from_first % lane_spacing_cells != 0 {
            continue;
        }
        if (from_first / lane_spacing_cells).is_multiple_of(2) {
            order.extend(lane);
        } else {
            order.extend(lane.iter().rev());
        }
    }
    share(&order, situation.place).to_vec()
}

fn share(order: &[Cell], Place { member, team }: Place) -> &[Cell] {
    let bound = |member: u16| order.len() * usize::from(member) / usize::from(team.max(1));
    &order[bound(member)..bound(member + 1)]
}
