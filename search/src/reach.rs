//! The cells that robots can observe at all, from the cells that they can drive to.

use std::collections::VecDeque;

use crate::cell::{Cell, Grid, Offset};
use crate::terrain::Terrain;

/// Farther than any sensor sees, [`crate::sensor::Sensor::MAX_RADIUS`].
const OUT_OF_SIGHT: u8 = u8::MAX;

const AROUND: [Offset; 4] = [
    Offset { north: -1, east: 0 },
    Offset { north: 0, east: -1 },
    Offset { north: 0, east: 1 },
    Offset { north: 1, east: 0 },
];

/// The cells that some robot can see from some cell that it can drive to, given the cells that robots have observed
/// from.
///
/// It follows from the map, the sensor's radius and the cells that observations were made from, in any order: equal
/// sets of observations give equal reach. Before any observation everything counts as in reach. Where diagonal moves
/// are allowed they connect no more cells than straight ones, since no corner is cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reach {
    grid: Grid,
    radius: u8,
    /// Manhattan distance to the nearest cell where a robot can stand, cells, up to the sensor radius; shape `[cells]`,
    /// empty before the first observation.
    distance: Vec<u8>,
    /// Number of added connected areas.
    areas: u32,
}

impl Reach {
    /// The reach before any observation, for sensors of this radius (cells, at most
    /// [`crate::sensor::Sensor::MAX_RADIUS`]).
    #[must_use]
    pub fn unknown(grid: Grid, radius: u32) -> Self {
        let radius = u8::try_from(radius).unwrap_or(OUT_OF_SIGHT).min(OUT_OF_SIGHT - 1);
        Self { grid, radius, distance: Vec::new(), areas: 0 }
    }

    /// Whether [`Reach::add_robot`] would change anything.
    #[must_use]
    pub fn is_news(&self, cell: Cell) -> bool {
        self.distance.get(cell.index()).is_none_or(|&distance| distance > 0)
    }

    /// Adds a cell that a robot has observed from: robots can drive to all cells connected with it.
    pub fn add_robot(&mut self, terrain: &Terrain, cell: Cell) {
        if !self.is_news(cell) {
            return;
        }
        if self.distance.is_empty() {
            self.distance = vec![OUT_OF_SIGHT; self.grid.cell_count()];
        }
        self.areas += 1;
        let area = self.connected(terrain, cell);
        self.observe_around(area);
    }

    /// All cells that a robot can drive to from this one. The map may be wrong about the first.
    fn connected(&mut self, terrain: &Terrain, first: Cell) -> VecDeque<Cell> {
        self.distance[first.index()] = 0;
        let mut area = vec![first];
        let mut next = 0;
        while let Some(&cell) = area.get(next) {
            next += 1;
            for beside in AROUND.iter().filter_map(|&offset| self.grid.step(cell, offset)) {
                let distance = &mut self.distance[beside.index()];
                if *distance > 0 && terrain.is_traversable(beside) {
                    *distance = 0;
                    area.push(beside);
                }
            }
        }
        area.into()
    }

    /// Distances from these cells, by breadth-first search over the whole grid: sensors observe across cells that are
    /// not traversable.
    fn observe_around(&mut self, mut queue: VecDeque<Cell>) {
        while let Some(cell) = queue.pop_front() {
            let distance = self.distance[cell.index()] + 1;
            if distance > self.radius {
                continue;
            }
            for beside in AROUND.iter().filter_map(|&offset| self.grid.step(cell, offset)) {
                if distance < self.distance[beside.index()] {
                    self.distance[beside.index()] = distance;
                    queue.push_back(beside);
                }
            }
        }
    }

    /// Whether a robot can observe this cell from any cell that it can drive to.
    #[must_use]
    #[inline]
    pub fn covers(&self, cell: Cell) -> bool {
        self.distance.get(cell.index()).is_none_or(|&distance| distance <= self.radius)
    }

    /// A number that changes whenever the reach changes.
    #[must_use]
    pub const fn version(&self) -> u32 {
        self.areas
    }

    /// Searched cells that no robot can see, by index.
    pub fn out_of_reach<'a>(&'a self, terrain: &'a Terrain) -> impl Iterator<Item = Cell> + 'a {
        terrain.searched_cells().filter(|&cell| !self.covers(cell))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::route::{Connectivity, ShortestPathTree};
    use crate::sensor::{Noise, Sensor};
    use crate::terrain::Ground;

    fn drawn(drawing: &str, radius: u32, robots: &[usize]) -> String {
        let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let mut reach = Reach::unknown(terrain.grid(), radius);
        for &robot in robots {
            reach.add_robot(&terrain, cells[robot]);
        }
        cells.iter().map(|&cell| if reach.covers(cell) { 'x' } else { '-' }).collect()
    }

    #[test]
    fn a_lake_is_seen_from_its_shore_only() {
        assert_eq!(drawn("..~~~~~..", 2, &[]), "xxxxxxxxx", "no robot was observed yet");
        assert_eq!(drawn("..~~~~~..", 2, &[0]), "xxxx-----");
        assert_eq!(drawn("..~~~~~..", 2, &[0, 8]), "xxxx-xxxx");
        assert_eq!(drawn("..~~~~~..", 2, &[8, 1, 0]), "xxxx-xxxx");
        assert_eq!(drawn("..~~~~~..", 1, &[4]), "---xxx---", "the map is wrong about where it stands");
    }

    fn terrain() -> impl Strategy<Value = Terrain> {
        (1_u32..9, 1_u32..9).prop_flat_map(|(rows, columns)| {
            let grid = Grid::new(rows, columns).unwrap();
            prop::collection::vec(prop::bool::weighted(0.5), grid.cell_count()).prop_map(move |open| {
                let ground =
                    open.into_iter().map(|open| if open { Ground::OPEN } else { Ground::OUT_OF_REACH });
                Terrain::new(grid, 1.0, ground.collect()).unwrap()
            })
        })
    }

    proptest! {
        #[test]
        fn it_is_all_footprints_of_all_paths_in_any_order(
            terrain in terrain(), places in prop::collection::vec(any::<prop::sample::Index>(), 1..4),
            radius in 1_u32..4, eight in any::<bool>(),
        ) {
            let standing: Vec<Cell> = terrain.traversable_cells().collect();
            prop_assume!(!standing.is_empty());
            let connectivity = if eight { Connectivity::Eight } else { Connectivity::Four };
            let sensor = Sensor::new(radius, 0.005, Noise::Gaussian).unwrap();
            let robots: Vec<Cell> = places.iter().map(|place| *place.get(&standing)).collect();
            let mut seen = vec![false; terrain.grid().cell_count()];
            for &robot in &robots {
                for &from in ShortestPathTree::from(&terrain, connectivity, robot).reached() {
                    for observation in sensor.footprint() {
                        if let Some(cell) = terrain.grid().step(from, observation.offset) {
                            seen[cell.index()] = true;
                        }
                    }
                }
            }
            let reach_of = |robots: &mut dyn Iterator<Item = &Cell>| {
                let mut reach = Reach::unknown(terrain.grid(), radius);
                robots.for_each(|&robot| reach.add_robot(&terrain, robot));
                reach
            };
            let reach = reach_of(&mut robots.iter());
            let covered: Vec<bool> = terrain.grid().cells().map(|cell| reach.covers(cell)).collect();
            prop_assert_eq!(covered, seen);
            prop_assert_eq!(reach, reach_of(&mut robots.iter().rev()));
        }
    }
}
