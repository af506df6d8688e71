//! One-step lookahead: the waypoint from which one look is expected to remove the most entropy.
//!
//! Paper, Eq. 1 and 2. The look at the waypoint is all that counts, and it counts beyond what teammates have promised
//! to see. The robot's own cell is no waypoint.

use super::{Decision, Policy};
use crate::outlook::Outlook;
use crate::route::Routes;
use crate::seed::Stream;
use crate::situation::Situation;

pub(super) struct Greedy;

impl Policy for Greedy {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = Routes::from(situation.terrain, situation.connectivity, situation.robot);
        let scores = Outlook::new(situation).look_gains(situation, &routes);
        Decision::most_informative(&routes, scores)
    }
}
