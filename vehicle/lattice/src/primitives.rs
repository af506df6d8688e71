//! Motion primitives: short motions between lattice states, of which every path is composed.

use std::f64::consts::TAU;

use crate::plane::{Pose, turn_radians};

/// The maximum number of headings of a set.
pub const MAX_HEADINGS: usize = 256;
/// Maximum reach of a primitive along an axis, in cells.
pub const MAX_REACH_CELLS: i32 = 256;
/// The maximum number of intermediate poses of a primitive.
pub const MAX_POSES: usize = 1_000;
/// Largest cost multiplier.
pub const MAX_COST_MULTIPLIER: u32 = 1_000;
/// The maximum number of primitives of a set: their indices fit 16 bits.
pub const MAX_PRIMITIVES: usize = u16::MAX as usize;

/// A motion from a heading in one cell to a heading in another. It may start in any cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// `primID`: the number of the primitive among those of its start heading.
    pub number: u32,
    /// Index of its start heading, `0..heading_count`.
    pub start_heading: usize,
    /// Index of its end heading, `0..heading_count`.
    pub end_heading: usize,
    /// Cells to the east, from start to end.
    pub east_cells: i32,
    /// Cells to the north, from start to end.
    pub north_cells: i32,
    /// Factor of its cost, 1 to [`MAX_COST_MULTIPLIER`].
    pub cost_multiplier: u32,
    /// Poses along the motion, the first at its start, the last at its end, positions relative to the center of its
    /// first cell; at least 2.
    pub poses: Vec<Pose>,
}

impl Primitive {
    /// Length of the polyline of its poses, meters.
    #[must_use]
    pub fn length_meters(&self) -> f64 {
        self.poses.windows(2).map(|pair| distance_meters(pair[0], pair[1])).sum()
    }

    /// Sum of the absolute turns between its poses, radians.
    #[must_use]
    pub fn turned_radians(&self) -> f64 {
        let turn = |pair: &[Pose]| turn_radians(pair[0].heading_radians, pair[1].heading_radians).abs();
        self.poses.windows(2).map(turn).sum()
    }
}

fn distance_meters(a: Pose, b: Pose) -> f64 {
    (b.x_meters - a.x_meters).hypot(b.y_meters - a.y_meters)
}

/// Primitives for all headings, at one resolution, all of them valid: see [`Unsound`].
#[derive(Clone, Debug, PartialEq)]
pub struct PrimitiveSet {
    resolution_meters: f64,
    headings_radians: Vec<f64>,
    primitives: Vec<Primitive>,
}

/// Why a set of primitives is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsound {
    /// Not a cell edge.
    #[error("a resolution of {0} m: allowed is a finite length above 0")]
    Resolution(f64),
    /// No headings, or too many.
    #[error("{0} headings: allowed are 1 to {MAX_HEADINGS}")]
    HeadingCount(u64),
    /// No primitives, or too many.
    #[error("{0} primitives: allowed are 1 to {MAX_PRIMITIVES}")]
    PrimitiveCount(u64),
    /// A heading that is not one of the set's.
    #[error("heading {given}: allowed are {least} to {most}", most = heading_count - 1)]
    Heading {
        /// The given value.
        given: i64,
        /// 0, or the smallest negative heading, which counts backward from 0.
        least: i64,
        /// Headings of the set.
        heading_count: i64,
    },
    /// An end too far away.
    #[error("an end {given} cells away: allowed are -{MAX_REACH_CELLS} to {MAX_REACH_CELLS}")]
    Reach {
        /// The given value.
        given: i64,
    },
    /// It ends in the state in which it starts.
    #[error("the primitive ends where it starts, with the same heading: it leads nowhere")]
    Nowhere,
    /// A cost multiplier out of range.
    #[error("a cost multiplier of {0}: allowed are 1 to {MAX_COST_MULTIPLIER}")]
    CostMultiplier(i64),
    /// Too few or too many poses.
    #[error("{0} intermediate poses: allowed are 2 to {MAX_POSES}")]
    PoseCount(u64),
    /// NaN, infinite, or far from the primitive's cells.
    #[error(
        "intermediate pose ({x}, {y}, {heading}): allowed are finite numbers, within {MAX_REACH_CELLS} cells of the \
         start and 1000 radians"
    )]
    Pose {
        /// Meters.
        x: f64,
        /// Meters.
        y: f64,
        /// Radians.
        heading: f64,
    },
    /// The first or last pose is not where the primitive starts or ends.
    #[error(
        "the {which} intermediate pose ({x}, {y}, {heading}) is not at the primitive's {which} pose ({expected_x}, \
         {expected_y}, {expected_heading}): allowed is less than half a cell and half a heading step beside it"
    )]
    Joint {
        /// "start" or "end".
        which: &'static str,
        /// Meters.
        x: f64,
        /// Meters.
        y: f64,
        /// Radians.
        heading: f64,
        /// Meters.
        expected_x: f64,
        /// Meters.
        expected_y: f64,
        /// Radians.
        expected_heading: f64,
    },
    /// Its path is too long.
    #[error("{0} cells of path between start and end: allowed are at most {most}", most = 4 * MAX_REACH_CELLS)]
    Length(f64),
    /// Two primitives of one heading with the same number.
    #[error("number {number} stands twice among the primitives of heading {heading}")]
    Twice {
        /// `primID`.
        number: u32,
        /// Start heading.
        heading: usize,
    },
    /// A heading without a primitive.
    #[error("no primitive starts with heading {0}: each needs one at least")]
    NoPrimitive(usize),
}

/// The invalid part of a primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Number,
    End,
    Pose(usize),
}

impl PrimitiveSet {
    /// Assembles a set of primitives that were each checked by [`check`]; checks their combination.
    pub(crate) fn assemble(
        resolution_meters: f64,
        heading_count: usize,
        primitives: Vec<Primitive>,
    ) -> Result<Self, Unsound> {
        let mut headings_radians = Vec::with_capacity(heading_count);
        for heading in 0..heading_count {
            // The poses give the exact angle: a lattice whose headings point at cells has unequal steps.
            let first = primitives.iter().find(|primitive| primitive.start_heading == heading);
            let pose =
                first.and_then(|primitive| primitive.poses.first()).ok_or(Unsound::NoPrimitive(heading))?;
            headings_radians.push(pose.heading_radians.rem_euclid(TAU));
        }
        Ok(Self { resolution_meters, headings_radians, primitives })
    }

    /// Edge of a cell, meters.
    #[must_use]
    pub const fn resolution_meters(&self) -> f64 {
        self.resolution_meters
    }

    /// The headings' angles, counterclockwise from east, radians in 0 to 2 pi, shape `[headings]`.
    #[must_use]
    pub fn headings_radians(&self) -> &[f64] {
        &self.headings_radians
    }

    /// All primitives, in the order of the text they came from.
    #[must_use]
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// The heading nearest to an angle; of two equally near ones the smaller index.
    #[must_use]
    pub fn nearest_heading(&self, heading_radians: f64) -> usize {
        let off = |index: usize| turn_radians(self.headings_radians[index], heading_radians).abs();
        (0..self.headings_radians.len()).min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0)
    }
}

/// Checks one primitive by itself; the error names its invalid part.
pub(crate) fn check(
    primitive: &Primitive,
    resolution_meters: f64,
    heading_count: usize,
) -> Result<(), (Part, Unsound)> {
    let Primitive { poses, east_cells, north_cells, .. } = primitive;
    let (Some(&first), Some(&last), true) = (poses.first(), poses.last(), poses.len() <= MAX_POSES) else {
        return Err((Part::Number, Unsound::PoseCount(poses.len() as u64)));
    };
    if (*east_cells, *north_cells, primitive.start_heading) == (0, 0, primitive.end_heading) {
        return Err((Part::End, Unsound::Nowhere));
    }
    let reach_meters = f64::from(MAX_REACH_CELLS) * resolution_meters;
    for (index, &pose) in poses.iter().enumerate() {
        let Pose { x_meters: x, y_meters: y, heading_radians: heading } = pose;
        if !pose.is_finite() || x.abs().max(y.abs()) > reach_meters || heading.abs() > 1_000.0 {
            return Err((Part::Pose(index), Unsound::Pose { x, y, heading }));
        }
    }
    let step_radians = TAU / heading_count as f64;
    let joint = |which, pose: Pose, expected: Pose| {
        let half_cell = resolution_meters / 2.0;
        let fits = (pose.x_meters - expected.x_meters).abs() < half_cell
            && (pose.y_meters - expected.y_meters).abs() < half_cell
            && turn_radians(pose.heading_radians, expected.heading_radians).abs() < step_radians / 2.0;
        let Pose { x_meters: x, y_meters: y, heading_radians: heading } = pose;
        let Pose { x_meters: expected_x, y_meters: expected_y, heading_radians: expected_heading } = expected;
        let unsound = Unsound::Joint { which, x, y, heading, expected_x, expected_y, expected_heading };
        if fits { Ok(()) } else { Err(unsound) }
    };
    let at = |east: i32, north: i32, heading: usize| Pose {
        x_meters: f64::from(east) * resolution_meters,
        y_meters: f64::from(north) * resolution_meters,
        heading_radians: heading as f64 * step_radians,
    };
    joint("start", first, at(0, 0, primitive.start_heading)).map_err(|unsound| (Part::Pose(0), unsound))?;
    joint("end", last, at(*east_cells, *north_cells, primitive.end_heading))
        .map_err(|unsound| (Part::Pose(poses.len() - 1), unsound))?;
    let length_cells = primitive.length_meters() / resolution_meters;
    if length_cells > f64::from(4 * MAX_REACH_CELLS) {
        return Err((Part::Number, Unsound::Length(length_cells)));
    }
    Ok(())
}
