//! From tracks and a look to readings for the belief of the search.
//!
//! A look lasts from one cell to the next ([`readings`]), and all frames of the way count ([`account`]). A cell is read if
//! the sensor's footprint has it from where the vehicle stands at the end and an object can be in it. Readings
//! of a cell add up in the belief, so a look tells how much more is known than was told before:
//! - **0, empty**, where no track can be ([`finds::NEGLIGIBLE`]): with as much evidence as frames have shown
//!   by now, of the parts of the cell that were in view;
//! - **1, an object**, where a track has its cell ([`finds`]): [`OBJECT_NATS`] for all looks together;
//! - **one half** ([`Reading::undecided`]), which is no evidence, where a confirmed track may be that has no cell
//!   yet: the agent does not rest while its last look has one. What was told of such a cell's being empty is
//!   taken back, and nothing that is seen meanwhile counts for it;
//! - **no reading** where a tentative track may be, which may be a detector's mistake; what was seen there
//!   counts when that is known.
//!
//! A vehicle that stands still tells again, in between, of objects alone ([`objects`]).
//!
//! A reading is never more precise than the sensor's own model, `value = theta + N(0, v(d))`: `d` is the
//! distance from where the vehicle stands, or from where the cell was seen, whichever is larger.
//!
//! Limits. Robots add up what each of them has told: two that track one thing on a border may tell it in both
//! cells. A cell's account ends when the pilot's memory does, after a jump of its pose or a restart.

pub mod account;
pub mod finds;
mod sight;
pub mod spread;

use dragnet_search::cell::{Cell, Position};
use dragnet_search::evidence::{MAX_VARIANCE, Reading};
use dragnet_search::sensor::{FootprintCell, Sensor};
use dragnet_search::terrain::Terrain;

use account::Accounts;
use dragnet_lattice::plane::Pose;
use finds::Finds;

/// What is told of a cell with an object in it, all looks together, nats: more than any prior asks for, and no
/// more than some teammates' looks that find nothing can outweigh.
pub const OBJECT_NATS: f64 = 20.0;
/// Less is not worth a reading, nats.
const LEAST_NATS: f64 = 0.02;
/// So probable a confirmed track without a cell takes back what was told of a cell's being empty.
const TAKE_BACK: f64 = 0.02;

/// What a look has shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The cell that the vehicle stands in.
    pub from: Cell,
    /// Each cell at most once.
    pub readings: Vec<Reading>,
}

impl Seen {
    /// Whether it leaves a cell undecided.
    #[must_use]
    pub fn has_undecided(&self) -> bool {
        self.readings.iter().any(Reading::is_undecided)
    }

    /// Whether it says more than in which cells something may be.
    #[must_use]
    pub fn is_evidence(&self) -> bool {
        !self.readings.iter().all(Reading::is_undecided)
    }
}

/// Why a look shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EvidenceError {
    /// Where the vehicle is was not told.
    #[error("the vehicle's pose is not a number: {0:?}")]
    Pose(Pose),
    /// Its place is wrong, or the map is another.
    #[error(
        "the vehicle is {east} m east, {north} m north of the map's corner: the map has {width} m, {height} m"
    )]
    OutsideMap {
        /// As given, meters.
        east: f64,
        /// As given, meters.
        north: f64,
        /// Of the map, meters.
        width: f64,
        /// Of the map, meters.
        height: f64,
    },
    /// Its place is wrong, or the map is: the team would not believe what is seen from there.
    #[error("the vehicle stands in row {}, column {}, where the map lets none stand", .0.row, .0.column)]
    Blocked(Position),
}

/// Ends a look: its readings from where the vehicle stands, which count as told.
///
/// # Errors
/// If the vehicle's pose is no number, or it stands outside of the map or where none can.
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

/// What is to be told of objects, and where some are undecided, from a vehicle that still stands in the cell of the look
/// before. It ends no look: what was seen of cells' being empty goes on to count as one, however often this is asked.
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

/// Whether a confirmed track is in a cell, or may be.
fn is_taken(cell: Cell, finds: &Finds) -> bool {
    finds.open.contains_key(&cell) || finds.in_cell(cell).is_some()
}

/// What was seen of each cell in this look counts, means nothing, or waits.
fn close(finds: &Finds, accounts: &mut Accounts) {
    for cell in accounts.cells() {
        if is_taken(cell, finds) {
            accounts.of(cell).discard();
        } else if !finds.doubtful.contains(&cell) {
            accounts.of(cell).settle();
        }
    }
}

/// The reading of a cell where no track is undecided, if there is something to tell.
fn read(
    cell: Cell,
    sensor: &Sensor,
    place: &FootprintCell,
    finds: &mut Finds,
    accounts: &mut Accounts,
) -> Option<Reading> {
    read_object(cell, place, finds, accounts).or_else(|| read_empty(cell, sensor, place, finds, accounts))
}

/// That an object is in a cell, or that one has left it.
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
        account.tell_object(told_nats);
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

/// That a cell is empty where no track may be.
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
    account.tell_empty(told_nats);
    Some(reading)
}

/// A reading that tells so much, or as much of it as its variance allows, and how much that is, nats:
/// `|2 y - 1| / (2 v)`.
fn reading(cell: Cell, value: f32, nats: f64, least_variance: f32) -> Option<(Reading, f64)> {
    if nats < LEAST_NATS {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "readings travel as f32")]
    let variance = ((1.0 / (2.0 * nats)) as f32).max(least_variance).min(MAX_VARIANCE);
    Some((Reading { cell, value, variance }, 1.0 / (2.0 * f64::from(variance))))
}

/// Adds the cells where a track is undecided: all but one are free for what was told of their being empty to be
/// taken back, which is a reading too.
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
    for (index, &(cell, probability, variance)) in open.iter().enumerate() {
        let account = accounts.of(cell);
        let told = if index > 0 && probability >= TAKE_BACK { account.empty } else { 0.0 };
        match reading(cell, 1.0, told, variance) {
            Some((reading, told_nats)) => {
                account.tell_object(told_nats);
                readings.push(reading);
            }
            None => readings.push(Reading::undecided(cell)),
        }
    }
    readings
}

/// The cell that a vehicle stands in.
///
/// # Errors
/// If its pose is no number, or it stands outside of the map or where none can.
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
