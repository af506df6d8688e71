//! The input and the result of planning: goal, effort, path, cost and bound.

use std::ops::Range;

use super::costmap::CostMapError;
use super::footprint::FootprintError;
use crate::plane::Pose;

/// Largest inflation.
pub const MAX_INFLATION: f64 = 100.0;
/// Smallest step between inflations.
pub const MIN_INFLATION_STEP: f64 = 0.5;

/// The end of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Meters to the east, on the map.
    pub x_meters: f64,
    /// Meters to the north, on the map.
    pub y_meters: f64,
    /// Counterclockwise from east, radians; rounded to the nearest heading of the lattice. `None`: any heading.
    pub heading_radians: Option<f64>,
    /// Cells whose centers are within it count too; 0 or more. The goal's own cell always does.
    pub tolerance_meters: f64,
}

/// The improvement of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Inflation of the first search, 1 to [`MAX_INFLATION`].
    pub first_inflation: f64,
    /// Decrease of the inflation with each search, [`MIN_INFLATION_STEP`] or more. If the bound is already better than
    /// that, the next inflation is halfway between the bound and 1.
    pub inflation_step: f64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { first_inflation: 3.0, inflation_step: 0.5 }
    }
}

/// A path, when it was found or its bound improved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Inflation of the search that found it; `None` if it came from a coarse map, which gives no guarantee by itself.
    pub inflation: Option<f64>,
    /// In units: [`super::UNITS_PER_CELL`] for a cell's edge over free ground.
    pub cost: u32,
    /// No path costs less than `cost / bound`; 1 if none is cheaper.
    pub bound: f64,
    /// States expanded so far.
    pub expansions: u64,
}

/// The progress of planning, passed to the caller's `go_on`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// States expanded so far.
    pub expansions: u64,
    /// The best path so far.
    pub solution: Option<Solution>,
}

/// One primitive of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Index in [`super::primitives::PrimitiveSet::primitives`].
    pub primitive: usize,
    /// In units.
    pub cost: u64,
    /// The plan's poses along it, both ends included: the end of a step is the start of the next.
    pub poses: Range<usize>,
}

/// A path that the vehicle can drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// On the map, from the center of the start's cell on; never empty.
    pub poses: Vec<Pose>,
    /// Empty if the start is a goal.
    pub steps: Vec<Step>,
    /// In units: [`super::UNITS_PER_CELL`] for a cell's edge over free ground.
    pub cost: u64,
    /// Of the polyline of the poses.
    pub length_meters: f64,
    /// No path costs less than `cost / bound`; 1 if none is cheaper.
    pub bound: f64,
    /// The history of solutions: bounds and costs never increase.
    pub solutions: Vec<Solution>,
    /// Total number of expanded states.
    pub expansions: u64,
}

/// Why a planner cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlannerError {
    /// An invalid footprint.
    #[error(transparent)]
    Footprint(#[from] FootprintError),
    /// An invalid change of the map.
    #[error(transparent)]
    Map(#[from] CostMapError),
    /// Primitives of another resolution.
    #[error(
        "primitives for cells of {primitives_meters} m on a map with cells of {map_meters} m: both must be \
         equal"
    )]
    Resolution {
        /// Resolution of the primitives.
        primitives_meters: f64,
        /// Resolution of the map.
        map_meters: f64,
    },
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// NaN or infinite.
    #[error("start or goal with a number that is not finite, or a tolerance below 0")]
    NotFinite,
    /// Invalid inflation.
    #[error(
        "inflation from {first} down in steps of {step}: allowed are 1 to {MAX_INFLATION}, in steps of \
         {MIN_INFLATION_STEP} or more"
    )]
    Effort {
        /// The given value.
        first: f64,
        /// The given value.
        step: f64,
    },
    /// The vehicle is not on the map.
    #[error("the start ({0} m, {1} m) is not on the map")]
    StartOutside(f64, f64),
    /// The vehicle stands on lethal ground.
    #[error("at the start ({0} m, {1} m) the footprint covers a lethal cell, or ground beside the map")]
    StartBlocked(f64, f64),
    /// The goal is not on the map.
    #[error("the goal ({0} m, {1} m) is not on the map")]
    GoalOutside(f64, f64),
    /// The vehicle cannot stand there.
    #[error(
        "at the goal ({0} m, {1} m), everywhere within its tolerance, the footprint covers a lethal cell, or \
         ground beside the map"
    )]
    GoalBlocked(f64, f64),
    /// No path exists.
    #[error("no path leads from the start to the goal ({expansions} states were expanded)")]
    NoWay {
        /// States expanded.
        expansions: u64,
    },
    /// The cost exceeds 32 bits.
    #[error("every path to the goal costs more than {} units", u32::MAX)]
    TooCostly,
    /// The caller stopped before there was a first path.
    #[error("stopped before a first path was found ({expansions} states were expanded)")]
    Stopped {
        /// States expanded.
        expansions: u64,
    },
}

/// Checks the numbers of a request.
pub(super) fn check_numbers(start: Pose, goal: &Goal, effort: Effort) -> Result<(), PlanError> {
    let heading_radians = goal.heading_radians.unwrap_or(0.0);
    let is_goal = Pose { x_meters: goal.x_meters, y_meters: goal.y_meters, heading_radians }.is_finite();
    let is_tolerance = goal.tolerance_meters.is_finite() && goal.tolerance_meters >= 0.0;
    if !(start.is_finite() && is_goal && is_tolerance) {
        return Err(PlanError::NotFinite);
    }
    let Effort { first_inflation: first, inflation_step: step } = effort;
    let is_effort = (1.0..=MAX_INFLATION).contains(&first) && step >= MIN_INFLATION_STEP;
    if is_effort { Ok(()) } else { Err(PlanError::Effort { first, step }) }
}
