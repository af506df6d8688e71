//! Motion primitives generated for a vehicle: forward, and arcs to either side.
//!
//! Each heading points at a cell, as in Pivtoraiko, Knepper and Kelly (2009), so that driving straight on leads from
//! center to center exactly; the steps between headings are therefore unequal. A turn from one heading to the next is
//! straight, an arc, straight: `n` steps along the old heading and `m` along the new one meet in a corner, and the arc
//! rounds it, as widely as both legs allow. Nothing is fitted or rounded: the radius holds exactly.

use std::f64::consts::TAU;

use super::primitives::{MAX_COST_MULTIPLIER, MAX_REACH_CELLS, Primitive, PrimitiveSet, Unsound};
use crate::plane::{Pose, turn_radians};

/// Minimum length of the long straight primitives, in cells.
const LONG_CELLS: f64 = 8.0;

/// Number of headings of a vehicle's lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Headings {
    /// Along axes and diagonals.
    Eight,
    /// Also along (2, 1) and its mirror images.
    #[default]
    Sixteen,
    /// Also along (4, 1), (3, 2) and their mirror images.
    ThirtyTwo,
}

impl Headings {
    /// Directions of the headings of the first eighth of the circle as cells east and north, both ends included.
    const fn eighth(self) -> &'static [(i32, i32)] {
        match self {
            Self::Eight => &[(1, 0), (1, 1)],
            Self::Sixteen => &[(1, 0), (2, 1), (1, 1)],
            Self::ThirtyTwo => &[(1, 0), (4, 1), (2, 1), (3, 2), (1, 1)],
        }
    }

    /// Directions of the headings as cells, counterclockwise from east.
    fn all(self) -> Vec<(i32, i32)> {
        let eighth = self.eighth();
        let mirrored = eighth[1..eighth.len() - 1].iter().rev().map(|&(east, north)| (north, east));
        let quarter: Vec<(i32, i32)> = eighth.iter().copied().chain(mirrored).collect();
        let turned = |turns: usize| {
            let turn = move |cell| (0..turns).fold(cell, |(east, north): (i32, i32), _| (-north, east));
            quarter.iter().map(move |&cell| turn(cell))
        };
        (0..4).flat_map(turned).collect()
    }
}

/// The maneuvers of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maneuvers {
    /// Edge of a cell of the map, meters, above 0.
    pub resolution_meters: f64,
    /// Headings of the lattice.
    pub headings: Headings,
    /// The turning radius, meters, above 0.
    pub turning_radius_meters: f64,
    /// Cost factor of driving backward, 1 to [`MAX_COST_MULTIPLIER`]; `None`: it does not.
    pub reverse: Option<u32>,
    /// Cost factor of turning on the spot, 1 to [`MAX_COST_MULTIPLIER`]; `None`: it does not.
    pub turn_in_place: Option<u32>,
}

/// Why primitives cannot be generated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ManeuversError {
    /// Invalid resolution or cost multiplier.
    #[error(transparent)]
    Unsound(#[from] Unsound),
    /// Not a radius, or too large for primitives.
    #[error(
        "a turning radius of {given_meters} m: allowed are lengths above 0, and at a resolution of \
         {resolution_meters} m at most about {max_meters} m, for which a turn is {MAX_REACH_CELLS} cells \
         long"
    )]
    TurningRadius {
        /// The given value.
        given_meters: f64,
        /// Edge of a cell.
        resolution_meters: f64,
        /// The maximum.
        max_meters: f64,
    },
}

impl Maneuvers {
    /// The primitives: for each heading a short and a long one straight on, and an arc to either side; with `reverse`
    /// the short one and the arcs backward; with `turn_in_place` a turn to either side. [`super::mprim::write`]
    /// converts them to text.
    ///
    /// # Errors
    /// If a number is out of its range.
    pub fn primitives(&self) -> Result<PrimitiveSet, ManeuversError> {
        self.check()?;
        let cells = self.headings.all();
        let count = cells.len();
        let mut primitives = Vec::new();
        for (heading, &cell) in cells.iter().enumerate() {
            let next = (heading + 1) % count;
            let before = (heading + count - 1) % count;
            let of = |heading: usize| Leg::toward(heading, cells[heading], self.resolution_meters);
            let long = steps(LONG_CELLS / f64::from(cell.0).hypot(f64::from(cell.1)));
            let mut all = vec![self.straight(of(heading), 1)];
            all.extend((long > 1).then(|| self.straight(of(heading), long)));
            all.push(self.turn(of(heading), of(next)));
            all.push(self.turn(of(heading), of(before)));
            if let Some(cost_multiplier) = self.reverse {
                let forward = [
                    self.straight(of(heading), 1),
                    self.turn(of(next), of(heading)),
                    self.turn(of(before), of(heading)),
                ];
                all.extend(forward.iter().map(|forward| backwards(forward, cost_multiplier)));
            }
            if let Some(cost_multiplier) = self.turn_in_place {
                all.extend([next, before].map(|to| in_place(of(heading), of(to), cost_multiplier)));
            }
            for (number, primitive) in (0..).zip(all) {
                if i64::from(primitive.east_cells.abs().max(primitive.north_cells.abs()))
                    > i64::from(MAX_REACH_CELLS)
                {
                    return Err(self.radius_error());
                }
                primitives.push(Primitive { number, ..primitive });
            }
        }
        Ok(PrimitiveSet::assemble(self.resolution_meters, count, primitives)?)
    }

    fn check(&self) -> Result<(), ManeuversError> {
        let is_length = |meters: f64| meters.is_finite() && meters > 0.0;
        if !is_length(self.resolution_meters) {
            return Err(Unsound::Resolution(self.resolution_meters).into());
        }
        for multiplier in [self.reverse, self.turn_in_place].into_iter().flatten() {
            if !(1..=MAX_COST_MULTIPLIER).contains(&multiplier) {
                return Err(Unsound::CostMultiplier(multiplier.into()).into());
            }
        }
        // Beyond this the number of steps of a leg would not fit.
        let max_cells = 16.0 * f64::from(MAX_REACH_CELLS);
        if !is_length(self.turning_radius_meters)
            || self.turning_radius_meters > max_cells * self.resolution_meters
        {
            return Err(self.radius_error());
        }
        Ok(())
    }

    fn radius_error(&self) -> ManeuversError {
        let cells = self.headings.all();
        let leg = |heading: usize| Leg::toward(heading, cells[heading], self.resolution_meters);
        let widest = (1..cells.len()).map(|next| turn_radians(leg(next - 1).radians, leg(next).radians));
        let tangent = (widest.fold(0.0, f64::max) / 2.0).tan();
        ManeuversError::TurningRadius {
            given_meters: self.turning_radius_meters,
            resolution_meters: self.resolution_meters,
            max_meters: (f64::from(MAX_REACH_CELLS / 2) * self.resolution_meters / tangent).floor(),
        }
    }

    fn straight(&self, leg: Leg, steps: i32) -> Primitive {
        let length_meters = leg.step_meters * f64::from(steps);
        let samples = self.samples(length_meters);
        let along = |index: i32| leg.at(length_meters * f64::from(index) / f64::from(samples));
        Primitive {
            number: 0,
            start_heading: leg.heading,
            end_heading: leg.heading,
            east_cells: leg.cell.0 * steps,
            north_cells: leg.cell.1 * steps,
            cost_multiplier: 1,
            poses: (0..=samples).map(along).collect(),
        }
    }

    /// Along `from`, around the corner, along `to`.
    fn turn(&self, from: Leg, to: Leg) -> Primitive {
        let turn_radians = turn_radians(from.radians, to.radians);
        let half_tangent = (turn_radians.abs() / 2.0).tan();
        let least_meters = self.turning_radius_meters * half_tangent;
        let (before, after) = (steps(least_meters / from.step_meters), steps(least_meters / to.step_meters));
        let before_meters = f64::from(before) * from.step_meters;
        let after_meters = f64::from(after) * to.step_meters;
        let corner_meters = before_meters.min(after_meters);
        let radius_meters = corner_meters / half_tangent;
        let arc_meters = radius_meters * turn_radians.abs();
        let begin = from.at(before_meters - corner_meters);
        let corner = from.at(before_meters);
        // Relative to the corner, where the new leg begins.
        let leave = |meters: f64| {
            let pose = to.at(meters);
            let (x_meters, y_meters) = (corner.x_meters + pose.x_meters, corner.y_meters + pose.y_meters);
            Pose { x_meters, y_meters, ..pose }
        };
        let mut poses = vec![from.at(0.0)];
        if before_meters > corner_meters {
            poses.push(begin);
        }
        let samples = self.samples(arc_meters);
        for index in 1..samples {
            let turned = turn_radians * f64::from(index) / f64::from(samples);
            // Forward and to the left of the arc's beginning.
            let (forward, left) = (radius_meters * turned.abs().sin(), radius_meters * (1.0 - turned.cos()));
            let left = left * turn_radians.signum();
            let (sin, cos) = from.radians.sin_cos();
            poses.push(Pose {
                x_meters: begin.x_meters + forward * cos - left * sin,
                y_meters: begin.y_meters + forward * sin + left * cos,
                heading_radians: (from.radians + turned).rem_euclid(TAU),
            });
        }
        poses.push(leave(corner_meters));
        if after_meters > corner_meters {
            poses.push(leave(after_meters));
        }
        Primitive {
            number: 0,
            start_heading: from.heading,
            end_heading: to.heading,
            east_cells: from.cell.0 * before + to.cell.0 * after,
            north_cells: from.cell.1 * before + to.cell.1 * after,
            cost_multiplier: 1,
            poses,
        }
    }

    /// Number of parts of a path: each at most half a cell.
    #[expect(clippy::cast_possible_truncation, reason = "primitives are shorter than a thousand cells")]
    fn samples(&self, length_meters: f64) -> i32 {
        (2.0 * length_meters / self.resolution_meters).ceil().clamp(2.0, 900.0) as i32
    }
}

/// The least number of whole steps of at least this length, and at least one.
#[expect(clippy::cast_possible_truncation, reason = "the radius was checked")]
fn steps(least: f64) -> i32 {
    // A tolerance for rounding.
    (least - 1e-9).ceil().max(1.0) as i32
}

/// A straight segment along one heading.
#[derive(Clone, Copy)]
struct Leg {
    heading: usize,
    cell: (i32, i32),
    radians: f64,
    step_meters: f64,
    resolution_meters: f64,
}

impl Leg {
    fn toward(heading: usize, cell: (i32, i32), resolution_meters: f64) -> Self {
        let (east, north) = (f64::from(cell.0), f64::from(cell.1));
        let step_meters = east.hypot(north) * resolution_meters;
        Self { heading, cell, radians: north.atan2(east).rem_euclid(TAU), step_meters, resolution_meters }
    }

    fn at(self, meters: f64) -> Pose {
        let steps = meters / self.step_meters * self.resolution_meters;
        Pose {
            x_meters: f64::from(self.cell.0) * steps,
            y_meters: f64::from(self.cell.1) * steps,
            heading_radians: self.radians,
        }
    }
}

/// The same path from its end to its start.
fn backwards(forward: &Primitive, cost_multiplier: u32) -> Primitive {
    let end =
        forward.poses.last().copied().unwrap_or(Pose { x_meters: 0.0, y_meters: 0.0, heading_radians: 0.0 });
    let from_end = |pose: &Pose| Pose {
        x_meters: pose.x_meters - end.x_meters,
        y_meters: pose.y_meters - end.y_meters,
        heading_radians: pose.heading_radians,
    };
    Primitive {
        start_heading: forward.end_heading,
        end_heading: forward.start_heading,
        east_cells: -forward.east_cells,
        north_cells: -forward.north_cells,
        cost_multiplier,
        poses: forward.poses.iter().rev().map(from_end).collect(),
        ..*forward
    }
}

fn in_place(from: Leg, to: Leg, cost_multiplier: u32) -> Primitive {
    Primitive {
        number: 0,
        start_heading: from.heading,
        end_heading: to.heading,
        east_cells: 0,
        north_cells: 0,
        cost_multiplier,
        poses: vec![from.at(0.0), to.at(0.0)],
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mentions::assert_mentions;
    use crate::{mprim, primitives};

    const CAR: Maneuvers = Maneuvers {
        resolution_meters: 0.1,
        headings: Headings::Sixteen,
        turning_radius_meters: 1.0,
        reverse: None,
        turn_in_place: None,
    };

    fn maneuvers() -> impl Strategy<Value = Maneuvers> {
        let headings = prop_oneof![Just(Headings::Eight), Just(Headings::Sixteen), Just(Headings::ThirtyTwo)];
        let option = || prop::option::of(1_u32..5);
        (0.02_f64..2.0, headings, 0.01_f64..10.0, option(), option()).prop_map(
            |(resolution_meters, headings, radius_cells, reverse, turn_in_place)| Maneuvers {
                resolution_meters,
                headings,
                turning_radius_meters: radius_cells * 10.0 * resolution_meters,
                reverse,
                turn_in_place,
            },
        )
    }

    /// Each part of the path goes along the heading (or backward), and turns no tighter than the radius.
    fn assert_drivable(primitive: &Primitive, radius_meters: f64) {
        for pair in primitive.poses.windows(2) {
            let (dx, dy) = (pair[1].x_meters - pair[0].x_meters, pair[1].y_meters - pair[0].y_meters);
            let chord = dx.hypot(dy);
            let turn = turn_radians(pair[0].heading_radians, pair[1].heading_radians);
            if primitive.east_cells == 0 && primitive.north_cells == 0 {
                assert!(chord < 1e-9);
                continue;
            }
            let middle = pair[0].heading_radians + turn / 2.0;
            let along = (dx * middle.cos() + dy * middle.sin()).abs();
            assert!((along - chord).abs() <= 1e-9 * (1.0 + chord), "{pair:?} slips sideways");
            // The chord of an arc of radius r over an angle a is 2 r sin(a / 2).
            assert!(
                chord >= 2.0 * radius_meters * (turn.abs() / 2.0).sin() - 1e-9,
                "{pair:?} turns too tightly"
            );
        }
    }

    proptest! {
        #[test]
        fn the_turning_radius_is_honored_and_the_text_reads_back(maneuvers in maneuvers()) {
            let set = maneuvers.primitives().unwrap();
            for primitive in set.primitives() {
                prop_assert_eq!(
                    primitives::check(primitive, set.resolution_meters(), set.headings_radians().len()),
                    Ok(())
                );
                assert_drivable(primitive, maneuvers.turning_radius_meters);
            }
            prop_assert_eq!(mprim::read(&mprim::write(&set)), Ok(set));
        }

        #[test]
        fn no_numbers_panic(resolution in any::<f64>(), radius in any::<f64>(), multiplier in any::<u32>()) {
            let _ = Maneuvers {
                resolution_meters: resolution,
                turning_radius_meters: radius,
                reverse: Some(multiplier),
                ..CAR
            }.primitives();
        }
    }

    #[test]
    fn a_car_has_four_motions_a_heading() {
        let set = CAR.primitives().unwrap();
        assert_eq!(set.primitives().len(), 64);
        let ends: Vec<(i32, i32, usize)> =
            set.primitives()[..4].iter().map(|p| (p.east_cells, p.north_cells, p.end_heading)).collect();
        assert_eq!(ends, [(1, 0, 0), (8, 0, 0), (7, 2, 1), (7, -2, 15)]);
        let with_all = Maneuvers { reverse: Some(3), turn_in_place: Some(2), ..CAR };
        assert_eq!(with_all.primitives().unwrap().primitives().len(), 144);
    }

    #[test]
    fn a_radius_that_fits_no_primitive_is_reported() {
        let error = Maneuvers { turning_radius_meters: 300.0, ..CAR }.primitives().unwrap_err().to_string();
        assert_mentions(&error, "turning radius .. 300 m .. above 0");
        assert!(Maneuvers { turning_radius_meters: f64::NAN, ..CAR }.primitives().is_err());
        assert!(Maneuvers { reverse: Some(0), ..CAR }.primitives().is_err());
    }
}
