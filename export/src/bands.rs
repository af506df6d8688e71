//! Cleared cells as polygons, in bands of similar probability of detection.

use dragnet_scenario::map_file::Georeference;
use dragnet_search::cell::{Cell, Grid, Position};
use dragnet_search::terrain::Terrain;
use geo::orient::{Direction, Orient};
use geo::{MapCoords, MultiPolygon, Rect, unary_union};

/// Bounds of the bands; cells below the first are as good as not searched.
const EDGES: [f64; 5] = [0.1, 0.5, 0.8, 0.95, 1.0];

/// Cells of about the same probability of detection.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    /// The lower bound of the probability of detection, inclusive.
    pub from: f64,
    /// The upper bound, exclusive except for 1.
    pub to: f64,
    pub cells: usize,
    /// In degrees; outer rings counterclockwise.
    pub region: MultiPolygon<f64>,
}

impl Band {
    /// Number of bands.
    pub(crate) const COUNT: usize = EDGES.len() - 1;

    /// The index of the band, from 0 for the lowest probability.
    pub(crate) fn number(&self) -> usize {
        EDGES.iter().take_while(|&&edge| edge < self.from).count()
    }

    /// Such as `POD 50 to 80 %`.
    pub(crate) fn title(&self) -> String {
        if self.from <= 0.0 {
            return format!("Not searched: POD below {:.0} %", 100.0 * self.to);
        }
        format!("POD {:.0} to {:.0} %", 100.0 * self.from, 100.0 * self.to)
    }
}

/// The non-empty bands of a probability of detection of shape `[cells]`.
pub(crate) fn bands(terrain: &Terrain, frame: &Georeference, pod: &[f64]) -> Vec<Band> {
    EDGES.windows(2).filter_map(|pair| band(terrain, frame, pod, pair[0], pair[1])).collect()
}

/// What is as good as not searched, if there is any: all cells below the bands.
pub(crate) fn not_searched(terrain: &Terrain, frame: &Georeference, pod: &[f64]) -> Option<Band> {
    band(terrain, frame, pod, 0.0, EDGES[0])
}

fn band(terrain: &Terrain, frame: &Georeference, pod: &[f64], from: f64, to: f64) -> Option<Band> {
    let is_last = to >= 1.0;
    let is_in = |cell: Cell| {
        let pod = pod[cell.index()];
        terrain.is_searched(cell) && pod >= from && (pod < to || is_last)
    };
    let is_in: Vec<bool> = terrain.grid().cells().map(is_in).collect();
    let cells = is_in.iter().filter(|is_in| **is_in).count();
    (cells > 0).then(|| Band { from, to, cells, region: region(terrain, frame, &is_in) })
}

/// The outlines of marked cells, shape `[cells]`, in degrees; outer rings counterclockwise.
pub(crate) fn region(terrain: &Terrain, frame: &Georeference, is_in: &[bool]) -> MultiPolygon<f64> {
    outlines(terrain.grid(), is_in).map_coords(|corner| {
        let meters = (corner.x * terrain.cell_meters(), corner.y * terrain.cell_meters());
        let point = frame.point(meters);
        geo::Coord { x: point.longitude_degrees, y: point.latitude_degrees }
    })
}

/// The outlines of marked cells, in cells east and north of the grid's corner.
fn outlines(grid: Grid, is_in: &[bool]) -> MultiPolygon<f64> {
    let mut runs = Vec::new();
    let mut open: Option<(Position, Position)> = None;
    let mut close = |run: &mut Option<(Position, Position)>| {
        if let Some((first, last)) = run.take() {
            let low = (f64::from(first.column), f64::from(first.row));
            let high = (f64::from(last.column) + 1.0, f64::from(last.row) + 1.0);
            runs.push(Rect::new(low, high).to_polygon());
        }
    };
    for cell in grid.cells().filter(|cell| is_in[cell.index()]) {
        let here = grid.position(cell);
        match &mut open {
            Some((_, last)) if last.row == here.row && last.column + 1 == here.column => *last = here,
            _ => {
                close(&mut open);
                open = Some((here, here));
            }
        }
    }
    close(&mut open);
    // Corners are whole numbers but for the rounding of the union.
    let union = unary_union(&runs).map_coords(|it| geo::Coord { x: it.x.round(), y: it.y.round() });
    union.orient(Direction::Default)
}

#[cfg(test)]
mod tests {
    use geo::{Area, Validation};

    use super::*;

    fn drawn(drawing: &str) -> MultiPolygon<f64> {
        let terrain = Terrain::from_ascii(drawing, 1.0).unwrap();
        let is_in: Vec<bool> = terrain.grid().cells().map(|cell| terrain.is_searched(cell)).collect();
        outlines(terrain.grid(), &is_in)
    }

    #[test]
    fn outlines_go_around_cells_and_leave_holes() {
        let region = drawn(".....\n.###.\n.#.#.\n.###.\n.....");
        assert_eq!(region.0.len(), 2);
        assert!((region.unsigned_area() - 17.0).abs() < 1e-12);
        let corners: usize = region.iter().map(|it| it.exterior().0.len()).sum();
        assert_eq!(corners, 10, "no corner on a straight edge: {region:?}");
    }

    #[test]
    fn every_pattern_of_cells_becomes_valid_polygons_of_its_area() {
        let mut met_corners = 0;
        for pattern in 0..512_u32 {
            let row = |bits: u32| {
                (0..3).map(|bit| if bits >> bit & 1 == 1 { '.' } else { '#' }).collect::<String>()
            };
            let drawing = [row(pattern), row(pattern >> 3), row(pattern >> 6)].join("\n");
            let region = drawn(&drawing);
            assert!((region.unsigned_area() - f64::from(pattern.count_ones())).abs() < 1e-9, "{drawing}");
            assert!(region.iter().all(Validation::is_valid), "{drawing}");
            met_corners += u32::from(drawing == ".##\n#.#\n##.");
        }
        assert_eq!(met_corners, 1);
    }
}
