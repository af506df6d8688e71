//! What the rest of a search costs if `tour` drives on: a critic for policies that learn from their own searches.

use super::anneal::anneal;
use super::ground::Ground;
use super::hidden::HiddenTable;
use super::planner::{Planner, unfinished};
use super::{FIRST_FACTOR, HOT, Plan, WARM, affordable, best_lanes};
use crate::seed::Stream;
use crate::situation::Situation;

/// Tours that an estimate evaluates; ten times as many in the first. With a tenth of the expert's evaluations a tour is
/// a few percent longer, at every decision alike.
const EVALUATIONS: u32 = 100;

/// What is to come of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostToGo {
    /// Expected length of the rest of it along the tour, cells: the sum of the lengths of its steps, each times the
    /// probability that an object is left after it.
    pub expected_cells: f64,
    /// Probability that an object is left.
    pub unfinished: f64,
}

/// Estimates for the decisions of one search, in their order: the tour of the last one is kept and improved.
#[derive(Default)]
pub struct TourCost {
    table: Option<HiddenTable>,
    ground: Option<Ground>,
    plan: Plan,
}

impl TourCost {
    /// What is to come; nothing for a robot that cannot search.
    pub fn to_go(&mut self, situation: &Situation<'_>, random: &mut Stream) -> CostToGo {
        let table = HiddenTable::kept_for(&mut self.table, situation.detection_threshold);
        let (ground, is_new) = Ground::kept_for(&mut self.ground, situation);
        let Some(robot) = ground.number(situation.robot) else {
            return CostToGo { expected_cells: 0.0, unfinished: 0.0 };
        };
        let planner = Planner::new(ground, table, situation, robot);
        let evaluations = affordable(EVALUATIONS, situation.sensor);
        let (tour, _) = if is_new {
            let evaluations = evaluations.saturating_mul(FIRST_FACTOR);
            anneal(&planner, best_lanes(&planner), evaluations, HOT, random)
        } else {
            // A robot that left the tour may stand where it only comes to in the end.
            let (ahead, whole) = (self.plan.rest(&planner), self.plan.whole(&planner));
            let start = if planner.cost(&ahead) <= planner.cost(&whole) { ahead } else { whole };
            anneal(&planner, start, evaluations, WARM, random)
        };
        self.plan = Plan::new(&planner, &tour);
        CostToGo { expected_cells: planner.expected_length(&tour), unfinished: unfinished(planner.root.left) }
    }
}
