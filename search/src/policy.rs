//! Policies: functions from a situation to a decision.
//!
//! A robot moves to the candidate with the highest score; ties are resolved in favor of the nearest cell. It rests if
//! no path is informative (`worth`): policies that score information rest if no score is above [`LEAST_NATS`]. NATS,
//! GUTS and the learned policies skip cells whose path yields no information, and rest if there is no other; `random`
//! and `coverage` keep their order, and rest when no path yields any. Cells that teammates plan to observe count as
//! observed for the policies that use plans: the information policies, and the learned ones that imitate them.
//!
//! To add a policy, write its file and add it to [`PolicyName`] and [`build`]; `lib.rs` lists all steps.

mod coverage;
mod forecast;
mod greedy;
mod path_integral;
mod path_integral_additive;
mod path_integral_reference;
mod random;
mod thompson;
mod tour;
mod worth;

use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

use crate::cell::Cell;
use crate::seed::Stream;
use crate::situation::Situation;
use crate::utility::Utility;

pub use coverage::{AfterPattern, Pattern};
pub use path_integral_reference::PathIntegralReference;
pub use tour::{CostToGo, Hidden, HiddenMass, SCORED_WITHIN_CELLS, TourCost, TourScores};
pub use worth::LEAST_NATS;

/// Chooses the next path.
///
/// A policy is a function of its arguments; it keeps scratch space only, `coverage` its position in its fixed order,
/// `tour` the rest of its tour, and `gnn-tour` where it decided last.
pub trait Policy {
    /// Decides in this situation. `random` is the robot's random stream for decisions.
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision;

    /// Decides like [`Policy::decide`], for callers that do not use the scores: scores of candidates that cannot be
    /// chosen may be missing. If all scores are `-inf`, no cell was reachable.
    fn choose(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        self.decide(situation, random)
    }
}

/// A policy's decision and the scores behind it. Decisions are logged, tested, drawn and imitated.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The waypoint; the robot's own cell if it is to rest.
    pub chosen: Cell,
    /// Cells entered on the path, the waypoint last; empty if the robot is to rest, since there is no candidate or no
    /// path is informative.
    pub path: Vec<Cell>,
    /// The score of each cell, which the policy maximizes, shape `[cells]`, in the policy's own units; `-inf` for cells
    /// that are not candidates.
    pub scores: Vec<f64>,
}

/// Names of the policies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PolicyName {
    /// Uniform over the cells in reach.
    Random,
    /// A search pattern over all cells in reach, by default parallel tracks.
    Coverage,
    /// The most informative single observation (paper, Eq. 1 and 2).
    Greedy,
    /// The sum over the observations along the path, each scored independently (Eq. 3 as printed).
    PathAdditive,
    /// The joint information of all observations along the path (Eq. 3 as explained in its text).
    Path,
    /// A tour over the whole rest of the search, kept and improved from decision to decision.
    Tour,
    /// Thompson sampling of NATS.
    Nats,
    /// Thompson sampling of GUTS.
    Guts,
}

impl PolicyName {
    /// All policies.
    pub const ALL: [Self; 8] = [
        Self::Random,
        Self::Coverage,
        Self::Greedy,
        Self::PathAdditive,
        Self::Path,
        Self::Tour,
        Self::Nats,
        Self::Guts,
    ];

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Coverage => "coverage",
            Self::Greedy => "greedy",
            Self::PathAdditive => "path-additive",
            Self::Path => "path",
            Self::Tour => "tour",
            Self::Nats => "nats",
            Self::Guts => "guts",
        }
    }

    /// Number of cells after which a robot decides again by default; `None`: at the waypoint.
    #[must_use]
    pub const fn replan_after_cells(self) -> Option<NonZeroU32> {
        match self {
            Self::Tour => Some(tour::REPLAN_AFTER_CELLS),
            _ => None,
        }
    }
}

impl fmt::Display for PolicyName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

/// The text is not the name of a policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown policy {0:?}; allowed are {allowed}", allowed = PolicyName::ALL.map(PolicyName::as_str).join(", "))]
pub struct UnknownPolicy(pub String);

impl FromStr for PolicyName {
    type Err = UnknownPolicy;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|policy| policy.as_str() == name)
            .ok_or_else(|| UnknownPolicy(name.to_owned()))
    }
}

/// Parameters that a scenario may set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// `w_l` of the path-length weight `1 / (1 + w_l L)` (Eq. 4), at least 0. Of `path` and `path-additive`.
    pub path_length_weight: f64,
    /// What observations are worth. Of `greedy` and `path`.
    pub utility: Utility,
    /// Order of the cells. Of `coverage`.
    pub pattern: Pattern,
    /// What follows once the pattern is done. Of `coverage`.
    pub after_pattern: AfterPattern,
    /// Distance between the tracks of `coverage`, cells, at least 1; `None`: the greatest at which one pass over all of
    /// them finds an object anywhere between them with probability 0.9.
    pub lane_spacing_cells: Option<u32>,
    /// Tours that `tour` evaluates in a decision; ten times as many in its first.
    pub evaluations: u32,
}

impl Parameters {
    /// The values for a scenario that sets none.
    pub const DEFAULT: Self = Self {
        path_length_weight: 0.2,
        utility: Utility::Information,
        pattern: Pattern::ParallelTrack,
        after_pattern: AfterPattern::Repeat,
        lane_spacing_cells: None,
        evaluations: 1000,
    };
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Builds the policy with this name.
#[must_use]
pub fn build(name: PolicyName, parameters: Parameters) -> Box<dyn Policy + Send> {
    match name {
        PolicyName::Random => Box::new(random::Random),
        PolicyName::Coverage => Box::new(coverage::Coverage::new(parameters)),
        PolicyName::Greedy => Box::new(greedy::Greedy::new(parameters.utility)),
        PolicyName::PathAdditive => {
            Box::new(path_integral_additive::PathIntegralAdditive::new(parameters.path_length_weight))
        }
        PolicyName::Path => {
            Box::new(path_integral::Path::new(parameters.path_length_weight, parameters.utility))
        }
        PolicyName::Tour => Box::new(tour::Tour::new(parameters.evaluations, parameters.path_length_weight)),
        PolicyName::Nats => Box::new(thompson::Thompson::NATS),
        PolicyName::Guts => Box::new(thompson::Thompson::GUTS),
    }
}

/// `w(L) = 1 / (1 + w_l L)` (paper, Eq. 4), with `L` the length of the path in cells moved.
fn path_length_weight(path_length_weight: f64, length_cells: f32) -> f64 {
    1.0 / (1.0 + path_length_weight * f64::from(length_cells))
}
