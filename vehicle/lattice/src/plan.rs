//! What a plan is asked for, and what it says: the path, what it costs, and how much better another could be.

use std::ops::Range;

use super::costmap::CostMapError;
use super::footprint::FootprintError;
use crate::plane::Pose;

/// Largest inflation.
pub const MAX_INFLATION: f64 = 100.0;
/// Smallest step between inflations.
pub const MIN_INFLATION_STEP: f64 = 0.5;

/// Where a plan should end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Meters to the east, on the map.
    pub x_meters: f64,
    /// Meters to the north, on the map.
    pub y_meters: f64,
    /// Counterclockwise from east, radians; the nearest heading of the lattice counts. Without it any does.
    pub heading_radians: Option<f64>,
    /// Cells whose centers lie within it count too; 0 or more. The goal's own cell always does.
    pub tolerance_meters: f64,
}

/// How a plan is improved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Of the first search, 1 to [`MAX_INFLATION`].
    pub first_inflation: f64,
    /// How much less each next search has, [`MIN_INFLATION_STEP`] or more. If the bound is better than that
    /// already, the next inflation is halfway between the bound and 1.
    pub inflation_step: f64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { first_inflation: 3.0, inflation_step: 0.5 }
    }
}

/// A way as it was found or proven better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Of the search that found it; `None` if a coarse map led there, which promises nothing by itself.
    pub inflation: Option<f64>,
    /// In units: [`super::UNITS_PER_CELL`] for a cell's edge over free ground.
    pub cost: u32,
    /// No way costs less than `cost / bound`; 1 if none is cheaper.
    pub bound: f64,
    /// States expanded until then.
    pub expansions: u64,
}

/// What a caller hears whenever it is asked whether there is time to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// States expanded so far.
    pub expansions: u64,
    /// The best way so far.
    pub solution: Option<Solution>,
}

/// One primitive of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Index in [`super::primitives::PrimitiveSet::primitives`].
    pub primitive: usize,
    /// In units.
    pub cost: u64,
    /// Which of the plan's poses it leads along, both ends included: the end of a step is the start of the
    /// next.
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
    /// No way costs less than `cost / bound`; 1 if none is cheaper.
    pub bound: f64,
    /// How it came about: bounds and costs never rise.
    pub solutions: Vec<Solution>,
    /// States expanded in all.
    pub expansions: u64,
}

/// Why there is no planner.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlannerError {
    /// Of the outline.
    #[error(transparent)]
    Footprint(#[from] FootprintError),
    /// Of a change of the map.
    #[error(transparent)]
    Map(#[from] CostMapError),
    /// Primitives for other cells.
    #[error(
        "primitives for cells of {primitives_meters} m on a map with cells of {map_meters} m: both must be \
         equal"
    )]
    Resolution {
        /// Of the primitives.
        primitives_meters: f64,
        /// Of the map.
        map_meters: f64,
    },
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// NaN or infinite.
    #[error("start or goal with a number that is not finite, or a tolerance below 0")]
    NotFinite,
    /// The inflation cannot be.
    #[error(
        "inflation from {first} down in steps of {step}: allowed are 1 to {MAX_INFLATION}, in steps of \
         {MIN_INFLATION_STEP} or more"
    )]
    Effort {
        /// As given.
        first: f64,
        /// As given.
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
    /// The vehicle could not stand there.
    #[error(
        "at the goal ({0} m, {1} m), everywhere within its tolerance, the footprint covers a lethal cell, or \
         ground beside the map"
    )]
    GoalBlocked(f64, f64),
    /// All that can be reached was looked at.
    #[error("no way leads from the start to the goal ({expansions} states were looked at)")]
    NoWay {
        /// States expanded.
        expansions: u64,
    },
    /// Costs are 32-bit numbers.
    #[error("every way to the goal costs more than {} units", u32::MAX)]
    TooCostly,
    /// The caller said so before there was a first way.
    #[error("stopped before a first way was found ({expansions} states were looked at)")]
    Stopped {
        /// States expanded.
        expansions: u64,
    },
}

/// Whether these numbers are a question at all.
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
