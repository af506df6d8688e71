//! Readings, exactly: cells of a whole footprint as its radius, variances of the sensor model as its noise variance, rounded
//! values as numbers of steps. What is not so is written in full. Positions of objects follow, if there are any.

use dragnet_search::cell::{Cell, Grid, Offset};
use dragnet_search::evidence::value_step;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::sensor::{self, Sensor};

use super::PackedError;
use super::bytes::{Reader, Writer};
use crate::convert::check::{Columns, MAX_READINGS};
use crate::dragnet_msgs::{self as wire, OBSERVATION_VERSION};

/// All cells of the map within a Manhattan radius.
const FOOTPRINT: u8 = 1;
/// Variances by the sensor model.
const MODEL: u8 = 2;
/// Values that are whole numbers of steps.
const STEPS: u8 = 4;
/// Positions of objects after the readings.
const POSITIONS: u8 = 8;

/// Writes the readings of an observation from a cell, by a sensor of this noise variance if one is known.
pub(super) fn write(
    to: &mut Writer,
    grid: Grid,
    noise_variance: Option<f64>,
    from: Cell,
    readings: &Columns,
    positions: &[wire::ObjectPosition],
) {
    let Columns { cells, values, variances } = readings;
    let radius = radius(grid, from, cells);
    let is_model = |noise_variance: &f64| {
        let model = expected_variances(grid, *noise_variance, from, cells);
        model.is_some_and(|model| is_same(&model, variances))
    };
    let model = noise_variance.filter(is_model);
    let steps: Option<Vec<i64>> =
        values.iter().zip(variances).map(|(&value, &it)| steps(value, it)).collect();
    let flags = [
        (radius.is_some(), FOOTPRINT),
        (model.is_some(), MODEL),
        (steps.is_some(), STEPS),
        (!positions.is_empty(), POSITIONS),
    ];
    to.byte(flags.into_iter().filter_map(|(is_set, flag)| is_set.then_some(flag)).sum());
    match radius {
        Some(radius) => to.number(radius),
        None => write_cells(to, cells),
    }
    match model {
        Some(noise_variance) => to.raw(noise_variance.to_le_bytes()),
        None => variances.iter().for_each(|variance| to.raw(variance.to_le_bytes())),
    }
    match steps {
        Some(steps) => steps.into_iter().for_each(|step| to.signed(step)),
        None => values.iter().for_each(|value| to.raw(value.to_le_bytes())),
    }
    if !positions.is_empty() {
        write_positions(to, positions);
    }
}

/// Reads them. Their ranges are checked by the caller, as those of any message.
pub(super) fn read(
    from_bytes: &mut Reader<'_>,
    grid: Grid,
    from: u32,
) -> Result<(Columns, Vec<wire::ObjectPosition>), PackedError> {
    let flags = from_bytes.byte()?;
    if flags > FOOTPRINT | MODEL | STEPS | POSITIONS {
        return Err(PackedError::Flags(flags));
    }
    let center = grid.cell_numbered(from).ok_or(PackedError::Cell(from))?;
    let cells = if flags & FOOTPRINT == 0 {
        read_cells(from_bytes, MAX_READINGS)?
    } else {
        let radius: u32 = from_bytes.number()?;
        if radius > Sensor::MAX_RADIUS {
            return Err(PackedError::Radius(radius));
        }
        footprint(grid, center, radius).map(Cell::number).collect()
    };
    let variances = if flags & MODEL == 0 {
        numbers(from_bytes, cells.len())?
    } else {
        let noise_variance = f64::from_le_bytes(from_bytes.raw()?);
        expected_variances(grid, noise_variance, center, &cells).ok_or(PackedError::OffMap)?
    };
    let values = if flags & STEPS == 0 {
        numbers(from_bytes, cells.len())?
    } else {
        let value = |&variance: &f32| Ok(value(from_bytes.signed()?, variance));
        variances.iter().map(value).collect::<Result<_, _>>()?
    };
    let positions = if flags & POSITIONS == 0 {
        Vec::new()
    } else {
        from_bytes.list(ObjectPosition::MAX_IN_OBSERVATION, read_position)?
    };
    Ok((Columns { cells, values, variances }, positions))
}

fn write_positions(to: &mut Writer, positions: &[wire::ObjectPosition]) {
    to.length(positions.len());
    for position in positions {
        to.number(position.cell);
        to.raw(position.east_meters.to_le_bytes());
        to.raw(position.north_meters.to_le_bytes());
        for entry in position.covariance_square_meters {
            to.raw(entry.to_le_bytes());
        }
    }
}

fn read_position(from: &mut Reader<'_>) -> Result<wire::ObjectPosition, PackedError> {
    let cell = from.number()?;
    let [east_meters, north_meters] = [from.raw()?, from.raw()?].map(f64::from_le_bytes);
    let covariance_square_meters = [from.raw()?, from.raw()?, from.raw()?].map(f32::from_le_bytes);
    let version = OBSERVATION_VERSION;
    Ok(wire::ObjectPosition { version, cell, east_meters, north_meters, covariance_square_meters })
}

/// Cells as differences: neighbors take a byte or two.
pub(super) fn write_cells(to: &mut Writer, cells: &[u32]) {
    to.length(cells.len());
    let mut before = 0;
    for &cell in cells {
        to.signed(i64::from(cell) - before);
        before = i64::from(cell);
    }
}

pub(super) fn read_cells(from: &mut Reader<'_>, most: usize) -> Result<Vec<u32>, PackedError> {
    let mut before = 0_i64;
    from.list(most, |from| {
        let cell = before.checked_add(from.signed()?).and_then(|cell| u32::try_from(cell).ok());
        let cell = cell.ok_or(PackedError::Large)?;
        before = i64::from(cell);
        Ok(cell)
    })
}

/// Reads numbers one by one, so that no memory is allocated for those that do not arrive.
fn numbers(from: &mut Reader<'_>, count: usize) -> Result<Vec<f32>, PackedError> {
    (0..count).map(|_| from.raw().map(f32::from_le_bytes)).collect()
}

/// The cells of the map within a radius, in the order of [`Sensor::footprint`].
fn footprint(grid: Grid, center: Cell, radius: u32) -> impl Iterator<Item = Cell> {
    let position = grid.position(center);
    Offset::within(radius).filter_map(move |offset| grid.step_from(position, offset))
}

/// The radius if these are all cells of the map within one.
fn radius(grid: Grid, from: Cell, cells: &[u32]) -> Option<u32> {
    let distances = cells.iter().map(|&cell| Some(grid.manhattan(from, grid.cell_numbered(cell)?)));
    let radius = distances.collect::<Option<Vec<u32>>>()?.into_iter().max()?;
    let is_whole = radius <= Sensor::MAX_RADIUS
        && footprint(grid, from, radius).map(Cell::number).eq(cells.iter().copied());
    is_whole.then_some(radius)
}

/// Variances by the sensor model; `None` if a cell is not on the map.
fn expected_variances(grid: Grid, noise_variance: f64, from: Cell, cells: &[u32]) -> Option<Vec<f32>> {
    let variance = |&cell: &u32| {
        let distance = grid.manhattan(from, grid.cell_numbered(cell)?);
        // Beyond every sensor, so that no square overflows.
        (distance <= Sensor::MAX_RADIUS).then(|| sensor::variance(noise_variance, distance))
    };
    cells.iter().map(variance).collect()
}

fn is_same(a: &[f32], b: &[f32]) -> bool {
    a.iter().map(|it| it.to_bits()).eq(b.iter().map(|it| it.to_bits()))
}

/// The number of steps if it gives this value to the bit.
#[expect(clippy::cast_possible_truncation, reason = "saturates; such a number does not give the value")]
fn steps(found: f32, variance: f32) -> Option<i64> {
    let steps = (f64::from(found) / f64::from(value_step(variance))).round() as i64;
    (value(steps, variance).to_bits() == found.to_bits()).then_some(steps)
}

#[expect(clippy::cast_possible_truncation, reason = "values travel as f32; the caller checks their range")]
fn value(steps: i64, variance: f32) -> f32 {
    (steps as f64 * f64::from(value_step(variance))) as f32
}
