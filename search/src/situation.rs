//! The inputs of a policy.

use crate::belief::Belief;
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::route::Connectivity;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// The state of the search as one robot knows it at one decision.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The map.
    pub terrain: &'a Terrain,
    /// The moves that the robot can make.
    pub connectivity: Connectivity,
    /// The robot's sensor.
    pub sensor: &'a Sensor,
    /// The robot's belief.
    pub belief: &'a Belief,
    /// Precision that teammates plan to add.
    pub planned_precision: &'a PlannedPrecision,
    /// The robot's cell.
    pub robot: Cell,
    /// The robot's place in the team.
    pub place: Place,
    /// Probability from which a cell's object counts as found, above 0 and below 1.
    pub detection_threshold: f64,
    /// Path length that the robot may still drive by its budget, cells, at least 0; infinite without a budget.
    pub remaining_cells: f64,
}

impl<'a> Situation<'a> {
    /// The situation of a robot without teammates in a cell, with moves to four neighbors, the default detection
    /// threshold and no budget.
    #[must_use]
    pub const fn alone(
        terrain: &'a Terrain,
        sensor: &'a Sensor,
        belief: &'a Belief,
        planned_precision: &'a PlannedPrecision,
        robot: Cell,
    ) -> Self {
        Self {
            terrain,
            connectivity: Connectivity::Four,
            sensor,
            belief,
            planned_precision,
            robot,
            place: Place::ALONE,
            detection_threshold: DEFAULT_DETECTION_THRESHOLD,
            remaining_cells: f64::INFINITY,
        }
    }
}

/// The usual [`Situation::detection_threshold`].
pub const DEFAULT_DETECTION_THRESHOLD: f64 = 0.95;

/// A robot's index in its team, and the team's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// `0..team`.
    pub member: u16,
    /// Robots in the team, at least 1.
    pub team: u16,
}

impl Place {
    /// A team of one robot.
    pub const ALONE: Self = Self { member: 0, team: 1 };
}
