//! All that a policy may see.

use crate::belief::Belief;
use crate::cell::Cell;
use crate::intent::PlannedPrecision;
use crate::route::Connectivity;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// The world as one robot knows it at one decision.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The map.
    pub terrain: &'a Terrain,
    /// How the robot moves on it.
    pub connectivity: Connectivity,
    /// What the robot sees with.
    pub sensor: &'a Sensor,
    /// What it believes.
    pub belief: &'a Belief,
    /// What its teammates are about to see.
    pub promised: &'a PlannedPrecision,
    /// The cell that it is in.
    pub robot: Cell,
    /// Its place in the team.
    pub place: Place,
}

/// A robot's place in its team: which one of how many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// `0..team`.
    pub member: u16,
    /// Robots in the team, at least 1.
    pub team: u16,
}

impl Place {
    /// The one robot of a team of one.
    pub const ALONE: Self = Self { member: 0, team: 1 };
}
