//! Which cells the frames of a look have shown, how often, and from how near.

use std::collections::BTreeMap;

use dragnet_search::cell::{Cell, Offset};
use dragnet_search::sensor::Sensor;
use dragnet_search::terrain::Terrain;
use nalgebra::Vector2;

use super::{sight, spread};
use crate::camera::View;

/// What a look has shown so far. It holds a number or two for each cell of the map at most, however long the
/// look lasts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    cells: BTreeMap<Cell, Sights>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sights {
    count: u32,
    /// Manhattan distance of the nearest camera, cells.
    nearest: u32,
}

impl Coverage {
    /// Takes in what one frame could see: cells whose middle is in view with no wall between, up to one cell
    /// farther than the sensor's radius, since a look ends in the next cell. A camera that is not over the
    /// map shows nothing.
    pub fn add(&mut self, terrain: &Terrain, sensor: &Sensor, view: &View) {
        let Some(from) = spread::cell_at(terrain, view.camera().position_meters()) else { return };
        for offset in offsets(sensor.radius() + 1) {
            let Some(cell) = terrain.grid().step(from, offset) else { continue };
            let (east, north) = terrain.center_meters(cell);
            if terrain.is_searched(cell)
                && view.contains(Vector2::new(east, north))
                && sight::is_clear(terrain, from, offset)
            {
                let distance = offset.manhattan();
                let sights = self.cells.entry(cell).or_insert(Sights { count: 0, nearest: distance });
                sights.count = sights.count.saturating_add(1);
                sights.nearest = sights.nearest.min(distance);
            }
        }
    }

    /// From how near a cell was seen, cells, if it was in so many frames at least.
    #[must_use]
    pub fn distance(&self, cell: Cell, fewest_sights: u32) -> Option<u32> {
        let sights = self.cells.get(&cell)?;
        (sights.count >= fewest_sights).then_some(sights.nearest)
    }

    /// Cells that were in view at all.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }
}

/// All offsets of at most this Manhattan length, cells.
fn offsets(reach: u32) -> impl Iterator<Item = Offset> {
    let reach = reach.cast_signed();
    (-reach..=reach).flat_map(move |north| {
        let span = reach - north.abs();
        (-span..=span).map(move |east| Offset { north, east })
    })
}
