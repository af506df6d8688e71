//! What a robot's cameras have shown of a cell, and what the robot has told of it: an account for each cell.
//!
//! A cell is cut into `PARTS` parts. In each frame whose view holds a part, a thing that lies there would have
//! been missed with a probability; what all frames together leave is the probability that it was missed so far.
//! If nothing was found, the cell's evidence of being empty is `-ln(mean over its parts)`: a cell of which a
//! tenth was never in view is never emptier than `ln 10`, however often the rest was seen.
//!
//! Evidence adds up over all readings of a cell, and the frames of a robot are one experience. So a robot tells
//! what its evidence has grown by since it told of the cell last, and takes back what has turned out not to be.

use std::collections::BTreeMap;

use dragnet_search::cell::{Cell, Offset};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;
use nalgebra::Vector2;

use super::{sight, spread};
use crate::camera::View;

/// A cell is cut into so many parts to each side.
const SIDE: u32 = 4;
/// Parts of a cell.
const PARTS: usize = (SIDE * SIDE) as usize;
/// However many frames of one look hold a part, a thing there was missed in all of them with at least this
/// probability: whatever hides it hides it in all.
const LEAST_MISSED_IN_A_LOOK: f32 = 1e-3;
/// Of the detector's range, to here a thing is missed as seldom as the settings say,
const SURE_SHARE: f64 = 0.5;
/// and at its end it is found with this share of the probability.
const SHARE_AT_THE_END: f64 = 0.1;

/// The accounts of all cells that were in view or told of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accounts {
    cells: BTreeMap<Cell, Account>,
}

/// Of one cell. All but the distance are nats.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Account {
    /// By part: the logarithm of the probability that a thing there was missed before this look.
    missed: [f32; PARTS],
    /// And in this look.
    missed_now: [f32; PARTS],
    /// Manhattan distance of the nearest camera in this look, cells.
    nearest: u32,
    /// Evidence of being empty that was seen from too far away to be told.
    untold: f64,
    /// Told of its being empty, at least 0.
    pub(super) empty: f64,
    /// Told of an object in it, at least 0.
    pub(super) object: f64,
}

impl Accounts {
    /// Takes in what one frame could see: parts of cells in view with no wall between, up to one cell farther
    /// than the sensor's radius, since a look ends in the next cell. A camera that is not over the map shows
    /// nothing. A thing at hand is missed with this probability.
    pub fn add(&mut self, terrain: &Terrain, sensor: &Sensor, view: &View, miss_probability: f64) {
        let camera_meters = view.camera().position_meters();
        let Some(from) = spread::cell_at(terrain, camera_meters) else { return };
        let half_diagonal = terrain.cell_meters() / std::f64::consts::SQRT_2;
        for offset in offsets(sensor.radius() + 1) {
            let Some(cell) = terrain.grid().step(from, offset) else { continue };
            let (east, north) = terrain.center_meters(cell);
            let middle = Vector2::new(east, north);
            let is_far = (middle - camera_meters).norm() > view.max_range_meters() + half_diagonal;
            if is_far || !terrain.is_searched(cell) || self.cells.get(&cell).is_some_and(Account::is_seen) {
                continue;
            }
            if !sight::is_clear(terrain, from, offset) {
                continue;
            }
            for (part, point) in parts(middle, terrain.cell_meters()).enumerate() {
                if view.shows_ground(point) {
                    let range_meters = (point - camera_meters).norm();
                    let missed = missed(range_meters / view.max_range_meters(), miss_probability);
                    self.of(cell).note(part, missed, offset.manhattan());
                }
            }
        }
    }

    /// Probability that a thing at a place, meters east and north, would have been missed by now.
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
        f64::from(account.missed[part] + account.missed_now[part]).exp()
    }

    /// The account of a cell.
    pub(super) fn of(&mut self, cell: Cell) -> &mut Account {
        self.cells.entry(cell).or_default()
    }

    /// Cells with an account.
    pub(super) fn cells(&self) -> Vec<Cell> {
        self.cells.keys().copied().collect()
    }

    /// Whether a cell was in view, or told of.
    pub(super) fn has(&self, cell: Cell) -> bool {
        self.cells.contains_key(&cell)
    }

    /// Cells with an account.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }
}

impl Default for Account {
    fn default() -> Self {
        let (missed, missed_now) = ([0.0; PARTS], [0.0; PARTS]);
        Self { missed, missed_now, nearest: u32::MAX, untold: 0.0, empty: 0.0, object: 0.0 }
    }
}

impl Account {
    /// Whether one look can show no more of it.
    fn is_seen(&self) -> bool {
        let least = LEAST_MISSED_IN_A_LOOK.ln();
        self.missed_now.iter().all(|&missed| missed <= least)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a logarithm of a probability")]
    fn note(&mut self, part: usize, missed: f64, distance: u32) {
        let sum = self.missed_now[part] + missed.max(1e-6).ln() as f32;
        self.missed_now[part] = sum.max(LEAST_MISSED_IN_A_LOOK.ln());
        self.nearest = self.nearest.min(distance);
    }

    /// Nothing was found here in this look: it counts.
    pub(super) fn settle(&mut self) {
        for (before, now) in self.missed.iter_mut().zip(&mut self.missed_now) {
            *before += std::mem::take(now);
        }
    }

    /// Something may be here: what was not seen of it in this look means nothing.
    pub(super) fn discard(&mut self) {
        self.missed_now = [0.0; PARTS];
        self.nearest = u32::MAX;
    }

    /// From how near it was seen last, cells, if it was seen since it was told of.
    pub(super) fn nearest(&self) -> Option<u32> {
        (self.nearest < u32::MAX).then_some(self.nearest)
    }

    /// How much emptier it is than was told.
    pub(super) fn growth(&self) -> f64 {
        let sum: f64 = self.missed.iter().map(|&missed| f64::from(missed).exp()).sum();
        let empty = -(sum / PARTS as f64).max(f64::MIN_POSITIVE).ln();
        empty - self.empty - self.untold
    }

    /// Some of its growth was told, and the rest was seen from too far away.
    pub(super) fn tell_empty(&mut self, told: f64) {
        self.untold += (self.growth() - told).max(0.0);
        self.empty += told;
        self.nearest = u32::MAX;
    }

    /// It was told that an object is here: first what was told of its being empty is taken back.
    pub(super) fn tell_object(&mut self, told: f64) {
        let back = told.min(self.empty);
        self.empty -= back;
        self.object += told - back;
        if self.empty <= 0.0 {
            (self.missed, self.untold, self.empty) = ([0.0; PARTS], 0.0, 0.0);
        }
    }
}

/// Probability that a thing is missed in a frame at a share of the detector's range.
fn missed(range_share: f64, miss_probability: f64) -> f64 {
    let beyond = ((range_share - SURE_SHARE) / (1.0 - SURE_SHARE)).clamp(0.0, 1.0);
    1.0 - (1.0 - miss_probability) * (1.0 - beyond * (1.0 - SHARE_AT_THE_END))
}

/// The middles of a cell's parts.
fn parts(middle: Vector2<f64>, cell_meters: f64) -> impl Iterator<Item = Vector2<f64>> {
    let step = cell_meters / f64::from(SIDE);
    let at = move |index: u32| (f64::from(index) + 0.5) * step - cell_meters / 2.0;
    (0..SIDE).flat_map(move |row| (0..SIDE).map(move |column| middle + Vector2::new(at(column), at(row))))
}

/// All offsets of at most this Manhattan length, cells.
fn offsets(reach: u32) -> impl Iterator<Item = Offset> {
    let reach = reach.cast_signed();
    (-reach..=reach).flat_map(move |north| {
        let span = reach - north.abs();
        (-span..=span).map(move |east| Offset { north, east })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_never_in_view_bounds_what_can_be_told() {
        let mut account = Account::default();
        for _ in 0..50 {
            (0..PARTS - 1).for_each(|part| (0..40).for_each(|_| account.note(part, 0.2, 1)));
            account.settle();
        }
        assert!((account.growth() - 16.0_f64.ln()).abs() < 1e-6, "{}", account.growth());
        account.tell_empty(2.0);
        assert!(account.growth().abs() < 1e-9, "the rest was too far away");
    }

    #[test]
    fn one_look_tells_no_more_than_a_thousand_to_one() {
        let mut account = Account::default();
        (0..PARTS).for_each(|part| (0..400).for_each(|_| account.note(part, 0.2, 1)));
        assert!(account.is_seen());
        account.settle();
        assert!((account.growth() - 1000.0_f64.ln()).abs() < 1e-3);
    }

    #[test]
    fn what_was_told_of_emptiness_is_taken_back_first() {
        let mut account = Account::default();
        (0..PARTS).for_each(|part| account.note(part, 0.1, 1));
        account.settle();
        account.tell_empty(account.growth());
        let empty = account.empty;
        assert!((empty - 10.0_f64.ln()).abs() < 1e-6);
        account.tell_object(1.0);
        assert!((account.empty - (empty - 1.0)).abs() < 1e-12 && account.object == 0.0);
        account.tell_object(empty);
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
