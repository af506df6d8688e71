//! Assigns tracks to cells.
//!
//! A confirmed track is assigned to a cell once it is nearly certain to be there. An object may lie on a border: once its
//! position is known well and will hardly improve, or the vehicle leaves, it is assigned to the likeliest cell. It keeps
//! that cell while it may be there. So an object is reported in one cell, with its position and error, and does not
//! alternate between two.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_search::cell::Cell;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;
use nalgebra::{Matrix2, Vector2};

use super::is_out_of_sight;
use super::spread::{cell_at, over_cells};
use crate::tracker::track::{Standing, Track, TrackId};
use crate::tracker::{largest_std_meters, seconds_between};

/// Probability of a track in a cell up to which the cell counts as empty.
pub const NEGLIGIBLE: f64 = 1e-3;
/// Probability from which a track is in a cell.
pub const CERTAIN: f64 = 0.99;
/// Score from which a track is reported as an object, nats.
const SURE_NATS: f64 = 20.0;
/// Probability below which a track has left its cell.
const LEFT: f64 = 0.01;
/// Standard deviation up to which a position is known well, meters,
const GOOD_METERS: f64 = 0.2;
/// or share of a cell once it will hardly improve: the track has not been detected for this time, seconds,
const PASSED_SHARE: f64 = 0.25;
const PASSED_SECONDS: f64 = 5.0;
/// its standard deviation is no more than this multiple of the part that no bearings reduce,
const FINAL_SHARE: f64 = 2.0;
/// or detections for this time, seconds, have not reduced it to this share.
const PATIENCE_SECONDS: f64 = 10.0;
const IMPROVED_SHARE: f64 = 0.9;
/// Distance in addition to the error, meters, up to which what lies outside of the search area is known already.
const OUTSIDE_METERS: f64 = 5.0;
/// Distance, in standard deviations of both, up to which two tracks are of the same object.
const SAME: f64 = 3.0;

/// A confirmed track that is assigned to a cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Find {
    /// Its track, which may be lost meanwhile.
    pub track: TrackId,
    /// The cell.
    pub cell: Cell,
    /// Expected position, meters east and north.
    pub position_meters: Vector2<f64>,
    /// Covariance of the position, square meters.
    pub position_covariance: Matrix2<f64>,
    /// Time of its last detection, nanoseconds of mission time.
    pub seen_ns: u64,
}

impl Find {
    /// Standard deviation of the position in its most uncertain direction, meters.
    #[must_use]
    pub fn std_meters(&self) -> f64 {
        largest_std_meters(&self.position_covariance)
    }

    /// Its position as the team learns it, unless that is not finite or too uncertain to be told.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a covariance needs no more digits")]
    pub fn position(&self) -> Option<ObjectPosition> {
        let covariance = &self.position_covariance;
        let covariance = [covariance.m11, covariance.m12, covariance.m22].map(|it| it as f32);
        ObjectPosition::new(self.cell, self.position_meters.into(), covariance)
    }
}

/// When and where tracks are assigned to cells.
#[derive(Clone, Copy, Debug)]
pub struct Vantage<'a> {
    /// Time of the latest frame, nanoseconds of mission time.
    pub now_ns: u64,
    /// The map.
    pub terrain: &'a Terrain,
    /// The sensor.
    pub sensor: &'a Sensor,
    /// The vehicle's cell.
    pub from: Cell,
}

/// All finds, and cells of unassigned tracks.
#[derive(Clone, Debug, Default)]
pub struct Finds {
    by_track: BTreeMap<TrackId, Find>,
    /// Cells in which confirmed unassigned tracks may be, with the probability that one is.
    pub(super) open: BTreeMap<Cell, f64>,
    /// Cells in which tentative tracks may be.
    pub(super) doubtful: BTreeSet<Cell>,
    /// Cells that finds have left and for which this was not published yet.
    pub(super) left: BTreeSet<Cell>,
    /// Cells in which the team has declared objects.
    declared: BTreeSet<Cell>,
    /// Of each confirmed track, its standard deviation when it last became clearly smaller, meters, and the time of its
    /// last detection then.
    improved: BTreeMap<TrackId, (f64, u64)>,
    /// Positions of objects outside of the search area, meters.
    outside: Vec<Vector2<f64>>,
    /// Number of them that were told.
    told_outside: usize,
}

impl Finds {
    /// All finds, the oldest track first.
    pub fn iter(&self) -> impl Iterator<Item = &Find> {
        self.by_track.values()
    }

    /// The find in a cell, the latest one if there are several.
    #[must_use]
    pub fn in_cell(&self, cell: Cell) -> Option<&Find> {
        self.by_track.values().filter(|find| find.cell == cell).max_by_key(|find| (find.seen_ns, find.track))
    }

    /// Replaces the cells in which the team has declared objects.
    pub fn set_declared(&mut self, cells: BTreeSet<Cell>) {
        self.declared = cells;
    }

    /// Removes all tracks and finds; keeps the cells that the team has declared, and what was found outside.
    pub fn restart(&mut self) {
        let Self { declared, outside, told_outside, .. } = std::mem::take(self);
        *self = Self { declared, outside, told_outside, ..Self::default() };
    }

    /// Updates the finds by the tracks.
    pub fn update(&mut self, tracks: &[Track], vantage: &Vantage<'_>) {
        let Vantage { now_ns, terrain, .. } = *vantage;
        self.open.clear();
        self.doubtful.clear();
        for track in tracks {
            let cells = over_cells(track, terrain);
            let likely = cells.iter().filter(|&(_, &probability)| probability > NEGLIGIBLE);
            if track.standing() == Standing::Tentative {
                self.doubtful.extend(likely.map(|(&cell, _)| cell));
                continue;
            }
            self.note_improvement(track);
            let before = self.by_track.get(&track.id()).map(|find| find.cell);
            let kept = before.filter(|cell| cells.get(cell).is_some_and(|&probability| probability >= LEFT));
            if let Some(cell) = kept.or_else(|| self.cell_of(track, &cells, tracks, vantage)) {
                self.place(track, cell, before, tracks);
                continue;
            }
            if let Some(cell) = before {
                self.by_track.remove(&track.id());
                self.left.insert(cell);
            }
            if is_elsewhere(&cells) && self.is_final(track, now_ns) {
                self.note_outside(track);
                continue;
            }
            for (&cell, &probability) in likely {
                let most = self.open.entry(cell).or_insert(0.0);
                *most = most.max(probability);
            }
        }
        let taken: BTreeSet<Cell> = self.by_track.values().map(|find| find.cell).collect();
        self.left.retain(|cell| !taken.contains(cell));
        self.improved.retain(|&id, _| tracks.iter().any(|track| track.id() == id));
    }

    fn note_improvement(&mut self, track: &Track) {
        let std_meters = track.std_meters();
        let (best_meters, seen_ns) = self.improved.entry(track.id()).or_insert((f64::INFINITY, 0));
        if std_meters < IMPROVED_SHARE * *best_meters {
            (*best_meters, *seen_ns) = (std_meters, track.seen_ns());
        }
    }

    fn note_outside(&mut self, track: &Track) {
        let (place, std_meters) = (track.position_meters(), track.std_meters());
        let is_known = |other: &Vector2<f64>| (other - place).norm() < OUTSIDE_METERS + SAME * std_meters;
        if track.score_nats() >= SURE_NATS && !self.outside.iter().any(is_known) {
            self.outside.push(place);
        }
    }

    /// Positions of objects that were found outside of the search area since the last call, meters east and north.
    pub(crate) fn take_outside(&mut self) -> &[Vector2<f64>] {
        let before = std::mem::replace(&mut self.told_outside, self.outside.len());
        &self.outside[before..]
    }

    /// Whether a track's position will hardly improve.
    fn is_final(&self, track: &Track, now_ns: u64) -> bool {
        let is_idle =
            |&(_, seen_ns): &(f64, u64)| seconds_between(seen_ns, track.seen_ns()) > PATIENCE_SECONDS;
        seconds_between(track.seen_ns(), now_ns) > PASSED_SECONDS
            || track.std_meters() <= final_meters(track)
            || self.improved.get(&track.id()).is_some_and(is_idle)
    }

    fn place(&mut self, track: &Track, cell: Cell, before: Option<Cell>, tracks: &[Track]) {
        let find = Find {
            track: track.id(),
            cell,
            position_meters: track.position_meters(),
            position_covariance: track.position_covariance(),
            seen_ns: track.seen_ns(),
        };
        // A new track may continue a lost one.
        let is_alive = |id: TrackId| tracks.iter().any(|track| track.id() == id);
        self.by_track.retain(|&id, find| find.cell != cell || is_alive(id));
        self.left.extend(before.filter(|&before| before != cell));
        self.by_track.insert(track.id(), find);
    }

    /// The cell to which a track can be assigned now, if any: the likeliest one, but on a border the one in which this
    /// robot or a teammate has declared the same object.
    fn cell_of(
        &self,
        track: &Track,
        cells: &BTreeMap<Cell, f64>,
        tracks: &[Track],
        vantage: &Vantage<'_>,
    ) -> Option<Cell> {
        let Vantage { now_ns, terrain, sensor, from } = *vantage;
        let (cell, probability) = likeliest(cells, |_, _| true)?;
        let std_meters = track.std_meters();
        // Cells may be smaller than the vehicle's own error: then no cell is better than the likeliest.
        let good_enough_meters =
            (PASSED_SHARE * terrain.cell_meters()).max(GOOD_METERS).max(final_meters(track));
        let is_last_chance = is_out_of_sight(terrain, sensor, from, cell) && std_meters <= GOOD_METERS;
        let is_known = probability >= CERTAIN
            || is_last_chance
            || (self.is_final(track, now_ns) && std_meters <= good_enough_meters);
        if !is_known || is_elsewhere(cells) || track.score_nats() < SURE_NATS {
            return None;
        }
        let covariance = track.position_covariance();
        let twin = self.by_track.values().find(|find| {
            let offset = find.position_meters - track.position_meters();
            let both = (find.position_covariance + covariance).cholesky();
            let is_same = both.is_some_and(|both| offset.dot(&both.solve(&offset)) < SAME * SAME);
            is_same && cells.get(&find.cell).is_some_and(|&probability| probability >= LEFT)
        });
        let declared =
            twin.map(|twin| twin.cell).or_else(|| self.teammates_cell(track, cells, tracks, terrain));
        Some(declared.unwrap_or(cell))
    }

    /// The cell in which a teammate has declared the object of a track, if any: the likeliest one where the track may be,
    /// unless another of this robot's tracks is there.
    fn teammates_cell(
        &self,
        track: &Track,
        cells: &BTreeMap<Cell, f64>,
        tracks: &[Track],
        terrain: &Terrain,
    ) -> Option<Cell> {
        let is_of_another = |cell: Cell| {
            let lies_there = |other: &Track| cell_at(terrain, other.position_meters()) == Some(cell);
            self.in_cell(cell).is_some()
                || tracks
                    .iter()
                    .any(|it| it.id() != track.id() && it.standing() == Standing::Confirmed && lies_there(it))
        };
        let is_shared = |cell: Cell, probability: f64| {
            probability >= LEFT && self.declared.contains(&cell) && !is_of_another(cell)
        };
        likeliest(cells, is_shared).map(|(cell, _)| cell)
    }
}

/// Standard deviation from which on a track's position hardly improves, meters.
fn final_meters(track: &Track) -> f64 {
    FINAL_SHARE * track.lasting_std_meters()
}

/// Whether an object is rather outside of the searched cells.
fn is_elsewhere(cells: &BTreeMap<Cell, f64>) -> bool {
    cells.values().sum::<f64>() < 0.5
}

/// The likeliest of the cells that are allowed, with its probability; of equal ones the first.
fn likeliest(cells: &BTreeMap<Cell, f64>, is_allowed: impl Fn(Cell, f64) -> bool) -> Option<(Cell, f64)> {
    let allowed = cells.iter().map(|(&cell, &probability)| (cell, probability));
    let allowed = allowed.filter(|&(cell, probability)| is_allowed(cell, probability));
    allowed.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}
