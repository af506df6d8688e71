//! Search patterns: an order of cells that is fixed at the first decision.
//!
//! The patterns are those of the IAMSAR Manual (volume II, chapter 5). Departure: track spacing follows from the sensor
//! and the belief, and where no robot can stand the track goes around.

mod pattern;
mod spacing;

use super::path_integral::Path;
use super::worth::{is_path_informative, without_plans};
use super::{Decision, Parameters, Policy};
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::situation::{Place, Situation};
use crate::utility::Utility;

pub use pattern::Pattern;

/// What a robot does after it has completed its pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterPattern {
    /// It repeats the pattern, as long as there is anything to be seen along it.
    Repeat,
    /// It uses the policy `path`, for cells that the pattern left uncertain.
    Path,
}

impl AfterPattern {
    /// All variants.
    pub const ALL: [Self; 2] = [Self::Repeat, Self::Path];

    /// The name used in scenarios and on the command line.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Repeat => "repeat",
            Self::Path => "path",
        }
    }
}

/// A pattern, followed cell by cell. A team shares the order: each robot takes an equal, contiguous part.
///
/// A pattern covers what is in reach when it is made. Teammates that stand in the way, and areas that are opened or closed, change
/// that: if at the end of its part other ground is in reach, a robot makes a pattern anew, of all of it.
pub(super) struct Coverage {
    parameters: Parameters,
    path: Path,
    pattern: Option<Made>,
    next: usize,
}

/// A pattern as it was made.
struct Made {
    order: Vec<Cell>,
    /// The cells that were in reach, by index.
    reached: Vec<Cell>,
}

impl Coverage {
    pub(super) const fn new(parameters: Parameters) -> Self {
        Self {
            parameters,
            path: Path::new(parameters.path_length_weight, Utility::Information),
            pattern: None,
            next: 0,
        }
    }

    /// The part of the pattern of one robot.
    fn make(&self, situation: &Situation<'_>, routes: &ShortestPathTree, place: Place) -> Made {
        let Parameters { pattern, lane_spacing_cells, after_pattern, .. } = self.parameters;
        let spacing = lane_spacing_cells.unwrap_or_else(|| spacing::confirming(situation, routes));
        let [tracks, left] = pattern.cells(situation, routes, spacing);
        // The policy `path` finds by itself what tracks leave out.
        let left = if after_pattern == AfterPattern::Path { &[] } else { share(&left, place) };
        Made { order: [share(&tracks, place), left].concat(), reached: in_reach(routes) }
    }
}

impl Policy for Coverage {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let routes = situation.routes();
        let mut pattern =
            self.pattern.take().unwrap_or_else(|| self.make(situation, &routes, situation.place));
        // Cells that the robot stands in, or that were closed or cut off since, are none of the way.
        let is_waypoint = |cell: Cell| cell != situation.robot && routes.length(cell).is_finite();
        let first_from = |order: &[Cell], next: usize| {
            order[next..].iter().position(|&cell| is_waypoint(cell)).map(|skipped| next + skipped)
        };
        let ahead = first_from(&pattern.order, self.next);
        if ahead.is_none() {
            if self.parameters.after_pattern == AfterPattern::Path {
                self.next = pattern.order.len();
                self.pattern = Some(pattern);
                return self.path.decide(situation, random);
            }
            if pattern.reached != in_reach(&routes) {
                pattern = self.make(situation, &routes, Place::ALONE);
                self.next = pattern.order.len();
            }
        }
        let order = &self.pattern.insert(pattern).order;
        let place = ahead.or_else(|| first_from(order, 0));
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for cell in routes.candidates() {
            scores[cell.index()] = 0.0;
        }
        let nothing = PlannedPrecision::nothing(situation.terrain);
        let alone = without_plans(situation, &nothing);
        // What the pattern cannot see it will not see by being repeated.
        if ahead.is_none() {
            let again: Vec<Cell> =
                order.iter().copied().filter(|&cell| routes.length(cell).is_finite()).collect();
            if !is_path_informative(&alone, &again) {
                return Decision::rest(&routes, scores);
            }
        }
        if let Some(place) = place {
            scores[order[place].index()] = 1.0;
            self.next = place + 1;
        }
        Decision::best(&routes, scores).unless_all_is_known(&alone, &routes)
    }
}

fn in_reach(routes: &ShortestPathTree) -> Vec<Cell> {
    let mut reached = routes.reached().to_vec();
    reached.sort_unstable();
    reached
}

fn share(order: &[Cell], Place { member, team }: Place) -> &[Cell] {
    let bound = |member: u16| order.len() * usize::from(member) / usize::from(team.max(1));
    &order[bound(member)..bound(member + 1)]
}

#[cfg(test)]
mod tests;
