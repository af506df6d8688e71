//! The cells within a polygon.

use dragnet_search::cell::{Cell, Grid, Position};

/// A corner: cells east and north of the map's south-western corner.
pub type Corner = [f64; 2];

/// The maximum number of corners.
pub const MOST_CORNERS: usize = 1_000;

/// An invalid polygon.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolygonError {
    /// Too few corners, or too many.
    #[error("{0} corners; allowed are 3 to {MOST_CORNERS}")]
    Corners(usize),
    /// No area.
    #[error("all corners are on one line, so that nothing is inside")]
    Flat,
    /// A corner off the map.
    #[error(
        "corner {index} is at {east} east, {north} north; allowed is up to {columns} east and {rows} north, cells"
    )]
    Place {
        /// The corner, from 1.
        index: usize,
        /// Cells east.
        east: f64,
        /// Cells north.
        north: f64,
        /// Columns of the map.
        columns: u32,
        /// Rows of the map.
        rows: u32,
    },
}

/// Cells whose centers lie inside a polygon or on its edge, by number, with the even-odd rule. Its last corner is
/// joined to its first.
///
/// # Errors
/// If the polygon is invalid, or lies off the map.
pub fn cells_within(grid: Grid, corners: &[Corner]) -> Result<Vec<Cell>, PolygonError> {
    if !(3..=MOST_CORNERS).contains(&corners.len()) {
        return Err(PolygonError::Corners(corners.len()));
    }
    let (columns, rows) = (grid.columns(), grid.rows());
    for (index, &[east, north]) in (1..).zip(corners) {
        if !((0.0..=f64::from(columns)).contains(&east) && (0.0..=f64::from(rows)).contains(&north)) {
            return Err(PolygonError::Place { index, east, north, columns, rows });
        }
    }
    if is_flat(corners) {
        return Err(PolygonError::Flat);
    }
    let bounds = |axis: usize| {
        let values = || corners.iter().map(move |corner| corner[axis]);
        values().fold(f64::INFINITY, f64::min)..=values().fold(0.0, f64::max)
    };
    let (easts, norths) = (bounds(0), bounds(1));
    let is_inside = |&cell: &Cell| {
        let Position { row, column } = grid.position(cell);
        let center = [f64::from(column) + 0.5, f64::from(row) + 0.5];
        easts.contains(&center[0]) && norths.contains(&center[1]) && surrounds(corners, center)
    };
    Ok(grid.cells().filter(is_inside).collect())
}

/// Whether a ray to the east crosses the outline an odd number of times, or the point lies on it.
/// Whether all corners are on one line.
fn is_flat(corners: &[Corner]) -> bool {
    let first = corners[0];
    let from_first = |corner: &Corner| [corner[0] - first[0], corner[1] - first[1]];
    let length = |[east, north]: &[f64; 2]| east.hypot(*north);
    let Some(along) = corners.iter().map(from_first).max_by(|a, b| length(a).total_cmp(&length(b))) else {
        return true;
    };
    let away = |to: [f64; 2]| (along[0] * to[1] - along[1] * to[0]).abs();
    corners.iter().map(from_first).all(|to| away(to) <= 1e-9 * length(&along))
}

fn surrounds(corners: &[Corner], point: Corner) -> bool {
    let mut is_inside = false;
    for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if is_on(a, b, point) {
            return true;
        }
        if (a[1] > point[1]) != (b[1] > point[1]) {
            let east = a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            is_inside ^= point[0] < east;
        }
    }
    is_inside
}

/// Whether a point lies on an edge, up to rounding.
fn is_on(a: Corner, b: Corner, point: Corner) -> bool {
    let [along, to] = [[b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]];
    let length = along[0].hypot(along[1]);
    let away = (along[0] * to[1] - along[1] * to[0]).abs();
    let reach = along[0] * to[0] + along[1] * to[1];
    if length == 0.0 {
        return to[0].hypot(to[1]) < 1e-9;
    }
    away < 1e-9 * length && (-1e-9..=length + 1e-9).contains(&(reach / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mentions::assert_mentions;

    fn drawing(corners: &[Corner]) -> String {
        let grid = Grid::new(4, 5).unwrap();
        let within = cells_within(grid, corners).unwrap();
        let line = |row| {
            let is_in = |column| within.contains(&grid.cell(Position { row, column }).unwrap());
            (0..5).map(|column| if is_in(column) { '#' } else { '.' }).collect::<String>()
        };
        (0..4).rev().map(line).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn cells_are_inside_whose_centers_are() {
        assert_eq!(drawing(&[[1.0, 1.0], [4.0, 1.0], [4.0, 3.0], [1.0, 3.0]]), ".....\n.###.\n.###.\n.....");
        assert_eq!(drawing(&[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]), "#....\n##...\n###..\n####.");
    }

    #[test]
    fn a_polygon_between_centers_takes_in_its_edge() {
        assert_eq!(drawing(&[[0.5, 0.5], [2.5, 0.5], [2.5, 2.5], [0.5, 2.5]]), ".....\n###..\n###..\n###..");
    }

    #[test]
    fn a_point_surrounded_twice_is_outside() {
        let cross = [[0.0, 0.0], [5.0, 4.0], [5.0, 0.0], [0.0, 4.0]];
        assert_eq!(
            drawing(&cross),
            "#....\n##.##\n##.##\n....#".replace("#....\n", "#...#\n").replace("....#", "#...#")
        );
    }

    #[test]
    fn an_invalid_polygon_is_rejected() {
        let grid = Grid::new(4, 5).unwrap();
        let refused = |corners: &[Corner]| cells_within(grid, corners).unwrap_err().to_string();
        assert_mentions(&refused(&[[0.0, 0.0], [1.0, 1.0]]), "2 corners .. 3 to 1000");
        assert_mentions(
            &refused(&[[0.0, 0.0], [5.5, 1.0], [1.0, 1.0]]),
            "corner 2 .. 5.5 east .. 5 east and 4 north",
        );
        for flat in [[[1.0, 1.0]; 3], [[0.0, 0.0], [4.0, 3.2], [2.0, 1.6]]] {
            assert_eq!(refused(&flat), "all corners are on one line, so that nothing is inside");
        }
        assert!(refused(&[[0.0, 0.0], [f64::NAN, 1.0], [1.0, 1.0]]).contains("corner 2"));
    }
}
