//! A probability by the distance from a place or from lines, on the cells of a map.
//!
//! Ground at equal distances is equally likely: the share `F(b) - F(a)` of the distances from `a` to `b` is spread evenly over
//! the searched ground that lies so far away. So the entered shares hold on any map, whatever the border of the search area, its
//! lakes and the size of its cells; distances at which nothing is searched are left out. A cell is equally likely everywhere, so
//! what is narrower than cells is spread over them.
//!
//! Ground is counted in parts of cells, which are sorted by their distance and put together to rings. A ring has at least
//! [`LEAST_PARTS`] parts, so that it is as wide as its ground says, and no ring reaches across one of the entered distances.

use dragnet_search::cell::{Cell, Position};
use dragnet_search::terrain::Terrain;

use super::quartiles::Quartiles;

/// A point of the map, meters east and north of its south-western corner.
pub(super) type Meters = (f64, f64);
/// A line between two points; a place if they are one.
pub(super) type Line = [Meters; 2];

/// Parts of a ring, at least.
const LEAST_PARTS: usize = 48;
/// Parts of all cells together, about, at most.
const MOST_PARTS: usize = 1 << 21;

/// Distances that rounding makes different, meters.
const SAME_METERS: f64 = 1e-6;

/// Part of a cell.
struct Part {
    meters: f64,
    /// Its share of the cell.
    area: f64,
    cell: Cell,
}

/// The mass of the distribution in each searched cell. A line of one point is a place.
pub(super) fn cells(terrain: &Terrain, lines: &[Line], quartiles: &Quartiles) -> Vec<(Cell, f64)> {
    let mut parts = parts(terrain, lines, quartiles);
    parts.sort_by(|a, b| a.meters.total_cmp(&b.meters).then(a.cell.cmp(&b.cell)));
    let mut mass = vec![0.0; terrain.grid().cell_count()];
    // The nearest ground may be far away: what lies before it is left out too.
    let nearest = parts.first().map_or(0.0, |part| part.meters);
    let first = if nearest > terrain.cell_meters() { nearest } else { 0.0 };
    let mut edges = quartiles.meters().into_iter().filter(|&edge| edge > first).peekable();
    let (mut begin, mut from) = (0, first);
    for end in 1..=parts.len() {
        let last = parts[end - 1].meters;
        let next = parts.get(end).map(|part| part.meters);
        let edge = edges.next_if(|&edge| next.is_some_and(|next| next > edge));
        // Parts at one distance are of one ring.
        let is_wide = end - begin >= LEAST_PARTS && next.is_none_or(|next| next > last + SAME_METERS);
        if edge.is_none() && next.is_some() && !is_wide {
            continue;
        }
        // Several entered distances may lie between two parts.
        let mut to = edge.unwrap_or_else(|| next.map_or(last, |next| f64::midpoint(last, next)));
        while let Some(edge) = edges.next_if(|&edge| next.is_some_and(|next| next > edge)) {
            to = edge;
        }
        let ring = &parts[begin..end];
        let area: f64 = ring.iter().map(|part| part.area).sum();
        let share = quartiles.share_within(to) - quartiles.share_within(from);
        for part in ring {
            mass[part.cell.index()] += share * part.area / area;
        }
        (begin, from) = (end, to);
    }
    terrain.searched_cells().map(|cell| (cell, mass[cell.index()])).filter(|(_, mass)| *mass > 0.0).collect()
}

/// The parts of all searched cells: the finer, the nearer the cell is compared with the entered distances.
fn parts(terrain: &Terrain, lines: &[Line], quartiles: &Quartiles) -> Vec<Part> {
    let cell_meters = terrain.cell_meters();
    let searched = terrain.searched_cells().count().max(1);
    let most = ((MOST_PARTS / searched) as f64).sqrt().clamp(1.0, 4.0).floor();
    let mut parts = Vec::new();
    nearest(terrain, lines, &mut |cell, Position { row, column }, lines| {
        let corner = (f64::from(column) * cell_meters, f64::from(row) * cell_meters);
        let middle = (corner.0 + cell_meters / 2.0, corner.1 + cell_meters / 2.0);
        // Cells that the first quartiles divide.
        let is_near =
            distance(lines, middle) < 3.0 * cell_meters && quartiles.meters()[1] < 8.0 * cell_meters;
        let count = if is_near { 16.0 } else { most };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 16")]
        let steps = count as u32;
        let at = |step: u32| (f64::from(step) + 0.5) / count * cell_meters;
        for north in 0..steps {
            for east in 0..steps {
                let meters = distance(lines, (corner.0 + at(east), corner.1 + at(north)));
                parts.push(Part { meters, area: 1.0 / (count * count), cell });
            }
        }
    });
    parts
}

/// Visits each searched cell with the lines that may be nearest to one of its points.
fn nearest(terrain: &Terrain, lines: &[Line], visit: &mut dyn FnMut(Cell, Position, &[Line])) {
    let grid = terrain.grid();
    let mut blocks = vec![([0, 0], [grid.rows(), grid.columns()], lines.to_vec())];
    while let Some((low, high, lines)) = blocks.pop() {
        let [rows, columns] = [0, 1].map(|axis| high[axis] - low[axis]);
        if rows == 0 || columns == 0 {
            continue;
        }
        let cell_meters = terrain.cell_meters();
        let middle = |axis: usize| f64::from(low[axis] + high[axis]) / 2.0 * cell_meters;
        let point = (middle(1), middle(0));
        let reach = 0.5 * cell_meters * f64::from(rows).hypot(f64::from(columns));
        let least = distance(&lines, point);
        // The distance from a line changes by at most the way between two points.
        let near: Vec<Line> =
            lines.iter().copied().filter(|line| distance(&[*line], point) <= least + 2.0 * reach).collect();
        if rows == 1 && columns == 1 {
            let position = Position { row: low[0], column: low[1] };
            if let Some(cell) = grid.cell(position).filter(|&cell| terrain.is_searched(cell)) {
                visit(cell, position, &near);
            }
            continue;
        }
        let split = [0, 1].map(|axis| low[axis] + (high[axis] - low[axis]).div_ceil(2));
        for (south, north) in [(low[0], split[0]), (split[0], high[0])] {
            for (west, east) in [(low[1], split[1]), (split[1], high[1])] {
                blocks.push(([south, west], [north, east], near.clone()));
            }
        }
    }
}

/// Distance of a point from the nearest of some lines, meters.
fn distance(lines: &[Line], (east, north): Meters) -> f64 {
    let one = |&[(from_east, from_north), (to_east, to_north)]: &Line| {
        let (along_east, along_north) = (to_east - from_east, to_north - from_north);
        let square = along_east * along_east + along_north * along_north;
        let along = (east - from_east) * along_east + (north - from_north) * along_north;
        let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
        (from_east + share * along_east - east).hypot(from_north + share * along_north - north)
    };
    lines.iter().map(one).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of this edge, meters, with a lake in it.
    fn terrain(side_meters: f64, cell_meters: f64) -> Terrain {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small map")]
        let cells = (side_meters / cell_meters).round() as usize;
        let of = |row: usize, column: usize| {
            let is_lake = (row * 10 / cells, column * 10 / cells) == (6, 6);
            if is_lake { '#' } else { '.' }
        };
        let rows: Vec<String> =
            (0..cells).map(|row| (0..cells).map(|column| of(row, column)).collect()).collect();
        Terrain::from_ascii(&rows.join("\n"), cell_meters).unwrap()
    }

    /// The mass within a distance: that of a cell is everywhere in it.
    fn within(terrain: &Terrain, mass: &[(Cell, f64)], lines: &[Line], meters: f64) -> f64 {
        let edge = terrain.cell_meters();
        let share = |cell: Cell| {
            let Position { row, column } = terrain.grid().position(cell);
            let at = |low: u32, step: u32| (f64::from(low) + (f64::from(step) + 0.5) / 8.0) * edge;
            let points = (0..8).flat_map(|north| (0..8).map(move |east| (north, east)));
            let inside = points
                .filter(|&(north, east)| distance(lines, (at(column, east), at(row, north))) <= meters)
                .count();
            inside as f64 / 64.0
        };
        mass.iter().map(|&(cell, mass)| mass * share(cell)).sum()
    }

    #[test]
    fn the_entered_shares_hold_in_cells_of_any_size() {
        let bend = [(800.0, 300.0), (1500.0, 2100.0), (3200.0, 2500.0)];
        let trail: Vec<Line> = bend.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let place = vec![[(1900.0, 1700.0); 2]];
        let at_border = vec![[(100.0, 60.0); 2]];
        for (lines, meters) in [
            (&trail, [60.0, 150.0, 350.0, 900.0]),
            (&trail, [100.0, 250.0, 700.0, 1000.0]),
            (&place, [200.0, 500.0, 900.0, 1700.0]),
            (&place, [400.0, 520.0, 800.0, 1600.0]),
            (&at_border, [300.0, 700.0, 1300.0, 2900.0]),
        ] {
            let quartiles = Quartiles::new(meters).unwrap();
            for cell_meters in [20.0, 40.0, 50.0] {
                let terrain = terrain(4000.0, cell_meters);
                let mass = cells(&terrain, lines, &quartiles);
                let whole: f64 = mass.iter().map(|(_, mass)| mass).sum();
                assert!((0.94..=1.0 + 1e-9).contains(&whole), "{whole}");
                for (distance, share) in meters.into_iter().zip([0.25, 0.5, 0.75, 0.95]) {
                    let given = within(&terrain, &mass, lines, distance);
                    assert!(
                        (given - share).abs() < 0.02,
                        "{meters:?} {cell_meters} m: {given} within {distance}"
                    );
                }
            }
        }
    }

    #[test]
    fn distances_before_the_searched_ground_are_left_out() {
        let quartiles = Quartiles::new([200.0, 500.0, 900.0, 2000.0]).unwrap();
        for (meters_outside, cell_meters) in [(300.0, 20.0), (300.0, 50.0), (1500.0, 50.0)] {
            let terrain = terrain(4000.0, cell_meters);
            let place = [[(-meters_outside, 2000.0); 2]];
            let mass = cells(&terrain, &place, &quartiles);
            let before = quartiles.share_within(meters_outside);
            for meters in [meters_outside + 200.0, 1700.0, 2000.0] {
                let (given, share) =
                    (within(&terrain, &mass, &place, meters), quartiles.share_within(meters));
                assert!(
                    (given - (share - before)).abs() < 0.03,
                    "{meters_outside} {meters}: {given} {share} {before}"
                );
            }
            let nearest = within(&terrain, &mass, &place, meters_outside + 2.0 * cell_meters);
            assert!(nearest < 0.15, "nothing piles up at the border: {nearest}");
        }
    }

    #[test]
    fn cells_at_equal_distances_are_equally_likely() {
        let terrain = terrain(2000.0, 20.0);
        let quartiles = Quartiles::new([100.0, 300.0, 600.0, 900.0]).unwrap();
        let mass = cells(&terrain, &[[(-1e5, 1000.0), (1e5, 1000.0)]], &quartiles);
        let of = |row: u32, column: u32| {
            let cell = terrain.grid().cell(Position { row, column }).unwrap();
            mass.iter().find(|(known, _)| *known == cell).map_or(0.0, |(_, mass)| *mass)
        };
        for row in [3, 30, 48, 49, 55] {
            let along: Vec<f64> = (0..100).map(|column| of(row, column)).filter(|&mass| mass > 0.0).collect();
            let mean = along.iter().sum::<f64>() / along.len() as f64;
            assert!(along.iter().all(|mass| (mass / mean - 1.0).abs() < 0.25), "row {row}: {along:?}");
            let mirrored = of(99 - row, 5);
            assert!((mirrored / of(row, 5) - 1.0).abs() < 0.25, "row {row}");
        }
    }

    #[test]
    fn distances_far_below_a_cell_are_in_that_cell() {
        let terrain = terrain(4000.0, 100.0);
        let quartiles = Quartiles::new([1.0, 2.0, 4.0, 9.0]).unwrap();
        let mass = cells(&terrain, &[[(1950.0, 1950.0); 2]], &quartiles);
        let most = mass.iter().map(|(_, mass)| *mass).fold(0.0, f64::max);
        assert!(most > 0.95, "{most}");
    }
}
