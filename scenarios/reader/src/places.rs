//! Where cells are, as people read it.

use std::collections::BTreeSet;

use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::terrain::Terrain;

use crate::map_file::{GeoPoint, Georeference};

/// Writes where the cells of a map are.
#[derive(Clone, Debug)]
pub struct Places {
    grid: Grid,
    cell_meters: f64,
    frame: Option<Georeference>,
    /// Whether the number of objects there is known: finds are those of subjects.
    pub(crate) is_of_subjects: bool,
}

impl Places {
    /// The places of a map, in a frame on the earth if that is known.
    #[must_use]
    pub fn new(terrain: &Terrain, frame: Option<&Georeference>) -> Self {
        Self {
            grid: terrain.grid(),
            cell_meters: terrain.cell_meters(),
            frame: frame.copied(),
            is_of_subjects: false,
        }
    }

    /// Whether the number of objects there is known, if they are places of a scenario.
    #[must_use]
    pub const fn is_of_subjects(&self) -> bool {
        self.is_of_subjects
    }

    /// A cell as scenarios write it: `[row, column]`, from the south-west.
    #[must_use]
    pub fn cell(&self, cell: Cell) -> String {
        let Position { row, column } = self.grid.position(cell);
        format!("[{row}, {column}]")
    }

    /// The same, with the latitude and longitude of its center if they are known: for a person who is to go there.
    #[must_use]
    pub fn on_earth(&self, cell: Cell) -> String {
        let center = self.center(cell).map_or_else(String::new, |center| format!(" at {center}"));
        format!("{}{center}", self.cell(cell))
    }

    /// Where the object is that is declared in a cell: as [`Places::on_earth`] or, if a robot knows its position, that with its
    /// accuracy, in meters of the map if that is not on the earth.
    #[must_use]
    pub fn object(&self, cell: Cell, position: Option<&ObjectPosition>) -> String {
        let Some(position) = position else { return self.on_earth(cell) };
        let place = located(self.frame.as_ref(), position.meters(), position.accuracy_meters());
        format!("{} at {place}", self.cell(cell))
    }

    /// Where on the earth the object of a cell is, if the map is: at its position if that is known, otherwise in the center
    /// of the cell.
    #[must_use]
    pub fn object_point(&self, cell: Cell, position: Option<&ObjectPosition>) -> Option<GeoPoint> {
        position.map_or_else(|| self.center(cell), |position| Some(self.frame?.point(position.meters())))
    }

    /// A number of cells in meters.
    #[must_use]
    pub fn meters(&self, cells: f64) -> f64 {
        cells * self.cell_meters
    }

    /// Some cells, at least one, by their number and the one in the middle.
    #[must_use]
    pub fn some(&self, cells: &BTreeSet<Cell>) -> String {
        let positions = || cells.iter().map(|&cell| self.grid.position(cell));
        let middle = |of: fn(Position) -> u32| {
            let ends = positions().map(of).fold((u32::MAX, 0), |(low, high), at| (low.min(at), high.max(at)));
            ends.0.midpoint(ends.1)
        };
        let middle = Position { row: middle(|at| at.row), column: middle(|at| at.column) };
        let count = cells.len();
        let place = self.grid.cell(middle).map_or_else(String::new, |cell| self.on_earth(cell));
        if count == 1 { format!("cell {place}") } else { format!("{count} cells around {place}") }
    }

    /// Where on the earth a cell's center is, if that is known.
    #[must_use]
    pub fn center(&self, cell: Cell) -> Option<GeoPoint> {
        let Position { row, column } = self.grid.position(cell);
        let meters = [column, row].map(|at| (f64::from(at) + 0.5) * self.cell_meters);
        Some(self.frame?.point(meters.into()))
    }
}

/// A position as people read it, meters east and north of the map's south-western corner, with its accuracy: on the earth if the
/// map is.
#[must_use]
pub fn located(frame: Option<&Georeference>, (east, north): (f64, f64), accuracy_meters: f64) -> String {
    let place = match frame {
        Some(frame) => frame.point((east, north)).to_string(),
        None => format!("{east:.1} m east, {north:.1} m north"),
    };
    format!("{place} ({})", accuracy(accuracy_meters))
}

/// How well a position is known, as people read it, by [`ObjectPosition::accuracy_meters`]: rounded up to
/// decimeters.
#[must_use]
pub fn accuracy(meters: f64) -> String {
    format!("within {:.1} m with 95 % probability", (10.0 * meters).ceil() / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_on_the_earth_if_the_map_is() {
        let terrain = Terrain::from_ascii("...\n...", 100.0).unwrap();
        let cell = terrain.grid().cell_numbered(4).unwrap();
        let frame = Georeference::new(GeoPoint { longitude_degrees: 2.0, latitude_degrees: 0.0 }, 0.0);
        assert_eq!(Places::new(&terrain, None).on_earth(cell), "[1, 1]");
        let places = Places::new(&terrain, Some(&frame));
        assert_eq!(places.cell(cell), "[1, 1]");
        assert_eq!(places.on_earth(cell), "[1, 1] at latitude 0.001357, longitude 2.001347");
    }

    #[test]
    fn an_object_is_where_a_robot_has_located_it_or_else_in_its_cell() {
        let terrain = Terrain::from_ascii("...\n...", 100.0).unwrap();
        let cell = terrain.grid().cell_numbered(4).unwrap();
        let frame = Georeference::new(GeoPoint { longitude_degrees: 2.0, latitude_degrees: 0.0 }, 0.0);
        let (flat, places) = (Places::new(&terrain, None), Places::new(&terrain, Some(&frame)));
        assert_eq!(
            (flat.object(cell, None), places.object(cell, None)),
            (flat.on_earth(cell), places.on_earth(cell))
        );
        let position = ObjectPosition::new(cell, [120.04, 190.0], [0.04, 0.0, 0.0625]).unwrap();
        let known = "(within 0.7 m with 95 % probability)";
        assert_eq!(
            flat.object(cell, Some(&position)),
            format!("[1, 1] at 120.0 m east, 190.0 m north {known}")
        );
        let there = "[1, 1] at latitude 0.001718, longitude 2.001078";
        assert_eq!(places.object(cell, Some(&position)), format!("{there} {known}"));
    }
}
