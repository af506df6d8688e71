//! Keep-out masks of Nav2: maps of the same format, beside a ROS map, whose occupied pixels no robot enters.
//!
//! A mask has a size, a resolution and an origin of its own, in the frame of the map. As Nav2's `KeepoutFilter` with its usual
//! parameters, this closes what `map_server` makes 100 of, and nothing that it makes unknown. Departure: what lies between, with
//! which Nav2 makes ways dearer, is ignored. As with a no-go area, no robot enters a cell that such a pixel touches; what would
//! be open is still searched, from other cells.

use std::path::Path;

use dragnet_search::cell::{Grid, Position};
use dragnet_search::terrain::Ground;

use super::ros;
use super::{MapFile, MapFileError, MapOrigin};

/// Turned by less, a mask and its map have one orientation, radians.
const LEAST_TURN: f64 = 1e-6;
/// Share of a cell by which a pixel that only meets its edge may lie in it, by rounding.
const ROUNDING: f64 = 1e-6;

/// Closes the cells of a map that the keep-out pixels of a mask touch.
///
/// # Errors
/// If the mask cannot be read, is turned against the map, or if none of its keep-out pixels lies on the map.
pub(super) fn close(map: MapFile, file: &Path) -> Result<MapFile, MapFileError> {
    let mask = ros::mask(file)?;
    let turn = mask.origin.yaw_radians - map.origin.yaw_radians;
    if turn.sin().abs() > LEAST_TURN || turn.cos() < 0.0 {
        let found = format!("a mask turned by {} rad", mask.origin.yaw_radians);
        let allowed = format!("the yaw of the map, {} rad", map.origin.yaw_radians);
        return Err(MapFileError::value(file, "origin", found, allowed));
    }
    let (terrain, grid) = (&map.terrain, map.terrain.grid());
    let corner = corner_on_map(map.origin, mask.origin).map(|meters| meters / terrain.cell_meters());
    let pixel = mask.extent.pixel_meters / terrain.cell_meters();
    let mut closed = vec![false; grid.cell_count()];
    let kept_out = || (0_u32..).zip(&mask.is_occupied).filter(|(_, is_occupied)| **is_occupied);
    for (number, _) in kept_out() {
        let [row, column] = [number / mask.extent.columns, number % mask.extent.columns];
        let rows = touched(corner[1] + f64::from(row) * pixel, pixel, grid.rows());
        let columns = touched(corner[0] + f64::from(column) * pixel, pixel, grid.columns());
        for cell in rows.flat_map(|row| columns.clone().map(move |column| Position { row, column })) {
            if let Some(cell) = grid.cell(cell) {
                closed[cell.index()] = true;
            }
        }
    }
    if kept_out().next().is_some() && !closed.contains(&true) {
        let found = "keep-out pixels beside the map only";
        return Err(MapFileError::value(file, "the mask", found, on_map(&map, grid)));
    }
    let closed = grid.cells().filter(|cell| closed[cell.index()]);
    let ground = closed.map(|cell| (cell, Ground { traversable: false, ..terrain.ground(cell) }));
    Ok(MapFile { terrain: terrain.with_ground(ground), ..map })
}

/// Where the mask's corner lies, meters along the map's rows and up its columns.
fn corner_on_map(map: MapOrigin, mask: MapOrigin) -> [f64; 2] {
    let (x, y) = (mask.x_meters - map.x_meters, mask.y_meters - map.y_meters);
    let (sine, cosine) = map.yaw_radians.sin_cos();
    [cosine * x + sine * y, cosine * y - sine * x]
}

/// Rows or columns of cells that a pixel touches, given where it begins and how long it is, in cells.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "within 0 and the number of cells"
)]
fn touched(from: f64, length: f64, cells: u32) -> std::ops::Range<u32> {
    let rounding = ROUNDING.min(length / 4.0);
    let within = |line: f64| line.clamp(0.0, f64::from(cells)) as u32;
    within((from + rounding).floor())..within((from + length - rounding).ceil())
}

fn on_map(map: &MapFile, grid: Grid) -> String {
    let cell_meters = map.terrain.cell_meters();
    let [along, up] = [grid.columns(), grid.rows()].map(|cells| f64::from(cells) * cell_meters);
    format!("at least one on it: {along} by {up} m from {}", map.origin)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use dragnet_search::terrain::Terrain;

    use super::*;
    use crate::mentions::assert_mentions;

    /// The map of an image of 4 x 2 free pixels of 0.5 m in cells of 1 m or 0.5 m, with a mask.
    fn masked(cell_meters: f64, mask: &str, image: &str) -> Result<Terrain, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        let header = |name: &str, rest: &str| {
            format!("image: {name}\n{rest}\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n")
        };
        let free = ["255"; 8].join(" ");
        fs::write(file("map.yaml"), header("map.pgm", "resolution: 0.5\norigin: [-1, 2, 0]")).unwrap();
        fs::write(file("map.pgm"), format!("P2 4 2 255  {free}")).unwrap();
        fs::write(file("mask.yaml"), header("mask.pgm", mask)).unwrap();
        fs::write(file("mask.pgm"), image).unwrap();
        let map = MapFile::load(&file("map.yaml"), cell_meters).unwrap();
        close(map, &file("mask.yaml")).map(|map| map.terrain).map_err(|error| error.to_string())
    }

    #[test]
    fn cells_that_keep_out_pixels_touch_are_searched_and_not_entered() {
        let same = "resolution: 0.5\norigin: [-1, 2, 0]";
        let drawn = |text: &str, cell_meters| Ok(Terrain::from_ascii(text, cell_meters).unwrap());
        // Free, of some cost, and unknown pixels close nothing.
        assert_eq!(masked(0.5, same, "P2 4 2 255  255 0 255 255  128 255 200 0"), drawn(".~..\n...~", 0.5));
        assert_eq!(masked(1.0, same, "P2 4 2 255  255 0 255 255  255 255 255 255"), drawn("~.", 1.0));
        let shifted = "resolution: 0.25\norigin: [0.5, 2.25, 0]";
        assert_eq!(masked(0.5, shifted, "P2 2 1 255  0 255"), drawn("....\n...~", 0.5));
        let coarse = "resolution: 0.6\norigin: [-0.5, 2.5, 0]";
        assert_eq!(masked(0.5, coarse, "P2 1 1 255  0"), drawn(".~~.\n....", 0.5));
        let larger = "resolution: 5.0\norigin: [-3, 0, 0]";
        assert_eq!(masked(0.5, larger, "P2 1 1 255  0"), drawn("~~~~\n~~~~", 0.5));
        assert_eq!(masked(0.5, larger, "P2 1 1 255  255"), drawn("....\n....", 0.5), "a mask may be empty");
    }

    #[test]
    fn pixels_by_mode_are_those_that_map_server_makes_100_of() {
        let with = |mode: &str| format!("resolution: 0.5\norigin: [-1, 2, 0]\nmode: {mode}");
        // Occupancy 0.647, 0.651, 1 and 0.
        let image = "P2 4 1 255  90 89 0 255";
        let drawn = |text: &str| Ok(Terrain::from_ascii(text, 0.5).unwrap());
        assert_eq!(masked(0.5, &with("trinary"), image), drawn("....\n.~~."));
        assert_eq!(masked(0.5, &with("scale"), image), drawn("....\n.~~."));
        assert_eq!(masked(0.5, &with("raw"), "P2 4 1 255  0 99 100 255"), drawn("....\n..~."));
    }

    #[test]
    fn a_mask_of_a_turned_map_lies_where_the_map_does() {
        let map = MapOrigin { x_meters: 3.0, y_meters: -1.0, yaw_radians: 0.7 };
        let (x_meters, y_meters) = map.point((2.5, 4.0));
        let [along, up] = corner_on_map(map, MapOrigin { x_meters, y_meters, ..map });
        assert!((along - 2.5).abs() < 1e-12 && (up - 4.0).abs() < 1e-12, "{along} {up}");
    }

    #[test]
    fn a_mask_elsewhere_or_turned_is_rejected() {
        let error = masked(0.5, "resolution: 0.5\norigin: [9, 9, 0]", "P2 1 1 255  0").unwrap_err();
        assert_mentions(&error, "mask.yaml .. beside the map .. 2 by 1 m from (-1, 2) m");
        let error = masked(0.5, "resolution: 0.5\norigin: [-1, 2, 0.1]", "P2 1 1 255  0").unwrap_err();
        assert_mentions(&error, "mask.yaml: origin .. 0.1 rad .. 0 rad");
    }
}
