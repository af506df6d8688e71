//! Teammates' planned observations: those of their planned paths, and their shares of the rest of the map.

use crate::cell::Cell;
use crate::sensor::Sensor;
use crate::terrain::Terrain;

/// Precision that teammates' plans are expected to add, shape `[cells]`, units of evidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedPrecision {
    precision: Vec<i64>,
}

impl PlannedPrecision {
    /// No plans.
    #[must_use]
    pub fn nothing(terrain: &Terrain) -> Self {
        Self { precision: vec![0; terrain.grid().cell_count()] }
    }

    /// Planned precision from stored values, units of evidence, shape `[cells]`; `None` if one is below 0.
    #[must_use]
    pub fn from_precision(precision: Vec<i64>) -> Option<Self> {
        precision.iter().all(|&precision| precision >= 0).then_some(Self { precision })
    }

    /// Whether any precision is planned.
    #[must_use]
    pub fn is_anything(&self) -> bool {
        self.precision.iter().any(|&precision| precision > 0)
    }

    /// Adds an observation from every cell of a path.
    pub fn add_path(&mut self, terrain: &Terrain, sensor: &Sensor, path: &[Cell]) {
        for &from in path {
            for observation in sensor.footprint() {
                if let Some(cell) = terrain.grid().step(from, observation.offset) {
                    self.precision[cell.index()] += observation.precision;
                }
            }
        }
    }

    /// Adds each teammate's share: one observation, from its own cell, of every cell that is nearer to a teammate's
    /// waypoint than to this robot, in a straight line.
    ///
    /// A planned path ends long before the search does. The rest of the map is left to the nearest robot, as in a
    /// Voronoi partition that moves with the robots. A share only lowers the gain: a cell that is worth a second
    /// observation, or is all that is left, can still be visited by any robot.
    pub fn add_shares(&mut self, terrain: &Terrain, sensor: &Sensor, robot: Cell, waypoints: &[Cell]) {
        let grid = terrain.grid();
        let observation =
            sensor.footprint().iter().map(|observation| observation.precision).max().unwrap_or_default();
        for cell in grid.cells() {
            let distance = |from| grid.offset(from, cell).euclidean();
            let own = distance(robot);
            if waypoints.iter().any(|&waypoint| distance(waypoint) < own) {
                self.precision[cell.index()] += observation;
            }
        }
    }

    /// Precision planned for a cell, units of evidence.
    #[must_use]
    pub fn precision(&self, cell: Cell) -> i64 {
        self.precision[cell.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_a_path_plans_its_observation() {
        let terrain = Terrain::from_ascii("...", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        planned_precision.add_path(&terrain, &sensor, &cells[..2]);
        let at = |distance| crate::evidence::precision_units(sensor.variance(distance));
        assert_eq!(planned_precision.precision(cells[0]), at(0) + at(1));
        assert_eq!(planned_precision.precision(cells[1]), at(1) + at(0));
        assert_eq!(planned_precision.precision(cells[2]), at(1));
    }

    #[test]
    fn cells_nearer_to_a_teammate_are_its_share() {
        let terrain = Terrain::from_ascii(".......", 1.0).unwrap();
        let sensor = Sensor::new(1, 0.005, crate::sensor::Noise::Gaussian).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let check = |robot: usize, waypoints: &[usize], expected: &str| {
            let mut planned_precision = PlannedPrecision::nothing(&terrain);
            let waypoints: Vec<Cell> = waypoints.iter().map(|&waypoint| cells[waypoint]).collect();
            planned_precision.add_shares(&terrain, &sensor, cells[robot], &waypoints);
            let observation = crate::evidence::precision_units(sensor.variance(0));
            let shared = cells.iter().map(|&cell| match planned_precision.precision(cell) {
                0 => '.',
                precision => {
                    if precision == observation {
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
