//! Traversable cells: an occupancy grid.

use dragnet_search::cell::Grid;

use super::check::Check;
use super::{InputError, PlanarPose};
use crate::schema::RosMessage;
use crate::wire::standard::OccupancyGrid;

/// Edges of a cell, meters: from a millimeter on.
const CELL_METERS: std::ops::RangeInclusive<f64> = 1e-3..=1e4;

/// A map of cells, row-major from its origin: cell `row * columns + column`.
#[derive(Clone, Debug, PartialEq)]
pub struct Occupancy {
    /// When, Unix nanoseconds.
    pub stamp_unix_ns: i64,
    /// The frame of the origin.
    pub frame: String,
    /// Rows along the origin's second axis, columns along its first.
    pub grid: Grid,
    /// Edge of a cell, meters, 0.001 to 10000.
    pub cell_meters: f64,
    /// The corner of cell 0 that all others are beyond, and the direction of the rows.
    pub origin: PlanarPose,
    /// 0 free to 100 occupied, -1 unknown; shape `[rows * columns]`.
    pub cells: Vec<i8>,
}

impl Occupancy {
    pub(super) fn check(map: OccupancyGrid) -> Result<Self, InputError> {
        let check = Check { message: OccupancyGrid::NAME };
        let (stamp_unix_ns, frame) = check.header(&map.header)?;
        let info = &map.info;
        let Ok(grid) = Grid::new(info.height, info.width) else {
            let found = format!("{} x {} cells", info.width, info.height);
            return check.refused("info", found, format!("1 to {} cells", Grid::MAX_CELLS));
        };
        if map.data.len() != grid.cell_count() {
            let found = format!("{} long", map.data.len());
            return check.refused("data", found, format!("{}, info.width x info.height", grid.cell_count()));
        }
        if let Some(index) = map.data.iter().position(|value| !(-1..=100).contains(value)) {
            return check.refused(format!("data[{index}]"), map.data[index], "-1 to 100");
        }
        let cell_meters = check.within("info.resolution", f64::from(info.resolution), &CELL_METERS)?;
        let origin = check.pose("info.origin", &info.origin)?;
        Ok(Self { stamp_unix_ns, frame, grid, cell_meters, origin, cells: map.data })
    }
}
