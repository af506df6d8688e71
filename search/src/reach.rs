//! The cells that robots can observe at all, from the cells that they can drive to.

use std::collections::{BTreeMap, VecDeque};

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

/// What a robot can see from where, as far as the reach depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Sight {
    /// Radius of its sensor, cells, at most [`crate::sensor::Sensor::MAX_RADIUS`].
    radius: u8,
    /// Whether it crosses cells that are not traversable.
    flies: bool,
}

impl Sight {
    /// The sight of a robot on the ground, with a sensor of this radius (cells).
    #[must_use]
    pub fn on_ground(radius: u32) -> Self {
        Self { radius: u8::try_from(radius).unwrap_or(OUT_OF_SIGHT).min(OUT_OF_SIGHT - 1), flies: false }
    }

    /// The sight of a robot that crosses every cell.
    #[must_use]
    pub fn from_above(radius: u32) -> Self {
        Self { flies: true, ..Self::on_ground(radius) }
    }

    /// Whether the robot crosses cells that are not traversable.
    #[must_use]
    pub const fn flies(self) -> bool {
        self.flies
    }
}

/// The cells that some robot can see from some cell that it can drive to, given the cells that robots have observed
/// from.
///
/// It follows from the map, the robots' sight and the cells that observations were made from, in any order: equal
/// sets of observations give equal reach. Before any observation everything counts as in reach. Where diagonal moves
/// are allowed they connect no more cells than straight ones, since no corner is cut.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reach {
    grid: Grid,
    /// For each sight, Manhattan distance to the nearest cell where such a robot can stand, cells, up to its radius;
    /// shape `[cells]`.
    distance: BTreeMap<Sight, Vec<u8>>,
    /// Whether some robot can see a cell, shape `[cells]`; empty before the first observation.
    is_covered: Vec<bool>,
    /// Number of added connected areas.
    areas: u32,
}

impl Reach {
    /// The reach before any observation.
    #[must_use]
    pub const fn unknown(grid: Grid) -> Self {
        Self { grid, distance: BTreeMap::new(), is_covered: Vec::new(), areas: 0 }
    }

    /// Whether [`Reach::add_robot`] would change anything.
    #[must_use]
    pub fn is_news(&self, sight: Sight, cell: Cell) -> bool {
        self.distance.get(&sight).is_none_or(|distance| distance[cell.index()] > 0)
    }

    /// Adds a cell that a robot has observed from: robots of its sight can go to all cells connected with it.
    pub fn add_robot(&mut self, terrain: &Terrain, sight: Sight, cell: Cell) {
        if !self.is_news(sight, cell) {
            return;
        }
        let count = self.grid.cell_count();
        self.is_covered.resize(count, false);
        self.areas += 1;
        let distance = self.distance.entry(sight).or_insert_with(|| vec![OUT_OF_SIGHT; count]);
        let area = connected(terrain, sight, cell, distance);
        if !sight.flies && !terrain.line_of_sight().is_everywhere() {
            return observe_in_sight(terrain, sight, &area, &mut self.is_covered);
        }
        observe_around(self.grid, sight, area, distance);
        for (is_covered, distance) in self.is_covered.iter_mut().zip(distance) {
            *is_covered |= *distance <= sight.radius;
        }
    }

    /// Whether a robot can observe this cell from any cell that it can drive to.
    #[must_use]
    #[inline]
    pub fn covers(&self, cell: Cell) -> bool {
        self.is_covered.get(cell.index()).is_none_or(|&is_covered| is_covered)
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

/// All cells that a robot can go to from this one; their distance becomes 0. The map may be wrong about the first.
fn connected(terrain: &Terrain, sight: Sight, first: Cell, distance: &mut [u8]) -> VecDeque<Cell> {
    distance[first.index()] = 0;
    let mut area = vec![first];
    let mut next = 0;
    while let Some(&cell) = area.get(next) {
        next += 1;
        for beside in AROUND.iter().filter_map(|&offset| terrain.grid().step(cell, offset)) {
            let distance = &mut distance[beside.index()];
            if *distance > 0 && (sight.flies || terrain.is_traversable(beside)) {
                *distance = 0;
                area.push(beside);
            }
        }
    }
    area.into()
}

/// Distances from these cells, by breadth-first search over the whole grid: sensors observe across cells that are not
/// traversable.
fn observe_around(grid: Grid, sight: Sight, mut queue: VecDeque<Cell>, distance: &mut [u8]) {
    while let Some(cell) = queue.pop_front() {
        let farther = distance[cell.index()] + 1;
        if farther > sight.radius {
            continue;
        }
        for beside in AROUND.iter().filter_map(|&offset| grid.step(cell, offset)) {
            if farther < distance[beside.index()] {
                distance[beside.index()] = farther;
                queue.push_back(beside);
            }
        }
    }
}

/// What is seen from these cells where walls hide something.
fn observe_in_sight(terrain: &Terrain, sight: Sight, area: &VecDeque<Cell>, is_covered: &mut [bool]) {
    for &from in area {
        let (position, shadows) = (terrain.grid().position(from), terrain.line_of_sight().shadows(from));
        for offset in Offset::within(sight.radius.into()) {
            if shadows.is_none_or(|shadows| !shadows.hide(offset))
                && let Some(cell) = terrain.grid().step_from(position, offset)
            {
                is_covered[cell.index()] = true;
            }
        }
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
        let mut reach = Reach::unknown(terrain.grid());
        for &robot in robots {
            reach.add_robot(&terrain, Sight::on_ground(radius), cells[robot]);
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

    #[test]
    fn unlike_robots_reach_what_any_of_them_sees_in_whatever_order_they_came() {
        let terrain = Terrain::from_ascii(".#~~~~~~.", 1.0).unwrap();
        let cells: Vec<Cell> = terrain.grid().cells().collect();
        let reach_of = |robots: &[(Sight, usize)]| {
            let mut reach = Reach::unknown(terrain.grid());
            for &(sight, robot) in robots {
                assert!(reach.is_news(sight, cells[robot]));
                reach.add_robot(&terrain, sight, cells[robot]);
                assert!(!reach.is_news(sight, cells[robot]));
            }
            reach
        };
        let check = |robots: &[(Sight, usize)], expected: &str| {
            let reach = reach_of(robots);
            let covered = cells.iter().map(|&cell| if reach.covers(cell) { 'x' } else { '-' });
            assert_eq!(covered.collect::<String>(), expected);
            let backwards: Vec<(Sight, usize)> = robots.iter().rev().copied().collect();
            assert_eq!(reach_of(&backwards), reach);
        };
        let (near, far) = (Sight::on_ground(1), Sight::on_ground(3));
        check(&[(near, 0)], "xx-------");
        check(&[(near, 0), (far, 8)], "xx---xxxx");
        check(&[(far, 0), (near, 0)], "xxxx-----");
        check(&[(near, 0), (Sight::from_above(1), 0)], "xxxxxxxxx");
    }

    fn terrain() -> impl Strategy<Value = Terrain> {
        (1_u32..9, 1_u32..9).prop_flat_map(|(rows, columns)| {
            let grid = Grid::new(rows, columns).unwrap();
            prop::collection::vec(prop::bool::weighted(0.5), grid.cell_count()).prop_map(move |open| {
                let ground = open.into_iter().map(|open| if open { Ground::OPEN } else { Ground::BLOCKED });
                Terrain::new(grid, 1.0, ground.collect()).unwrap()
            })
        })
    }

    proptest! {
        #[test]
        fn it_is_all_footprints_of_all_paths_in_any_order(
            terrain in terrain(), places in prop::collection::vec(any::<prop::sample::Index>(), 1..4),
            radius in 1_u32..4, eight in any::<bool>(), is_opaque in any::<bool>(),
        ) {
            let terrain = if is_opaque { terrain.with_opaque_walls(radius) } else { terrain };
            let standing: Vec<Cell> = terrain.traversable_cells().collect();
            prop_assume!(!standing.is_empty());
            let connectivity = if eight { Connectivity::Eight } else { Connectivity::Four };
            let sensor = Sensor::new(radius, 0.005, Noise::Gaussian).unwrap();
            let robots: Vec<Cell> = places.iter().map(|place| *place.get(&standing)).collect();
            let mut seen = vec![false; terrain.grid().cell_count()];
            for &robot in &robots {
                for &from in ShortestPathTree::from(&terrain, connectivity, robot).reached() {
                    for (cell, _) in terrain.in_sight(&sensor, from) {
                        seen[cell.index()] = true;
                    }
                }
            }
            let reach_of = |robots: &mut dyn Iterator<Item = &Cell>| {
                let mut reach = Reach::unknown(terrain.grid());
                robots.for_each(|&robot| reach.add_robot(&terrain, Sight::on_ground(radius), robot));
                reach
            };
            let reach = reach_of(&mut robots.iter());
            let covered: Vec<bool> = terrain.grid().cells().map(|cell| reach.covers(cell)).collect();
            prop_assert_eq!(covered, seen);
            prop_assert_eq!(reach, reach_of(&mut robots.iter().rev()));
        }
    }
}
