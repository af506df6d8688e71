//! A map of the vehicle's network compared with the search's: its costs, and whether the two match.

use dragnet_lattice::costmap::{CostMap, OccupancyRule};
use dragnet_lattice::plane::Pose;
use dragnet_ros2::input::Occupancy;
use dragnet_search::cell::{Cell, Position};
use dragnet_search::terrain::Terrain;

use super::place::posed;

/// Rule for received maps: cells at least this probably occupied are lethal; unknown cells have the highest cost.
const RULE: OccupancyRule = OccupancyRule { lethal_percent: 65, unknown_cost: 50 };
/// Axes that differ by less than this are equal, radians.
const SQUARE_RADIANS: f64 = 1e-3;
/// Sample points along the side of a cell.
const SAMPLES: u32 = 8;

/// Position of the south-western corner of a network's map on the search's, which has the pose `search` in the
/// network's frame.
fn corner(search: &Pose, map: &Occupancy) -> Result<Pose, String> {
    let corner = posed(map.origin).seen_from(search);
    if corner.heading_radians.abs() > SQUARE_RADIANS {
        return Err(format!("the map is turned by {:.3} rad against the search's", corner.heading_radians));
    }
    Ok(corner)
}

/// The cost map of a received map.
///
/// # Errors
/// If it is not a valid cost map.
pub(super) fn cost_map(search: &Pose, map: &Occupancy) -> Result<CostMap, String> {
    let corner = corner(search, map)?;
    let origin_meters = (corner.x_meters, corner.y_meters);
    CostMap::from_occupancy(map.grid, map.cell_meters, origin_meters, &map.cells, RULE)
        .map_err(|error| error.to_string())
}

/// The match between a map and the free cells of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Likeness {
    /// Number of the search's free cells.
    pub(crate) free: u32,
    /// Those of them that are mostly outside of the map.
    pub(crate) outside: u32,
    /// Those that are mostly occupied on it.
    pub(crate) occupied: u32,
}

impl Likeness {
    /// Compares a map of a network with that of a search, which has the pose `search` in the network's frame.
    ///
    /// # Errors
    /// If the two are rotated against each other.
    pub(crate) fn of(search: &Pose, map: &Occupancy, terrain: &Terrain) -> Result<Self, String> {
        let corner = corner(search, map)?;
        let mut likeness = Self::default();
        for cell in terrain.traversable_cells() {
            let (mut outside, mut occupied) = (0, 0);
            for (x_meters, y_meters) in samples(terrain, cell) {
                let [column, row] = [x_meters - corner.x_meters, y_meters - corner.y_meters]
                    .map(|meters| meters / map.cell_meters);
                match map.grid.cell_at(column, row).map(|square| map.cells[square.index()]) {
                    None => outside += 1,
                    Some(percent) => {
                        occupied += u32::from(i16::from(percent) >= i16::from(RULE.lethal_percent));
                    }
                }
            }
            likeness.free += 1;
            likeness.outside += u32::from(2 * outside > SAMPLES * SAMPLES);
            likeness.occupied += u32::from(2 * occupied > SAMPLES * SAMPLES);
        }
        Ok(likeness)
    }

    /// Whether the search can drive almost everywhere.
    pub(crate) const fn will_do(&self) -> bool {
        20 * (self.outside + self.occupied) <= self.free
    }
}

/// Points spread evenly over a cell, meters on the search's map.
fn samples(terrain: &Terrain, cell: Cell) -> impl Iterator<Item = (f64, f64)> {
    let Position { row, column } = terrain.grid().position(cell);
    let edge = terrain.cell_meters();
    let along =
        move |start: u32, step: u32| (f64::from(start) + (f64::from(step) + 0.5) / f64::from(SAMPLES)) * edge;
    (0..SAMPLES).flat_map(move |north| (0..SAMPLES).map(move |east| (along(column, east), along(row, north))))
}

#[cfg(test)]
mod tests {
    use dragnet_ros2::input::PlanarPose;
    use dragnet_search::cell::Grid;

    use super::*;
    use crate::mentions::assert_mentions;

    /// Three by two cells of 10 m, one of them blocked.
    fn terrain() -> Terrain {
        Terrain::from_ascii("..#\n...\n", 10.0).unwrap()
    }

    /// A map of 2 m squares with this corner; cells are blocked as in the terrain, moved by this many squares.
    fn map(corner: [f64; 2], moved: u32) -> Occupancy {
        let grid = Grid::new(10, 15).unwrap();
        let blocked = |row: u32, column: u32| row >= 5 && column >= 10 - moved && column < 15 - moved;
        let cells = grid.cells().map(|cell| {
            let Position { row, column } = grid.position(cell);
            if blocked(row, column) { 100 } else { 0 }
        });
        Occupancy {
            stamp_unix_ns: 0,
            frame: "map".to_owned(),
            grid,
            cell_meters: 2.0,
            origin: PlanarPose { x_meters: corner[0], y_meters: corner[1], yaw_radians: 0.0 },
            cells: cells.collect(),
        }
    }

    #[test]
    fn a_map_is_compared_with_the_searchs_free_cells() {
        let search = Pose::new(-4.0, 7.0, 0.0);
        let check = |map: &Occupancy, outside: u32, occupied: u32| {
            let found = Likeness::of(&search, map, &terrain()).unwrap();
            assert_eq!(found, Likeness { free: 5, outside, occupied });
            assert_eq!(found.will_do(), outside + occupied == 0);
        };
        check(&map([-4.0, 7.0], 0), 0, 0);
        check(&map([-4.0, 7.0], 5), 0, 1);
        check(&map([6.0, 7.0], 0), 2, 0);
        check(&map([400.0, 7.0], 0), 5, 0);
        let mut turned = map([-4.0, 7.0], 0);
        turned.origin.yaw_radians = 0.5;
        let error = Likeness::of(&search, &turned, &terrain()).unwrap_err();
        assert_mentions(&error, "map .. turned .. 0.500 rad");
    }
}
