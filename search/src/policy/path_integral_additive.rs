//! The sum over the observations along a path, each scored with the belief before the first of them.
//!
//! Paper, Eq. 3 as printed, weighted by Eq. 4. A cell that two observations of the path cover counts twice. On the tree
//! of shortest paths the sum is that of the parent cell plus one observation, so all candidates cost little more than
//! greedy. Departure: the observation from the robot's own cell is not part of the path, since it has already been
//! made.

use super::worth::path_information;
use super::{Decision, Policy, path_length_weight};
use crate::seed::Stream;
use crate::situation::Situation;

pub(super) struct PathIntegralAdditive {
    path_length_weight: f64,
}

impl PathIntegralAdditive {
    pub(super) const fn new(path_length_weight: f64) -> Self {
        Self { path_length_weight }
    }
}

impl Policy for PathIntegralAdditive {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = situation.routes();
        let mut utility = path_information(situation, &routes);
        for &cell in routes.candidates() {
            utility[cell.index()] *= path_length_weight(self.path_length_weight, routes.length(cell));
        }
        Decision::most_informative(&routes, utility)
    }
}
