//! From tracks and a look to readings for the belief of the search.
//!
//! A look lasts from one cell to the next, and all frames of the way count ([`coverage`]). A cell is read if
//! the sensor's footprint has it from where the vehicle stands at the end, an object can be in it, and enough
//! frames had its middle in view with no wall between. Each reading is one of the sensor's own model,
//! `value = theta + N(0, v(d))`, and never more precise: `d` is the distance from where the vehicle stands,
//! or from where the cell was seen, whichever is larger.
//! - **0, empty**, where no track can be: its probability to be there is at most [`NEGLIGIBLE`];
//! - **1, an object**, where one confirmed track is that was seen in this look: with probability [`CERTAIN`]
//!   or more;
//! - **no reading** in between. There is something, but whether in this cell or the next is not known.
//!   Tentative tracks, and confirmed ones that were not seen in this look, can only withhold readings so.
//!
//! A track is in a cell with probability `m` ([`spread`]). That it may not be adds the variance of a coin,
//! `m (1 - m)`, to the sensor's.
//!
//! Limits. The belief takes the errors of all readings as independent, but those of a track's place last from
//! look to look: this is why a place that is not settled gives no reading at all, rather than a vague one
//! which many looks would add up to certainty. So a thing is told only when its track fits into a cell; until
//! then its cells stay as interesting as they were. What was told of a cell when its track was wrong is not
//! taken back; later looks outweigh it. And a detector that misses a thing without a track reads as often
//! wrongly 0 as the sensor's model says, not as the detector does: fit the model to the detector
//! ([`crate::calibration`]).

pub mod coverage;
mod sight;
pub mod spread;

use dragnet_search::cell::{Cell, Position};
use dragnet_search::evidence::{MAX_VARIANCE, Reading};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;

use crate::plane::Pose;
use crate::tracker::track::{Standing, Track};
use coverage::Coverage;
use spread::Spread;

/// With at most this probability of a track a cell reads as if the track were not there.
pub const NEGLIGIBLE: f64 = 1e-3;
/// With at least this probability a track is in a cell.
pub const CERTAIN: f64 = 0.9;

/// All that the cameras have shown since the last look.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Where the vehicle stands on the map.
    pub vehicle: Pose,
    /// What was in view on the way there.
    pub coverage: &'a Coverage,
    /// A cell that was in fewer frames is not read: as many as confirm a track, or nothing could have been
    /// found there.
    pub fewest_sights: u32,
    /// What it knows by then.
    pub tracks: &'a [Track],
    /// Tracks that were last seen before, nanoseconds of mission time, were not seen in this look: when the
    /// last one ended.
    pub since_ns: u64,
}

/// What a look has shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Seen {
    /// The cell that the vehicle stands in.
    pub from: Cell,
    /// In the order of the sensor's footprint, each cell at most once.
    pub readings: Vec<Reading>,
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
        /// As given, metres.
        east: f64,
        /// As given, metres.
        north: f64,
        /// Of the map, metres.
        width: f64,
        /// Of the map, metres.
        height: f64,
    },
    /// Its place is wrong, or the map is: the team would not believe what is seen from there.
    #[error("the vehicle stands in row {}, column {}, where the map lets none stand", .0.row, .0.column)]
    Blocked(Position),
}

/// The readings of a look.
///
/// # Errors
/// If the vehicle's pose is no number, or it stands outside of the map or where none can.
pub fn readings(terrain: &Terrain, sensor: &Sensor, look: &Look<'_>) -> Result<Seen, EvidenceError> {
    let from = standing_cell(terrain, &look.vehicle)?;
    let spread = Spread::of(look.tracks.iter().map(|track| (track.mixture(), is_seen(track, look))), terrain);
    let grid = terrain.grid();
    let reading = |place: &dragnet_search::sensor::Look| {
        let cell = grid.step(from, place.offset)?;
        let seen_from = look.coverage.distance(cell, look.fewest_sights)?;
        read(cell, place.variance.max(sensor.variance(seen_from)), &spread)
    };
    Ok(Seen { from, readings: sensor.footprint().iter().filter_map(reading).collect() })
}

/// Whether a track may be told as an object.
fn is_seen(track: &Track, look: &Look<'_>) -> bool {
    track.standing() == Standing::Confirmed && track.seen_ns() >= look.since_ns
}

fn read(cell: Cell, variance: f32, spread: &Spread) -> Option<Reading> {
    let seen = spread.most_of_one_seen(cell);
    let any = spread.of_any(cell);
    let (value, probability) = match () {
        () if seen >= CERTAIN => (1.0, seen),
        () if any <= NEGLIGIBLE => (0.0, any),
        () => return None,
    };
    #[expect(clippy::cast_possible_truncation, reason = "readings travel as f32")]
    let coin = (probability * (1.0 - probability)).max(0.0) as f32;
    Some(Reading { cell, value, variance: (variance + coin).min(MAX_VARIANCE) })
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
