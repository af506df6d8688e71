//! Conversion of a map's pixels to cells.

use std::ops::Range;
use std::path::Path;

use dragnet_search::cell::{Grid, Position};
use dragnet_search::terrain::{Ground, Terrain};

use super::MapFileError;

mod walls;

/// The size of a map in pixels.
pub(super) struct Extent {
    pub(super) columns: u32,
    pub(super) rows: u32,
    /// Edge of a pixel.
    pub(super) pixel_meters: f64,
}

/// Pixels that are free or not.
pub(super) struct Raster {
    pub(super) extent: Extent,
    /// Shape `[rows * columns]`, row 0 south, column 0 west.
    pub(super) is_free: Vec<bool>,
}

impl Extent {
    /// The cells of an edge that cover all pixels.
    pub(super) fn grid(&self, file: &Path, cell_meters: f64) -> Result<Grid, MapFileError> {
        let pixels_per_cell = self.pixels_per_cell(file, cell_meters)?;
        let cells = |pixels: u32| whole_cells(f64::from(pixels) / pixels_per_cell);
        Grid::new(cells(self.rows), cells(self.columns))
            .map_err(|error| MapFileError::Terrain { file: file.to_owned(), source: error.into() })
    }

    /// At least 1; a whole number if the edges' ratio is one up to rounding.
    fn pixels_per_cell(&self, file: &Path, cell_meters: f64) -> Result<f64, MapFileError> {
        let ratio = cell_meters / self.pixel_meters;
        let whole = ratio.round();
        let ratio = if (ratio - whole).abs() < 1e-6 { whole } else { ratio };
        if ratio >= 1.0 {
            Ok(ratio)
        } else {
            let found = format!("{cell_meters:?} m");
            let allowed = format!("at least the map's pixel of {:?} m", self.pixel_meters);
            Err(MapFileError::value(file, "cell edge", found, allowed))
        }
    }
}

impl Raster {
    /// The terrain of cells of an edge: open where at least half of a cell's pixels are free, else blocked. Where a wall is
    /// thinner than a cell, open cells are searched and not entered, so that no path leads through it.
    ///
    /// Cells start at the south-western corner. A pixel belongs to the cell that holds its center; pixels missing
    /// beyond the northern or eastern edge count as not free.
    pub(super) fn terrain(&self, file: &Path, cell_meters: f64) -> Result<Terrain, MapFileError> {
        let grid = self.extent.grid(file, cell_meters)?;
        let pixels_per_cell = self.extent.pixels_per_cell(file, cell_meters)?;
        let mut ground: Vec<Ground> = grid
            .cells()
            .map(|cell| {
                let Position { row, column } = grid.position(cell);
                let rows = pixels_of(row, pixels_per_cell);
                let columns = pixels_of(column, pixels_per_cell);
                let all = (rows.end - rows.start).saturating_mul(columns.end - columns.start);
                if 2 * self.count_free(rows, columns) >= all { Ground::OPEN } else { Ground::BLOCKED }
            })
            .collect();
        let at_walls = self.cells_at_walls(grid, &ground, pixels_per_cell);
        for cell in &at_walls {
            ground[cell.index()] = Ground::OUT_OF_REACH;
        }
        let terrain = Terrain::new(grid, cell_meters, ground)
            .map_err(|source| MapFileError::Terrain { file: file.to_owned(), source })?;
        Ok(terrain.with_thin_walls(at_walls))
    }

    fn count_free(&self, rows: Range<u64>, columns: Range<u64>) -> u64 {
        let count = |row: u64| {
            let start = row * u64::from(self.extent.columns);
            let end = start + columns.end.min(u64::from(self.extent.columns));
            let pixels = to_index(start + columns.start)..to_index(end);
            self.is_free[pixels].iter().map(|&is_free| u64::from(is_free)).sum::<u64>()
        };
        (rows.start..rows.end.min(u64::from(self.extent.rows))).map(count).sum()
    }
}

/// The number of cells that cover a length; an excess by rounding is ignored.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates; Grid::new checks the number"
)]
pub(super) fn whole_cells(length_cells: f64) -> u32 {
    (length_cells - 1e-6).ceil().max(1.0) as u32
}

/// Pixels, from the map's southern or western edge, whose centers lie in a row or column of cells.
fn pixels_of(line: u32, pixels_per_cell: f64) -> Range<u64> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at least 0 and far below 2^53"
    )]
    let centers_before = |line: f64| (line * pixels_per_cell - 0.5).ceil().max(0.0) as u64;
    centers_before(f64::from(line))..centers_before(f64::from(line) + 1.0)
}

#[expect(clippy::cast_possible_truncation, reason = "an index of a list in memory")]
const fn to_index(pixel: u64) -> usize {
    pixel as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws `#` for blocked and `.` for free, the northern edge first; pixels of 1 m.
    pub(super) fn check(pixels: &str, cell_meters: f64, expected: &str) {
        let lines: Vec<&str> = pixels.split('/').collect();
        let raster = Raster {
            extent: Extent {
                columns: u32::try_from(lines[0].len()).unwrap(),
                rows: u32::try_from(lines.len()).unwrap(),
                pixel_meters: 1.0,
            },
            is_free: lines.iter().rev().flat_map(|line| line.chars().map(|c| c == '.')).collect(),
        };
        let terrain = raster.terrain(Path::new("test"), cell_meters).unwrap();
        let expected = Terrain::from_ascii(&expected.replace('/', "\n"), cell_meters).unwrap();
        assert!(terrain.is_equal_ground(&expected), "{pixels} in cells of {cell_meters} m: {terrain:?}");
    }

    #[test]
    fn half_of_the_pixels_open_a_cell() {
        check(".#/#.", 2.0, ".");
        check("##/#.", 2.0, "#");
        check("..##/..#./####/.#.#", 2.0, ".#/##");
    }

    #[test]
    fn a_cell_of_one_pixel_is_that_pixel() {
        check(".#./##.", 1.0, ".#./##.");
        check(".#./##.", 1.000_000_01, ".#./##.");
    }

    #[test]
    fn cells_start_in_the_south_west_and_missing_pixels_are_not_free() {
        check("###/#../#..", 2.0, "##/..");
        check(".../.../...", 2.0, ".#/..");
    }

    #[test]
    fn pixels_go_to_the_cell_of_their_center() {
        // Cells of 1.5 pixels hold one and two of them in turn: the center at 1.5 lies on an edge and goes east.
        check("..#", 1.5, "..");
        check(".##", 1.5, ".#");
    }
}
