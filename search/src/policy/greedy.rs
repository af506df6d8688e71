//! One-step lookahead: the waypoint from which one observation is expected to remove the most entropy.
//!
//! Paper, Eq. 1 and 2. Only the observation at the waypoint counts, beyond what teammates plan to observe. The robot's
//! own cell is not a candidate.

use super::{Decision, Policy};
use crate::information_gain::InformationGain;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::Situation;

pub(super) struct Greedy;

impl Policy for Greedy {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let scores = InformationGain::new(situation).observation_gains(situation, &routes);
        Decision::most_informative(&routes, scores)
    }
}
