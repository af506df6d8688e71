//! A waypoint uniform at random over the cells in reach.

use rand::RngExt;

use super::worth::without_plans;
use super::{Decision, Policy};
use crate::intent::PlannedPrecision;
use crate::seed::Stream;
use crate::situation::Situation;

pub(super) struct Random;

impl Policy for Random {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let routes = situation.routes();
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        let candidates = routes.candidates();
        if candidates.is_empty() {
            return Decision::best(&routes, scores);
        }
        for candidate in candidates {
            scores[candidate.index()] = 0.0;
        }
        let chosen = candidates[random.random_range(0..candidates.len())];
        scores[chosen.index()] = 1.0;
        let nothing = PlannedPrecision::nothing(situation.terrain);
        Decision::best(&routes, scores).unless_all_is_known(&without_plans(situation, &nothing), &routes)
    }
}
