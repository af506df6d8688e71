//! Cells that no-go areas close.

use dragnet_search::cell::{Cell, Grid};
use geo::{LineString, MapCoords};

use super::{Area, Purpose};
use crate::map_file::georeference::Georeference;
use crate::map_file::scanline::{covered_cells, each_touched};

/// Corners of a line or a ring, in cells east and north of a map's south-western corner.
type Line = Vec<(f64, f64)>;

impl Area {
    /// Calls back with each cell of a map that this area closes, some more than once: those that a polygon covers in part,
    /// or that a border or a line touches. None for an area of another purpose.
    pub(crate) fn each_closed(
        &self,
        frame: &Georeference,
        grid: Grid,
        cell_meters: f64,
        mut tell: impl FnMut(Cell),
    ) {
        let (region, lines) = self.barriers(frame, cell_meters);
        covered_cells(grid, &region)
            .into_iter()
            .filter(|&(_, share)| share > 0.0)
            .for_each(|(cell, _)| tell(cell));
        for line in region.iter().chain(&lines) {
            each_touched(grid, line, &mut tell);
        }
    }

    /// The number of its polygons and lines that lie beyond a map, and their total number, if it is a no-go area.
    pub(crate) fn barriers_beyond(
        &self,
        frame: &Georeference,
        grid: Grid,
        cell_meters: f64,
    ) -> (usize, usize) {
        let (_, lines) = self.barriers(frame, cell_meters);
        let outer = match &self.purpose {
            Purpose::NoGo(region, _) => {
                region.iter().map(|polygon| line(polygon.exterior(), frame, cell_meters))
            }
            _ => return (0, 0),
        };
        let all: Vec<Line> = outer.chain(lines).collect();
        let (columns, rows) = (f64::from(grid.columns()), f64::from(grid.rows()));
        let is_beyond = |line: &&Line| {
            line.iter().all(|corner| corner.0 < 0.0)
                || line.iter().all(|corner| corner.1 < 0.0)
                || line.iter().all(|corner| corner.0 > columns)
                || line.iter().all(|corner| corner.1 > rows)
        };
        (all.iter().filter(is_beyond).count(), all.len())
    }

    /// Rings of a no-go area, holes included, and its lines.
    fn barriers(&self, frame: &Georeference, cell_meters: f64) -> (Vec<Line>, Vec<Line>) {
        let Purpose::NoGo(region, lines) = &self.purpose else { return (Vec::new(), Vec::new()) };
        let region = super::prior::rings(&region.map_coords(|corner| frame.cells(corner, cell_meters)));
        (region, lines.0.iter().map(|barrier| line(barrier, frame, cell_meters)).collect())
    }
}

fn line(line: &LineString<f64>, frame: &Georeference, cell_meters: f64) -> Line {
    line.0.iter().map(|corner| frame.cells(*corner, cell_meters)).map(|it| (it.x, it.y)).collect()
}
