//! Computes the readings of an observation from tracks and camera frames.
//!
//! An observation lasts from one cell of the route to the next ([`readings`]), and all frames in between count
//! ([`account`]). A cell is read if it is in the sensor's footprint around the vehicle's cell at the end, and an object
//! can be in it. Readings of a cell add up in the belief, so an observation contains only what is new since the last
//! one:
//! - **0, empty**, where no track can be ([`finds::NEGLIGIBLE`]): with the evidence of all frames so far, over the
//!   parts of the cell that were in view;
//! - **1, an object**, where a track is assigned to the cell ([`finds`]): [`OBJECT_NATS`] over all observations;
//! - **one half** ([`Reading::undecided`]), which is no evidence, where a confirmed track is likely that is not assigned to a
//!   cell yet: agents come back to such a cell. Earlier evidence of its being empty is withdrawn, and frames do not count
//!   for it meanwhile;
//! - **no reading** where a tentative track may be, which may be a false alarm; its frames count when that is known.
//!
//! A vehicle that stands still publishes further observations, of objects only ([`objects`]), and so does one that enters the
//! next cell, of what is out of its sight there.
//!
//! A reading is never more precise than the sensor model, `value = theta + N(0, v(d))`: `d` is the distance from the
//! vehicle's cell, or from where the cell was observed, whichever is larger.
//!
//! Limits. Robots add up the readings of each of them: two that track one object on a border may report it in both
//! cells. A cell's account ends with the pilot's memory, after a jump of its pose or a restart.

pub mod account;
pub mod finds;
pub(crate) mod sight;
pub mod spread;
pub mod vista;

use std::collections::BTreeSet;

use dragnet_search::cell::{Cell, Position};
use dragnet_search::evidence::{MAX_VARIANCE, Reading};
use dragnet_search::sensor::{FootprintCell, Sensor};
use dragnet_search::terrain::Terrain;

use account::Accounts;
use dragnet_lattice::plane::Pose;
use finds::Finds;

/// Total evidence of a cell with an object, nats: more than any prior requires, and less than several teammates' empty
/// observations can outweigh.
pub const OBJECT_NATS: f64 = 20.0;
/// Smaller evidence is not published, nats.
const LEAST_NATS: f64 = 0.02;
/// Published evidence of a cell's being empty with which nobody looks into it again, nats.
const DOUBTED_NATS: f64 = 1.0;
/// Probability of a confirmed unassigned track from which its cell is undecided; the likeliest one is in any case.
const LIKELY: f64 = 0.02;

/// The readings of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The vehicle's cell.
    pub from: Cell,
    /// Each cell at most once.
    pub readings: Vec<Reading>,
}

impl Seen {
    /// Whether it contains undecided readings.
    #[must_use]
    pub fn has_undecided(&self) -> bool {
        self.readings.iter().any(Reading::is_undecided)
    }

    /// Whether it contains more than undecided readings.
    #[must_use]
    pub fn is_evidence(&self) -> bool {
        !self.readings.iter().all(Reading::is_undecided)
    }
}

/// Why there are no readings.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EvidenceError {
    /// The vehicle's pose is not finite.
    #[error("the vehicle's pose is not a number: {0:?}")]
    Pose(Pose),
    /// The position is wrong, or the map is a different one.
    #[error(
        "the vehicle is {east} m east, {north} m north of the map's corner: the map has {width} m, {height} m"
    )]
    OutsideMap {
        /// The given value, meters.
        east: f64,
        /// The given value, meters.
        north: f64,
        /// Of the map, meters.
        width: f64,
        /// Of the map, meters.
        height: f64,
    },
    /// The cell is not traversable: the position or the map is wrong, and the team would reject the observation.
    #[error("the vehicle stands in row {}, column {}, where the map lets none stand", .0.row, .0.column)]
    Blocked(Position),
}

/// Ends an observation: returns its readings from the vehicle's position, which count as published.
///
/// # Errors
/// If the vehicle's pose is not finite, or it is outside of the map or in a cell that is not traversable.
pub fn readings(
    terrain: &Terrain,
    sensor: &Sensor,
    vehicle: &Pose,
    finds: &mut Finds,
    accounts: &mut Accounts,
) -> Result<Seen, EvidenceError> {
    let from = standing_cell(terrain, vehicle)?;
    close(finds, accounts);
    let mut readings = Vec::new();
    for place in sensor.footprint() {
        let Some(cell) = terrain.grid().step(from, place.offset).filter(|&cell| terrain.is_searched(cell))
        else {
            continue;
        };
        readings.extend(read(cell, sensor, place, finds, accounts));
    }
    Ok(Seen { from, readings: undecided(readings, terrain, sensor, from, finds, accounts) })
}

/// New readings of objects and of undecided cells, for a vehicle that still stands in the cell of the last observation.
/// It does not end an observation: frames of empty cells continue to count as one, however often this is called.
pub fn objects(
    terrain: &Terrain,
    sensor: &Sensor,
    from: Cell,
    finds: &mut Finds,
    accounts: &mut Accounts,
) -> Seen {
    for cell in accounts.cells() {
        if is_taken(cell, finds) {
            accounts.of(cell).discard();
        }
    }
    let mut readings = Vec::new();
    for place in sensor.footprint() {
        let cell = terrain.grid().step(from, place.offset).filter(|&cell| terrain.is_searched(cell));
        readings.extend(cell.and_then(|cell| read_object(cell, place, finds, accounts)));
    }
    Seen { from, readings: undecided(readings, terrain, sensor, from, finds, accounts) }
}

/// Cells with a find that is not fully published, and those of confirmed tracks that are not assigned to a cell.
pub fn unpublished<'a>(finds: &'a Finds, accounts: &'a Accounts) -> impl Iterator<Item = Cell> + 'a {
    let is_unpublished = |cell: &Cell| OBJECT_NATS - accounts.object_nats(*cell) >= LEAST_NATS;
    let found = finds.iter().map(|find| find.cell).filter(is_unpublished);
    found.chain(finds.open.iter().filter(|&(_, &probability)| probability >= LIKELY).map(|(&cell, _)| cell))
}

/// Whether this robot has published that an object is in a cell.
pub(crate) fn is_published(cell: Cell, accounts: &Accounts) -> bool {
    accounts.object_nats(cell) >= LEAST_NATS
}

/// Cells that this robot has published to be empty, that it does not read from a cell, and in which an object is or may be after
/// all: the robot has to come back to them.
pub(crate) fn doubted(
    terrain: &Terrain,
    sensor: &Sensor,
    from: Cell,
    finds: &Finds,
    accounts: &Accounts,
) -> BTreeSet<Cell> {
    let is_doubted = |&cell: &Cell| {
        is_out_of_sight(terrain, sensor, from, cell) && accounts.empty_nats(cell) >= DOUBTED_NATS
    };
    unpublished(finds, accounts).filter(is_doubted).collect()
}

/// Whether a vehicle in a cell reads nothing of another one.
pub(crate) fn is_out_of_sight(terrain: &Terrain, sensor: &Sensor, from: Cell, cell: Cell) -> bool {
    terrain.grid().manhattan(from, cell) > sensor.radius()
}

/// Whether a confirmed track is assigned to a cell, or may be in it.
fn is_taken(cell: Cell, finds: &Finds) -> bool {
    finds.open.contains_key(&cell) || finds.in_cell(cell).is_some()
}

/// The frames of each cell in this observation count, are discarded, or wait.
fn close(finds: &Finds, accounts: &mut Accounts) {
    for cell in accounts.cells() {
        if is_taken(cell, finds) {
            accounts.of(cell).discard();
        } else if !finds.doubtful.contains(&cell) {
            accounts.of(cell).settle();
        }
    }
}

/// The reading of a cell without an undecided track, if there is anything new.
fn read(
    cell: Cell,
    sensor: &Sensor,
    place: &FootprintCell,
    finds: &mut Finds,
    accounts: &mut Accounts,
) -> Option<Reading> {
    read_object(cell, place, finds, accounts).or_else(|| read_empty(cell, sensor, place, finds, accounts))
}

/// The reading that an object is in a cell, or has left it.
fn read_object(
    cell: Cell,
    place: &FootprintCell,
    finds: &mut Finds,
    accounts: &mut Accounts,
) -> Option<Reading> {
    if finds.in_cell(cell).is_some() {
        let account = accounts.of(cell);
        let missing_nats = (OBJECT_NATS - account.object).max(0.0) + account.empty;
        let (reading, told_nats) = reading(cell, 1.0, missing_nats, place.variance)?;
        account.publish_object(told_nats);
        return Some(reading);
    }
    if finds.open.contains_key(&cell) || !finds.left.contains(&cell) || !accounts.has(cell) {
        return None;
    }
    let account = accounts.of(cell);
    let (reading, told_nats) = reading(cell, 0.0, account.object, place.variance)?;
    account.object = (account.object - told_nats).max(0.0);
    if account.object < LEAST_NATS {
        finds.left.remove(&cell);
    }
    Some(reading)
}

/// The reading that a cell is empty where no track may be.
fn read_empty(
    cell: Cell,
    sensor: &Sensor,
    place: &FootprintCell,
    finds: &Finds,
    accounts: &mut Accounts,
) -> Option<Reading> {
    if is_taken(cell, finds) || finds.doubtful.contains(&cell) || !accounts.has(cell) {
        return None;
    }
    let account = accounts.of(cell);
    let seen_from = account.nearest().map_or(place.variance, |distance| sensor.variance(distance));
    let (reading, told_nats) = reading(cell, 0.0, account.growth(), place.variance.max(seen_from))?;
    account.publish_empty(told_nats);
    Some(reading)
}

/// A reading with this evidence, or as much of it as the variance allows, and that evidence, nats: `|2 y - 1| / (2 v)`.
fn reading(cell: Cell, value: f32, nats: f64, least_variance: f32) -> Option<(Reading, f64)> {
    if nats < LEAST_NATS {
        return None;
    }
    let exact = Reading::with_nats(cell, value, nats);
    let variance = exact.variance.max(least_variance).min(MAX_VARIANCE);
    Some((Reading { variance, ..exact }, 1.0 / (2.0 * f64::from(variance))))
}

/// Adds undecided readings of the cells where an unassigned track may be. Withdrawing earlier evidence of a cell's
/// being empty is a reading too: one cell keeps it, as long as no other is undecided.
fn undecided(
    mut readings: Vec<Reading>,
    terrain: &Terrain,
    sensor: &Sensor,
    from: Cell,
    finds: &Finds,
    accounts: &mut Accounts,
) -> Vec<Reading> {
    let open = |place: &FootprintCell| {
        let cell = terrain.grid().step(from, place.offset)?;
        let probability = *finds.open.get(&cell)?;
        let is_told = accounts.of(cell).object > LEAST_NATS || finds.in_cell(cell).is_some();
        (!is_told).then_some((cell, probability, place.variance))
    };
    let mut open: Vec<(Cell, f64, f32)> = sensor.footprint().iter().filter_map(open).collect();
    open.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let least = open.last().map_or(0.0, |&(_, most, _)| LIKELY.min(most));
    open.retain(|&(_, probability, _)| probability >= least);
    let is_one_undecided = open.iter().any(|&(cell, ..)| accounts.of(cell).empty < LEAST_NATS);
    for (index, (cell, _, variance)) in open.into_iter().enumerate() {
        let account = accounts.of(cell);
        let reported = if index > 0 || is_one_undecided { account.empty } else { 0.0 };
        match reading(cell, 1.0, reported, variance) {
            Some((reading, told_nats)) => {
                account.withdraw_empty(told_nats);
                readings.push(reading);
            }
            None => readings.push(Reading::undecided(cell)),
        }
    }
    readings
}

/// The cell of a vehicle.
///
/// # Errors
/// If its pose is not finite, or it is outside of the map or in a cell that is not traversable.
pub fn standing_cell(terrain: &Terrain, vehicle: &Pose) -> Result<Cell, EvidenceError> {
    if !vehicle.is_finite() {
        return Err(EvidenceError::Pose(*vehicle));
    }
    let Some(cell) = spread::cell_at(terrain, vehicle.position_meters()) else {
        let (grid, edge) = (terrain.grid(), terrain.cell_meters());
        let (east, north) = (vehicle.x_meters, vehicle.y_meters);
        let (width, height) = (f64::from(grid.columns()) * edge, f64::from(grid.rows()) * edge);
        return Err(EvidenceError::OutsideMap { east, north, width, height });
    };
    if !terrain.is_traversable(cell) {
        return Err(EvidenceError::Blocked(terrain.grid().position(cell)));
    }
    Ok(cell)
}

#[cfg(test)]
mod tests;
