//! A teammate's planned path, as looks already promised.

use crate::cell::Cell;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// Precision that the planned paths of the others will add, shape `[cells]`, units of evidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Promised {
    precision: Vec<i64>,
}

impl Promised {
    /// Nobody promised anything.
    #[must_use]
    pub fn nothing(terrain: &Terrain) -> Self {
        Self { precision: vec![0; terrain.grid().cell_count()] }
    }

    /// Promises that were taken down: precision of each cell, units of evidence, shape `[cells]`; nothing if one is
    /// below 0.
    #[must_use]
    pub fn from_precision(precision: Vec<i64>) -> Option<Self> {
        precision.iter().all(|&precision| precision >= 0).then_some(Self { precision })
    }

    /// Whether anybody promised anything.
    #[must_use]
    pub fn is_anything(&self) -> bool {
        self.precision.iter().any(|&precision| precision > 0)
    }

    /// Adds a look from every cell of a path.
    pub fn add_path(&mut self, terrain: &Terrain, sensor: &Sensor, path: &[Cell]) {
        for &from in path {
            for look in sensor.footprint() {
                if let Some(cell) = terrain.grid().step(from, look.offset) {
                    self.precision[cell.index()] += look.precision;
                }
            }
        }
    }

    /// Precision promised for a cell, units of evidence.
    #[must_use]
    pub fn precision(&self, cell: Cell) -> i64 {
        self.precision[cell.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_a_path_promises_its_look() {
        let terrain = Terrain::from_ascii("...", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut promised = Promised::nothing(&terrain);
        promised.add_path(&terrain, &sensor, &cells[..2]);
        let at = |distance| crate::evidence::precision_units(sensor.variance(distance));
        assert_eq!(promised.precision(cells[0]), at(0) + at(1));
        assert_eq!(promised.precision(cells[1]), at(1) + at(0));
        assert_eq!(promised.precision(cells[2]), at(1));
    }
}
