//! The share of each cell that lies inside an outline: even-odd scanlines, exact along each line.

use dragnet_search::cell::{Cell, Grid, Position};

/// Scanlines through each row of cells. Along a line the covered length is exact; across, a row is the mean
/// of its lines, so that a straight edge is off by less than 1/32 of a cell's area.
const LINES_PER_ROW: u32 = 16;

/// A straight piece of an outline, in cells east and north of the grid's south-western corner, its lower end
/// first.
#[derive(Clone, Copy, Debug)]
struct Edge {
    from: (f64, f64),
    to: (f64, f64),
}

impl Edge {
    fn east_at(&self, north: f64) -> f64 {
        let share = (north - self.from.1) / (self.to.1 - self.from.1);
        self.from.0 + share * (self.to.0 - self.from.0)
    }

    /// The same, clamped to the edge; for a level edge either end.
    fn east_within(&self, north: f64) -> f64 {
        if north <= self.from.1 {
            self.from.0
        } else if north >= self.to.1 {
            self.to.0
        } else {
            self.east_at(north)
        }
    }
}

/// Cells that closed rings cover in part, by index, each with its share, 0 to 1; some shares may be 0. Rings as in
/// [`covered_shares`].
pub(super) fn covered_cells(grid: Grid, rings: &[Vec<(f64, f64)>]) -> Vec<(Cell, f64)> {
    let Some((corner, window)) = window(grid, rings) else { return Vec::new() };
    let (east, north) = (f64::from(corner.column), f64::from(corner.row));
    let shifted: Vec<Vec<(f64, f64)>> =
        rings.iter().map(|ring| ring.iter().map(|&(x, y)| (x - east, y - north)).collect()).collect();
    let shares = covered_shares(window, &shifted);
    let cells = window.cells().map(|cell| {
        let Position { row, column } = window.position(cell);
        grid.cell(Position { row: row + corner.row, column: column + corner.column })
    });
    cells.zip(shares).filter_map(|(cell, share)| Some((cell?, share))).collect()
}

/// The part of a grid around rings: its south-western cell, and its size. `None` if they lie beside the grid.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
fn window(grid: Grid, rings: &[Vec<(f64, f64)>]) -> Option<(Position, Grid)> {
    let span = |values: &dyn Fn(&(f64, f64)) -> f64, count: u32| {
        let values = || rings.iter().flatten().map(values);
        let low = values().fold(f64::INFINITY, f64::min).floor().clamp(0.0, f64::from(count));
        let high = values().fold(f64::NEG_INFINITY, f64::max).ceil().clamp(0.0, f64::from(count));
        (low as u32, high as u32)
    };
    let (west, east) = span(&|corner| corner.0, grid.columns());
    let (south, north) = span(&|corner| corner.1, grid.rows());
    let size = Grid::new(north.checked_sub(south)?, east.checked_sub(west)?).ok()?;
    Some((Position { row: south, column: west }, size))
}

/// Calls back with every cell that a line touches, some more than once; corners are in cells east and north of the grid's
/// south-western corner. Shapes thinner than the distance of scanlines are not missed.
pub(super) fn each_touched(grid: Grid, line: &[(f64, f64)], mut tell: impl FnMut(Cell)) {
    for pair in line.windows(2) {
        let (low, high) = if pair[0].1 <= pair[1].1 { (pair[0], pair[1]) } else { (pair[1], pair[0]) };
        let edge = Edge { from: low, to: high };
        let (south, north) = (low.1.floor().max(0.0), high.1.min(f64::from(grid.rows())));
        let mut row = south;
        while row <= north {
            let ends = [edge.east_within(row), edge.east_within(row + 1.0)];
            let (west, east) = (ends[0].min(ends[1]).floor().max(0.0), ends[0].max(ends[1]));
            let mut column = west;
            while column <= east.min(f64::from(grid.columns())) {
                if let Some(cell) = grid.cell_at(column, row) {
                    tell(cell);
                }
                column += 1.0;
            }
            row += 1.0;
        }
    }
}

/// Share of each cell that lies inside closed rings, shape `[cells]`, 0 to 1, by the even-odd rule, so that holes are
/// excluded. Rings are in cells east and north of the grid's south-western corner.
pub(super) fn covered_shares(grid: Grid, rings: &[Vec<(f64, f64)>]) -> Vec<f64> {
    let mut waiting = edges_from_south(rings).into_iter().peekable();
    let mut active: Vec<Edge> = Vec::new();
    let mut crossings = Vec::new();
    let mut shares = vec![0.0; grid.cell_count()];
    for row in 0..grid.rows() {
        let cells = cells_of(grid, row);
        for line in 0..LINES_PER_ROW {
            let north = f64::from(row) + (f64::from(line) + 0.5) / f64::from(LINES_PER_ROW);
            while let Some(edge) = waiting.next_if(|edge| edge.from.1 <= north) {
                active.push(edge);
            }
            active.retain(|edge| edge.to.1 > north);
            crossings.clear();
            crossings.extend(active.iter().map(|edge| edge.east_at(north)));
            crossings.sort_unstable_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                add_span(&mut shares[cells.clone()], pair[0], pair[1]);
            }
        }
    }
    shares
}

/// Edges by their southern end; level ones cross no scanline.
fn edges_from_south(rings: &[Vec<(f64, f64)>]) -> Vec<Edge> {
    let mut edges: Vec<Edge> = rings
        .iter()
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
        .filter(|(a, b)| a.1.total_cmp(&b.1).is_ne())
        .map(|(&a, &b)| if a.1 < b.1 { Edge { from: a, to: b } } else { Edge { from: b, to: a } })
        .collect();
    edges.sort_unstable_by(|a, b| a.from.1.total_cmp(&b.from.1));
    edges
}

fn cells_of(grid: Grid, row: u32) -> std::ops::Range<usize> {
    let start = grid.cell(Position { row, column: 0 }).map_or(0, dragnet_search::cell::Cell::index);
    start..start + grid.columns() as usize
}

/// Adds the length of a span (cells) to the share of each cell in a row.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the row")]
fn add_span(row: &mut [f64], west: f64, east: f64) {
    let (west, east) = (west.clamp(0.0, row.len() as f64), east.clamp(0.0, row.len() as f64));
    let first = (west.floor() as usize).min(row.len() - 1);
    let last = (east.floor() as usize).min(row.len() - 1);
    for (column, share) in (first..=last).zip(&mut row[first..=last]) {
        let inside = east.min(column as f64 + 1.0) - west.max(column as f64);
        *share += inside.max(0.0) / f64::from(LINES_PER_ROW);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(rings: &[Vec<(f64, f64)>], rows: u32, columns: u32, expected: &[f64]) {
        let shares = covered_shares(Grid::new(rows, columns).unwrap(), rings);
        assert_eq!(shares.len(), expected.len());
        for (share, expected) in shares.iter().zip(expected) {
            assert!((share - expected).abs() < 1e-9, "{shares:?}");
        }
    }

    #[test]
    fn a_square_covers_its_share_of_each_cell() {
        let square = vec![(0.5, 0.5), (1.75, 0.5), (1.75, 2.0), (0.5, 2.0)];
        check(std::slice::from_ref(&square), 2, 2, &[0.25, 0.375, 0.5, 0.75]);
        let backwards = square.into_iter().rev().collect();
        check(&[backwards], 2, 2, &[0.25, 0.375, 0.5, 0.75]);
    }

    #[test]
    fn a_triangle_covers_half_of_its_box() {
        check(&[vec![(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)]], 2, 2, &[1.0, 0.5, 0.5, 0.0]);
    }

    #[test]
    fn a_window_of_a_grid_has_the_shares_of_the_whole() {
        let grid = Grid::new(7, 9).unwrap();
        for (east, north) in [(0.0, 0.0), (3.3, 2.6), (-1.2, 5.5), (7.5, -0.5), (20.0, 3.0)] {
            let ring = vec![(east, north), (east + 2.4, north + 0.3), (east + 0.7, north + 1.9)];
            let shares = covered_shares(grid, std::slice::from_ref(&ring));
            let mut windowed = vec![0.0; grid.cell_count()];
            for (cell, share) in covered_cells(grid, &[ring]) {
                windowed[cell.index()] = share;
            }
            for (a, b) in shares.iter().zip(&windowed) {
                assert!((a - b).abs() < 1e-12, "{east} {north}");
            }
        }
    }

    #[test]
    fn a_line_touches_every_cell_that_it_crosses() {
        let grid = Grid::new(3, 4).unwrap();
        let drawn = |line: &[(f64, f64)]| {
            let mut is_touched = vec![false; grid.cell_count()];
            each_touched(grid, line, |cell| is_touched[cell.index()] = true);
            let row = |cells: &[bool]| cells.iter().map(|&it| if it { 'x' } else { '.' }).collect::<String>();
            is_touched.chunks(4).rev().map(row).collect::<Vec<_>>().join("/")
        };
        assert_eq!(drawn(&[(0.5, 0.5), (3.5, 1.4)]), "..../..xx/xxx.");
        assert_eq!(drawn(&[(1.2, 2.9), (1.4, 0.1)]), ".x../.x../.x..");
        assert_eq!(drawn(&[(0.1, 1.5), (3.9, 1.5)]), "..../xxxx/....");
        assert_eq!(drawn(&[(0.1, 1.0), (3.9, 1.0)]), "..../xxxx/....");
        assert_eq!(drawn(&[(-5.0, 2.5), (1.5, 2.5), (1.5, 9.0)]), "xx../..../....");
        assert_eq!(drawn(&[(2.1, 1.1), (2.1, 1.1)]), "..../..x./....");
        assert_eq!(drawn(&[(9.0, 9.0), (8.0, 12.0)]), "..../..../....");
    }

    #[test]
    fn holes_and_islands_in_them_alternate() {
        let square = |inset: f64| {
            let (low, high) = (inset, 5.0 - inset);
            vec![(low, low), (high, low), (high, high), (low, high)]
        };
        let shares = covered_shares(Grid::new(5, 5).unwrap(), &[square(0.0), square(1.0), square(2.0)]);
        assert!((shares.iter().sum::<f64>() - (25.0 - 9.0 + 1.0)).abs() < 1e-9);
        assert!(shares[6].abs() < 1e-9 && (shares[12] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_point_on_a_scanline_is_crossed_once() {
        let line = 0.5 / f64::from(LINES_PER_ROW);
        check(
            &[vec![(0.0, -1.0), (0.5, line), (0.0, 2.0), (-1.0, line)]],
            1,
            1,
            &[(0..16)
                .map(|i| {
                    let north = (f64::from(i) + 0.5) / 16.0;
                    0.5 * (2.0 - north) / (2.0 - line)
                })
                .sum::<f64>()
                / 16.0],
        );
    }
}
