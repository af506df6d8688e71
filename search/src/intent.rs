//! What teammates will see: the looks of their planned paths, and each its share of what is left.

use crate::cell::Cell;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// Precision that the others are expected to add, shape `[cells]`, units of evidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedPrecision {
    precision: Vec<i64>,
}

impl PlannedPrecision {
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

    /// Adds each teammate's share: one look, from where it stands, at every cell that is nearer to a teammate's waypoint
    /// than to this robot, in a straight line.
    ///
    /// A planned path ends long before the search does. What comes after it, teammates leave to whoever is nearest, as in
    /// a Voronoi partition of the map that moves with them; but a share is a discount, not a fence: what is worth a second
    /// look, or is all that is left, is visited by anybody.
    pub fn add_shares(&mut self, terrain: &Terrain, sensor: &Sensor, robot: Cell, waypoints: &[Cell]) {
        let grid = terrain.grid();
        let look = sensor.footprint().iter().map(|look| look.precision).max().unwrap_or_default();
        for cell in grid.cells() {
            let distance = |from| grid.offset(from, cell).euclidean();
            let own = distance(robot);
            if waypoints.iter().any(|&waypoint| distance(waypoint) < own) {
                self.precision[cell.index()] += look;
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
        let mut promised = PlannedPrecision::nothing(&terrain);
        promised.add_path(&terrain, &sensor, &cells[..2]);
        let at = |distance| crate::evidence::precision_units(sensor.variance(distance));
        assert_eq!(promised.precision(cells[0]), at(0) + at(1));
        assert_eq!(promised.precision(cells[1]), at(1) + at(0));
        assert_eq!(promised.precision(cells[2]), at(1));
    }

    #[test]
    fn what_is_nearer_to_a_teammate_is_its_share() {
        let terrain = Terrain::from_ascii(".......", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let check = |robot: usize, waypoints: &[usize], expected: &str| {
            let mut promised = PlannedPrecision::nothing(&terrain);
            let waypoints: Vec<Cell> = waypoints.iter().map(|&waypoint| cells[waypoint]).collect();
            promised.add_shares(&terrain, &sensor, cells[robot], &waypoints);
            let look = crate::evidence::precision_units(sensor.variance(0));
            let shared = cells.iter().map(|&cell| match promised.precision(cell) {
                0 => '.',
                precision => {
                    if precision == look {
                        'x'
                    } else {
                        '?'
                    }
                }
            });
            assert_eq!(shared.collect::<String>(), expected);
        };
        check(2, &[], ".......");
        check(0, &[6], "....xxx");
        check(3, &[1, 5], "xx...xx");
        check(3, &[6, 6], ".....xx");
        check(3, &[3], ".......");
    }
}
