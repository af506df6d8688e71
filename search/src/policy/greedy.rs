//! One-step lookahead: the waypoint from which one observation is expected to remove the most entropy, or to find most.
//!
//! Paper, Eq. 1 and 2. Only the observation at the waypoint counts, beyond what teammates plan to observe. The robot's
//! own cell is not a candidate.

use super::{Decision, Policy};
use crate::seed::Stream;
use crate::situation::Situation;
use crate::utility::{Tables, Utility};
use crate::utility_gain::UtilityGain;

pub(super) struct Greedy {
    tables: Tables,
}

impl Greedy {
    pub(super) const fn new(utility: Utility) -> Self {
        Self { tables: Tables::new(utility) }
    }
}

impl Policy for Greedy {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = situation.routes();
        let scores =
            UtilityGain::new(self.tables.of(situation), situation).observation_gains(situation, &routes);
        Decision::most_informative(&routes, scores)
    }
}
