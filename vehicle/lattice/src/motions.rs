//! Primitives prepared for a map: their costs, the ground that they sweep, and the cells that they cross.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::footprint::{Footprint, nearest};
use super::metric::{Metric, STEP_REACH, UNITS_PER_CELL, length_cells, steps};
use super::primitives::{Primitive, PrimitiveSet};
use crate::plane::{Pose, turn_radians};

/// Maximum movement of any point of the vehicle between two samples of a motion, in cells.
const SAMPLE_CELLS: f64 = 0.25;

/// A cell relative to another, as (north, east).
pub(super) type Shift = (i32, i32);

/// Adjacent cells of one row, at most 64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Run {
    pub(super) north: i32,
    /// Of the first cell.
    pub(super) east: i32,
    /// A bit for each cell, the lowest for the first.
    pub(super) mask: u64,
}

/// One primitive.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) primitive: u16,
    pub(super) start_heading: u8,
    pub(super) end_heading: u8,
    pub(super) east: i32,
    pub(super) north: i32,
    /// Over free ground, in units.
    pub(super) cost: u32,
    swept: Range<usize>,
    path: Range<usize>,
}

/// All primitives of a set, for one footprint.
#[derive(Clone, Debug)]
pub(super) struct Motions {
    /// Those that start with each heading, shape `[headings]`.
    by_heading: Vec<Range<usize>>,
    all: Vec<Motion>,
    /// Index in `all` of each primitive, shape `[primitives]`.
    of_primitive: Vec<usize>,
    runs: Vec<Run>,
    cells: Vec<Shift>,
    /// Cells covered at rest, shape `[headings]`.
    standing: Vec<Vec<Run>>,
    /// Cells covered wherever the vehicle is in a cell, relative to that cell: see [`Motions::core`].
    core: Vec<Shift>,
    /// Maximum distance of swept cells from the first, along an axis.
    reach_cells: usize,
    metric: Metric,
}

impl Motions {
    pub(super) fn new(set: &PrimitiveSet, footprint: &Footprint) -> Self {
        let mut made = Self {
            by_heading: Vec::new(),
            all: Vec::new(),
            of_primitive: vec![0; set.primitives().len()],
            runs: Vec::new(),
            cells: Vec::new(),
            standing: Vec::new(),
            core: Vec::new(),
            reach_cells: 0,
            metric: Metric::scaled(1.0),
        };
        let resolution_meters = set.resolution_meters();
        let mut core: Option<BTreeSet<Shift>> = None;
        let mut scale = 1.0_f64;
        for (heading, &heading_radians) in set.headings_radians().iter().enumerate() {
            let first = made.all.len();
            for (index, primitive) in (0_u16..).zip(set.primitives()) {
                if primitive.start_heading == heading {
                    let cost = cost(primitive, footprint, resolution_meters);
                    let path = made.add(index, primitive, cost, footprint, resolution_meters, &mut core);
                    let length = chain_cells(&path, (primitive.north_cells, primitive.east_cells));
                    if length > 0.0 {
                        scale = scale.min(f64::from(cost) / (f64::from(UNITS_PER_CELL) * length));
                    }
                }
            }
            made.by_heading.push(first..made.all.len());
            let rest = Pose { x_meters: 0.0, y_meters: 0.0, heading_radians };
            let mut covered: BTreeSet<Shift> = footprint.cells(rest, resolution_meters).into_iter().collect();
            covered.insert((0, 0));
            made.reach_cells = made.reach_cells.max(reach(&covered));
            made.standing.push(runs(&covered));
        }
        made.core = core.unwrap_or_default().into_iter().collect();
        made.metric = Metric::scaled(scale);
        made
    }

    /// Adds a primitive; returns the cells that its reference point crosses.
    fn add(
        &mut self,
        index: u16,
        primitive: &Primitive,
        cost: u32,
        footprint: &Footprint,
        resolution_meters: f64,
        core: &mut Option<BTreeSet<Shift>>,
    ) -> BTreeSet<Shift> {
        let mut swept = BTreeSet::new();
        let mut path = BTreeSet::new();
        for pose in samples(primitive, footprint, resolution_meters) {
            let at = (nearest(pose.y_meters / resolution_meters), nearest(pose.x_meters / resolution_meters));
            let mut covered = footprint.cells(pose, resolution_meters);
            covered.push(at);
            let around: BTreeSet<Shift> =
                covered.iter().map(|&(north, east)| (north - at.0, east - at.1)).collect();
            match core {
                Some(core) => core.retain(|shift| around.contains(shift)),
                None => *core = Some(around),
            }
            swept.extend(covered);
            path.insert(at);
        }
        self.reach_cells = self.reach_cells.max(reach(&swept));
        let first_run = self.runs.len();
        self.runs.extend(runs(&swept));
        let first_cell = self.cells.len();
        self.cells.extend(&path);
        self.of_primitive[usize::from(index)] = self.all.len();
        self.all.push(Motion {
            primitive: index,
            start_heading: u8::try_from(primitive.start_heading).unwrap_or(u8::MAX),
            end_heading: u8::try_from(primitive.end_heading).unwrap_or(u8::MAX),
            east: primitive.east_cells,
            north: primitive.north_cells,
            cost,
            swept: first_run..self.runs.len(),
            path: first_cell..self.cells.len(),
        });
        path
    }

    pub(super) fn heading_count(&self) -> usize {
        self.by_heading.len()
    }

    pub(super) fn starting_with(&self, heading: usize) -> &[Motion] {
        &self.all[self.by_heading[heading].clone()]
    }

    pub(super) fn of_primitive(&self, primitive: u16) -> &Motion {
        &self.all[self.of_primitive[usize::from(primitive)]]
    }

    /// The ground that it sweeps, relative to its first cell.
    pub(super) fn swept(&self, motion: &Motion) -> &[Run] {
        &self.runs[motion.swept.clone()]
    }

    /// Cells that its reference point crosses, relative to its first cell.
    pub(super) fn path(&self, motion: &Motion) -> &[Shift] {
        &self.cells[motion.path.clone()]
    }

    pub(super) fn standing(&self, heading: usize) -> &[Run] {
        &self.standing[heading]
    }

    /// Cells that the footprint covers at every sample of every motion, relative to the cell that the reference point
    /// is in then: the inscribed circle on this grid. If one of them is lethal around a cell, no motion leads over that
    /// cell.
    pub(super) fn core(&self) -> &[Shift] {
        &self.core
    }

    pub(super) const fn reach_cells(&self) -> usize {
        self.reach_cells
    }

    /// Where all cells within motions' reach are free, no cell within a step is blocked.
    pub(super) fn reach_beyond_core(&self) -> bool {
        let far = |&(north, east): &Shift| north.unsigned_abs().max(east.unsigned_abs()) as usize;
        self.core.iter().map(far).max().unwrap_or(0) + STEP_REACH <= self.reach_cells
    }

    /// The grid metric that no motion undercuts: each motion costs at least as much as some chain of steps from its
    /// start to its end, over cells that its reference point crosses.
    pub(super) const fn metric(&self) -> Metric {
        self.metric
    }

    pub(super) fn bytes(&self) -> usize {
        self.runs.len() * size_of::<Run>()
            + self.cells.len() * size_of::<Shift>()
            + self.all.len() * size_of::<Motion>()
    }
}

/// Its cost over free ground: its length in cells times [`UNITS_PER_CELL`] and its multiplier. Its length is at least
/// the distance from center to center; for a turn on the spot, it is the movement of the footprint's farthest point.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "primitives are 1024 cells at most"
)]
fn cost(primitive: &Primitive, footprint: &Footprint, resolution_meters: f64) -> u32 {
    let straight_cells = f64::from(primitive.east_cells).hypot(f64::from(primitive.north_cells));
    let length_cells = primitive.length_meters() / resolution_meters;
    let turn_cells = primitive.turned_radians() * footprint.circumscribed_meters() / resolution_meters;
    let cells =
        if straight_cells > 0.0 { length_cells.max(straight_cells) } else { length_cells.max(turn_cells) };
    let units = (f64::from(UNITS_PER_CELL) * cells).round() as u32;
    units.max(1).saturating_mul(primitive.cost_multiplier)
}

/// Poses so close to each other that no cell is missed in between.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "poses are finite and near")]
fn samples(primitive: &Primitive, footprint: &Footprint, resolution_meters: f64) -> Vec<Pose> {
    let mut samples: Vec<Pose> = primitive.poses.first().copied().into_iter().collect();
    for pair in primitive.poses.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let (dx, dy) = (to.x_meters - from.x_meters, to.y_meters - from.y_meters);
        let turn = turn_radians(from.heading_radians, to.heading_radians);
        let moved_meters = dx.hypot(dy) + turn.abs() * footprint.circumscribed_meters();
        let count = (moved_meters / resolution_meters / SAMPLE_CELLS).ceil().max(1.0) as u32;
        samples.extend((1..=count).map(|index| {
            let part = f64::from(index) / f64::from(count);
            Pose {
                x_meters: from.x_meters + part * dx,
                y_meters: from.y_meters + part * dy,
                heading_radians: from.heading_radians + part * turn,
            }
        }));
    }
    samples
}

fn reach(cells: &BTreeSet<Shift>) -> usize {
    cells.iter().map(|&(north, east)| north.unsigned_abs().max(east.unsigned_abs())).max().unwrap_or(0)
        as usize
}

fn runs(cells: &BTreeSet<Shift>) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for &(north, east) in cells {
        match runs.last_mut() {
            Some(run) if run.north == north && east - run.east < 64 => run.mask |= 1 << (east - run.east),
            _ => runs.push(Run { north, east, mask: 1 }),
        }
    }
    runs
}

/// Length of the shortest chain of grid steps from the origin to a cell, over the given cells only; 0 if
/// there is none.
fn chain_cells(cells: &BTreeSet<Shift>, to: Shift) -> f64 {
    let steps = steps();
    let mut length: BTreeMap<Shift, f64> = BTreeMap::from([((0, 0), 0.0)]);
    let mut changed = vec![(0, 0)];
    while let Some(from) = changed.pop() {
        let here = length.get(&from).copied().unwrap_or(f64::INFINITY);
        for step in &steps {
            let next = (from.0 + step.north, from.1 + step.east);
            let longer = here + length_cells(step.kind);
            if cells.contains(&next) && length.get(&next).is_none_or(|&known| longer < known - 1e-9) {
                length.insert(next, longer);
                changed.push(next);
            }
        }
    }
    length.get(&to).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maneuvers::{Headings, Maneuvers};

    #[test]
    fn motions_of_a_car_cost_their_length_and_sweep_its_footprint() {
        let maneuvers = Maneuvers {
            resolution_meters: 0.1,
            headings: Headings::Sixteen,
            turning_radius_meters: 1.0,
            reverse: Some(3),
            turn_in_place: Some(2),
        };
        let set = maneuvers.primitives().unwrap();
        let motions = Motions::new(&set, &Footprint::rectangle(0.5, 0.3));
        let forward = &motions.starting_with(0)[..2];
        assert_eq!((forward[0].cost, forward[1].cost), (1_000, 8_000));
        assert_eq!(motions.starting_with(0)[4].cost, 3_000);
        let spot = &motions.starting_with(0)[7];
        assert_eq!((spot.east, spot.north), (0, 0));
        let expected = 2.0 * 0.5_f64.atan2(1.0) * 0.25_f64.hypot(0.15) / 0.1 * 1_000.0;
        assert!((f64::from(spot.cost) - expected).abs() <= 2.0, "{} {expected}", spot.cost);
        // From a cell to the next: six cells long, three wide.
        let row = |north| Run { north, east: -2, mask: 0b11_1111 };
        assert_eq!(motions.swept(&forward[0]), [row(-1), row(0), row(1)]);
        assert_eq!(motions.path(&forward[0]), [(0, 0), (0, 1)]);
        assert!(motions.core().contains(&(0, 0)) && motions.core().len() >= 5, "{:?}", motions.core());
        let weights = motions.metric().weights;
        assert!(weights[0] > 980 && weights[0] <= 1_000, "{weights:?}");
    }
}
