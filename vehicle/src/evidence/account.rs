//! The evidence that a robot's cameras have collected for each cell, and the part that it has published.
//!
//! A cell is divided into `PARTS` parts. In each frame with a part in view, an object there would have been missed with
//! some probability; the product over all frames is the probability that it was missed so far. If nothing was found,
//! the cell's evidence of being empty is `-ln(mean over its parts)`: a cell of which a tenth was never in view is never
//! emptier than `ln 10`, however often the rest was in view.
//!
//! Evidence adds up over all readings of a cell, and the frames of a robot are one experiment. So a robot publishes the
//! growth of its evidence since its last reading of the cell, and withdraws what has turned out to be wrong.

use std::collections::BTreeMap;

use dragnet_lattice::costmap::CostMap;
use dragnet_search::cell::{Cell, Offset};
use dragnet_search::line_of_sight::is_clear;
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;
use nalgebra::Vector2;

use super::spread;
use crate::camera::View;

/// Parts along the side of a cell.
const SIDE: u32 = 4;
/// Parts of a cell.
const PARTS: usize = (SIDE * SIDE) as usize;
/// Some of the parts of a cell, a bit for each.
pub(super) type Parts = u16;
pub(super) const NO_PART: Parts = 0;
pub(super) const ALL_PARTS: Parts = Parts::MAX;
const _: () = assert!(Parts::BITS as usize == PARTS);
/// A part was observed if an object there would have been missed with at most this probability.
const OBSERVED: f32 = 0.05;
/// Minimum probability that an object is missed in all frames of one observation, however many: whatever hides it hides
/// it in all.
const LEAST_MISSED_IN_AN_OBSERVATION: f32 = 1e-3;
/// Share of the detector's range up to which the miss probability is that of the settings,
const SURE_SHARE: f64 = 0.5;
/// and the share of the detection probability at the end of the range.
const SHARE_AT_THE_END: f64 = 0.1;

/// The accounts of all cells that were in view or published.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accounts {
    cells: BTreeMap<Cell, Account>,
}

/// The account of one cell. All but the distance are nats.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Account {
    /// By part, without what walls of the vehicle's own map hide.
    missed: Missed,
    /// As if these walls hid nothing: an object that is detected now is not behind one.
    missed_in_view: Missed,
    /// Manhattan distance of the nearest camera in this observation, cells.
    nearest: u32,
    /// Evidence of being empty that was collected from too far away to be published.
    untold: f64,
    /// Published evidence of being empty, at least 0.
    pub(super) empty: f64,
    /// Published evidence of an object in it, at least 0.
    pub(super) object: f64,
}

/// By part of a cell: the logarithm of the probability that an object there was missed.
#[derive(Clone, Debug, Default, PartialEq)]
struct Missed {
    /// Before this observation.
    before: [f32; PARTS],
    /// And in it.
    now: [f32; PARTS],
}

impl Missed {
    #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a probability")]
    fn note(&mut self, part: usize, missed: f64) {
        let sum = self.now[part] + missed.max(1e-6).ln() as f32;
        self.now[part] = sum.max(LEAST_MISSED_IN_AN_OBSERVATION.ln());
    }

    fn settle(&mut self) {
        for (before, now) in self.before.iter_mut().zip(&mut self.now) {
            *before += std::mem::take(now);
        }
    }
}

impl Accounts {
    /// Adds one frame: parts of cells in view without a wall in between, up to one cell farther than the sensor's
    /// radius, since an observation ends in the next cell. Walls are those of the terrain, which fill cells, and those of the
    /// vehicle's own map, if it has one, which may be thinner. A camera that is not over the map adds nothing. A near object is
    /// missed with this probability.
    pub fn add(
        &mut self,
        terrain: &Terrain,
        walls: Option<&CostMap>,
        sensor: &Sensor,
        view: &View,
        miss_probability: f64,
    ) {
        let camera_meters = view.camera().position_meters();
        let Some(from) = spread::cell_at(terrain, camera_meters) else { return };
        let half_diagonal = terrain.cell_meters() / std::f64::consts::SQRT_2;
        for offset in Offset::within(sensor.radius() + 1) {
            let Some(cell) = terrain.grid().step(from, offset) else { continue };
            let (east, north) = terrain.center_meters(cell);
            let middle = Vector2::new(east, north);
            let is_far = (middle - camera_meters).norm() > view.max_range_meters() + half_diagonal;
            if is_far || !terrain.is_searched(cell) || self.cells.get(&cell).is_some_and(Account::is_seen) {
                continue;
            }
            if !is_clear(terrain.grid(), from, offset, |cell| terrain.is_wall(cell)) {
                continue;
            }
            for (part, point) in parts(middle, terrain.cell_meters()).enumerate() {
                if view.shows_ground(point) {
                    let range_meters = (point - camera_meters).norm();
                    let missed = missed(range_meters / view.max_range_meters(), miss_probability);
                    let account = self.of(cell);
                    account.missed_in_view.note(part, missed);
                    if !walls.is_some_and(|walls| walls.hides(pair(camera_meters), pair(point))) {
                        account.note(part, missed, offset.manhattan());
                    }
                }
            }
        }
    }

    /// Probability that an object at a position, meters east and north, would have been missed so far, if no wall of the
    /// vehicle's own map had hidden it.
    #[must_use]
    pub fn missed_at(&self, terrain: &Terrain, point_meters: Vector2<f64>) -> f64 {
        let Some(cell) = spread::cell_at(terrain, point_meters) else { return 1.0 };
        let Some(account) = self.cells.get(&cell) else { return 1.0 };
        let (east, north) = terrain.center_meters(cell);
        let step = terrain.cell_meters() / f64::from(SIDE);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within a cell")]
        let index = |offset: f64| {
            let index = ((offset + terrain.cell_meters() / 2.0) / step).floor();
            index.clamp(0.0, f64::from(SIDE - 1)) as usize
        };
        let part = index(point_meters.y - north) * SIDE as usize + index(point_meters.x - east);
        f64::from(account.missed_in_view.before[part] + account.missed_in_view.now[part]).exp()
    }

    /// The account of a cell.
    pub(super) fn of(&mut self, cell: Cell) -> &mut Account {
        self.cells.entry(cell).or_default()
    }

    /// Cells with an account.
    pub(super) fn cells(&self) -> Vec<Cell> {
        self.cells.keys().copied().collect()
    }

    /// Whether a cell was in view, or published.
    pub(super) fn has(&self, cell: Cell) -> bool {
        self.cells.contains_key(&cell)
    }

    /// Published evidence of an object in a cell, nats.
    pub(super) fn object_nats(&self, cell: Cell) -> f64 {
        self.cells.get(&cell).map_or(0.0, |account| account.object)
    }

    /// Published evidence of a cell's being empty, nats.
    pub(super) fn empty_nats(&self, cell: Cell) -> f64 {
        self.cells.get(&cell).map_or(0.0, |account| account.empty)
    }

    /// The parts of a cell that were observed; none while it may hold an object, since that has to be looked at again.
    pub(super) fn observed_parts(&self, cell: Cell) -> Parts {
        let Some(account) = self.cells.get(&cell).filter(|account| account.empty > 0.0) else {
            return NO_PART;
        };
        let missed = account.missed.before.iter().enumerate();
        let observed = missed.filter(|&(_, &missed)| missed <= OBSERVED.ln());
        observed.fold(NO_PART, |observed, (part, _)| observed | 1 << part)
    }

    /// Number of cells with an account.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }
}

impl Default for Account {
    fn default() -> Self {
        let (missed, missed_in_view) = (Missed::default(), Missed::default());
        Self { missed, missed_in_view, nearest: u32::MAX, untold: 0.0, empty: 0.0, object: 0.0 }
    }
}

impl Account {
    /// Whether further frames of this observation add nothing.
    fn is_seen(&self) -> bool {
        let least = LEAST_MISSED_IN_AN_OBSERVATION.ln();
        self.missed.now.iter().all(|&missed| missed <= least)
    }

    fn note(&mut self, part: usize, missed: f64, distance: u32) {
        self.missed.note(part, missed);
        self.nearest = self.nearest.min(distance);
    }

    /// Nothing was found here in this observation: it counts.
    pub(super) fn settle(&mut self) {
        self.missed.settle();
        self.missed_in_view.settle();
    }

    /// An object may be here: the frames of this observation are discarded.
    pub(super) fn discard(&mut self) {
        self.missed.now = [0.0; PARTS];
        self.missed_in_view.now = [0.0; PARTS];
        self.nearest = u32::MAX;
    }

    /// The least distance of its last frames, cells, if there are any since its last reading.
    pub(super) fn nearest(&self) -> Option<u32> {
        (self.nearest < u32::MAX).then_some(self.nearest)
    }

    /// The unpublished growth of its evidence of being empty.
    pub(super) fn growth(&self) -> f64 {
        let sum: f64 = self.missed.before.iter().map(|&missed| f64::from(missed).exp()).sum();
        let empty = -(sum / PARTS as f64).max(f64::MIN_POSITIVE).ln();
        empty - self.empty - self.untold
    }

    /// Marks a part of the growth as published; the rest was collected from too far away.
    pub(super) fn publish_empty(&mut self, reported: f64) {
        self.untold += (self.growth() - reported).max(0.0);
        self.empty += reported;
        self.nearest = u32::MAX;
    }

    /// Marks evidence of being empty as withdrawn, since an object may be here. It counts again if the object turns out to be
    /// elsewhere; but where tracks begin does not depend on it.
    pub(super) fn withdraw_empty(&mut self, reported: f64) {
        self.empty = (self.empty - reported).max(0.0);
        self.missed_in_view.before = [0.0; PARTS];
    }

    /// Marks evidence of an object as published: it first withdraws the evidence of being empty.
    pub(super) fn publish_object(&mut self, reported: f64) {
        let back = reported.min(self.empty);
        self.empty -= back;
        self.object += reported - back;
        if self.empty <= 0.0 {
            (self.missed.before, self.missed_in_view.before) = ([0.0; PARTS], [0.0; PARTS]);
            (self.untold, self.empty) = (0.0, 0.0);
        }
    }
}

/// Probability that an object at a share of the detector's range is missed in a frame.
fn missed(range_share: f64, miss_probability: f64) -> f64 {
    let beyond = ((range_share - SURE_SHARE) / (1.0 - SURE_SHARE)).clamp(0.0, 1.0);
    1.0 - (1.0 - miss_probability) * (1.0 - beyond * (1.0 - SHARE_AT_THE_END))
}

pub(super) fn pair(point: Vector2<f64>) -> (f64, f64) {
    (point.x, point.y)
}

/// The centers of a cell's parts.
pub(super) fn parts(middle: Vector2<f64>, cell_meters: f64) -> impl Iterator<Item = Vector2<f64>> {
    let step = cell_meters / f64::from(SIDE);
    let at = move |index: u32| (f64::from(index) + 0.5) * step - cell_meters / 2.0;
    (0..SIDE).flat_map(move |row| (0..SIDE).map(move |column| middle + Vector2::new(at(column), at(row))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_out_of_view_bound_the_evidence() {
        let mut account = Account::default();
        for _ in 0..50 {
            (0..PARTS - 1).for_each(|part| (0..40).for_each(|_| account.note(part, 0.2, 1)));
            account.settle();
        }
        assert!((account.growth() - 16.0_f64.ln()).abs() < 1e-6, "{}", account.growth());
        account.publish_empty(2.0);
        assert!(account.growth().abs() < 1e-9, "the rest was too far away");
    }

    #[test]
    fn one_observation_gives_no_more_than_a_thousand_to_one() {
        let mut account = Account::default();
        (0..PARTS).for_each(|part| (0..400).for_each(|_| account.note(part, 0.2, 1)));
        assert!(account.is_seen());
        account.settle();
        assert!((account.growth() - 1000.0_f64.ln()).abs() < 1e-3);
    }

    #[test]
    fn evidence_of_emptiness_is_withdrawn_first() {
        let mut account = Account::default();
        (0..PARTS).for_each(|part| account.note(part, 0.1, 1));
        account.settle();
        account.publish_empty(account.growth());
        let empty = account.empty;
        assert!((empty - 10.0_f64.ln()).abs() < 1e-6);
        account.publish_object(1.0);
        assert!((account.empty - (empty - 1.0)).abs() < 1e-12 && account.object == 0.0);
        account.publish_object(empty);
        assert!(account.empty == 0.0 && (account.object - 1.0).abs() < 1e-12);
        assert!(account.growth().abs() < 1e-12, "it was not seen to be empty after all");
    }

    #[test]
    fn far_away_more_is_missed() {
        let shares = [0.1, 0.5, 0.75, 1.0].map(|share| missed(share, 0.2));
        assert!((shares[0] - 0.2).abs() < 1e-12 && (shares[1] - 0.2).abs() < 1e-12);
        assert!((shares[2] - 0.56).abs() < 1e-9 && (shares[3] - 0.92).abs() < 1e-9, "{shares:?}");
    }
}
