//! An upper bound of the utility of each path, for the price of a few additions a cell.
//!
//! A robot that enters a cell sees at most a *front* of cells that it did not see from the cell before: those at the
//! edge of its footprint, `2 radius + 1` for a diamond. If all that comes into view became certain at once, the utility
//! of a path would be the sum of what the cells of its first footprint and of all its fronts can yield. So
//!
//! `U(path to x) <= B(x) = B(parent of x) + sum over the front of x of (U_c(certain) - U_c(k_c))`
//!
//! with `k_c` the precision that teammates plan for cell `c`. A front lies on two diagonals, so its sum takes four numbers
//! of two tables of sums along diagonals. Where walls hide something from `x` or from its parent, what comes into view
//! ([`Views::coming_into_view`]) is added up cell by cell.

use crate::cell::{Offset, Position};
use crate::line_of_sight::Views;
use crate::route::{Connectivity, ShortestPathTree};
use crate::situation::Situation;
use crate::utility_gain::UtilityGain;

/// Sums of what cells can yield along diagonals.
struct Diagonals {
    /// Radius of the footprint.
    radius: isize,
    /// Cells of a row: the map's, with `radius + 1` more on each side.
    stride: isize,
    margin: usize,
    /// Of each cell and all south-west of it.
    north_east: Vec<f64>,
    /// Of each cell and all south-east of it.
    north_west: Vec<f64>,
}

impl Diagonals {
    #[expect(clippy::cast_possible_wrap, reason = "a map has fewer than 2^31 cells")]
    fn new(situation: &Situation<'_>, gain: &UtilityGain<'_>) -> Self {
        let (grid, radius) = (situation.terrain.grid(), situation.sensor.radius() as usize);
        let (rows, columns) = (grid.rows() as usize, grid.columns() as usize);
        let margin = radius + 1;
        let stride = columns + 2 * margin;
        let mut left = vec![0.0; (rows + 2 * margin) * stride];
        for (row, of_row) in gain.left().enumerate() {
            let start = (row + margin) * stride + margin;
            for (left, of_cell) in left[start..][..columns].iter_mut().zip(of_row) {
                *left = f64::from(of_cell);
            }
        }
        let (mut north_east, mut north_west) = (left.clone(), left);
        for index in stride + 1..north_east.len() {
            north_east[index] += north_east[index - stride - 1];
            north_west[index] += north_west[index - stride + 1];
        }
        Self { radius: radius as isize, stride: stride as isize, margin, north_east, north_west }
    }

    /// The sum over the front of a cell that is entered by this straight move.
    fn front(&self, cell: Position, entered: Offset) -> f64 {
        let at = self.index(cell);
        let radius = self.radius;
        // The corners of the footprint ahead and on both sides.
        let (north, east) = (entered.north as isize, entered.east as isize);
        let ahead = (north * radius, east * radius);
        let sides = if north == 0 { [(radius, 0), (-radius, 0)] } else { [(0, radius), (0, -radius)] };
        let arms: f64 = sides.into_iter().map(|side| self.edge(at, side, ahead)).sum();
        // Both arms end in the corner ahead.
        arms - self.edge(at, ahead, ahead)
    }

    /// The sum from one corner of the footprint around a place to another, along a diagonal, with both.
    #[inline]
    fn edge(&self, at: usize, from: (isize, isize), to: (isize, isize)) -> f64 {
        let (south, north) = if from.0 <= to.0 { (from, to) } else { (to, from) };
        let (sums, back) = if south.1 <= north.1 {
            (&self.north_east, (south.0 - 1, south.1 - 1))
        } else {
            (&self.north_west, (south.0 - 1, south.1 + 1))
        };
        let of = |(north, east): (isize, isize)| sums[at.wrapping_add_signed(north * self.stride + east)];
        of(north) - of(back)
    }

    fn index(&self, Position { row, column }: Position) -> usize {
        (row as usize + self.margin) * self.stride.unsigned_abs() + column as usize + self.margin
    }
}

/// An upper bound of the utility of the path to each candidate, shape `[cells]`, where moves are straight: `None` with
/// diagonal ones.
pub(super) fn of_paths(
    situation: &Situation<'_>,
    gain: &UtilityGain<'_>,
    routes: &ShortestPathTree,
) -> Option<Vec<f64>> {
    if situation.connectivity != Connectivity::Four {
        return None;
    }
    let (grid, frame) = (situation.terrain.grid(), gain.frame());
    let diagonals = Diagonals::new(situation, gain);
    let views = Views::of(situation).map(|views| {
        let steps = views.by_place(situation.sensor, |it| frame.stride_of(it.offset));
        (views, steps)
    });
    let mut bounds = vec![0.0; grid.cell_count()];
    for &cell in routes.candidates() {
        let parent = routes.parent(cell);
        if parent == routes.root() {
            let seen = situation.terrain.in_sight(situation.sensor, cell);
            bounds[cell.index()] = gain.left_in(seen.map(|(cell, _)| frame.index(cell)));
            continue;
        }
        let entered = grid.offset(parent, cell);
        let is_limited = |(views, _): &&(Views<'_>, _)| views.is_limited(parent) || views.is_limited(cell);
        let new = match views.as_ref().filter(is_limited) {
            None => diagonals.front(grid.position(cell), entered),
            Some((views, steps)) => {
                let (new, at) = (views.coming_into_view(parent, entered, cell), frame.index(cell));
                gain.left_in(new.map(|place| at.wrapping_add_signed(steps[place])))
            }
        };
        bounds[cell.index()] = bounds[parent.index()] + new;
    }
    Some(bounds)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::RngExt;

    use super::super::{LEAST_NATS, ROUNDING, runs, utilities};
    use super::*;
    use crate::belief::Belief;
    use crate::cell::{Cell, Grid};
    use crate::intent::PlannedPrecision;
    use crate::seed::{Purpose, stream};
    use crate::sensor::{Noise, Sensor};
    use crate::terrain::{Ground, Terrain};

    /// Checks the bounds of a random map of this size; one cell in `blocked` is an obstacle.
    fn check(radius: u32, rows: u32, columns: u32, blocked: f64, seed: u64) {
        let grid = Grid::new(rows, columns).unwrap();
        let mut random = stream(seed, Purpose::Start, 1);
        let cells: Vec<Cell> = grid.cells().collect();
        let robot = cells[random.random_range(0..cells.len())];
        let is_open = |cell: Cell, draw: f64| cell == robot || draw >= blocked;
        let ground = grid
            .cells()
            .map(|cell| if is_open(cell, random.random()) { Ground::OPEN } else { Ground::BLOCKED });
        let terrain = Terrain::new(grid, 1.0, ground.collect()).unwrap();
        let terrain = if seed.is_multiple_of(2) { terrain.with_opaque_walls(radius) } else { terrain };
        let log_odds = grid.cells().map(|_| random.random_range(-9.0..9.0)).collect();
        let belief = Belief::from_log_odds(&terrain, log_odds).unwrap();
        let sensor = Sensor::new(radius, 0.005, Noise::Gaussian).unwrap();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        let planned: Vec<Cell> = cells.iter().copied().filter(|_| random.random_bool(0.05)).collect();
        planned_precision.add_path(&terrain, &sensor, &planned);
        let situation = Situation::alone(&terrain, &sensor, &belief, &planned_precision, robot);
        let routes = ShortestPathTree::from(&terrain, Connectivity::Four, robot);
        let mut gain = UtilityGain::information(&situation);
        let bounds = of_paths(&situation, &gain, &routes).unwrap();

        let left: Vec<f32> = gain.left().flatten().collect();
        let is_in_view = |from, cell| {
            let offset = grid.offset(from, cell);
            offset.manhattan() <= radius && !terrain.line_of_sight().hides(from, offset)
        };
        for &cell in routes.candidates() {
            let parent = routes.parent(cell);
            let (before, is_seen): (f64, &dyn Fn(Cell) -> bool) = if parent == robot {
                (0.0, &|_| false)
            } else {
                (bounds[parent.index()], &|it| is_in_view(parent, it))
            };
            let new = cells.iter().filter(|&&it| is_in_view(cell, it) && !is_seen(it));
            let front: f64 = new.map(|it| f64::from(left[it.index()])).sum();
            let error = (bounds[cell.index()] - before - front).abs();
            assert!(error < 1e-9, "{error} in {cell:?}");
        }

        let kinds = runs::walked(&routes, cells.len());
        let utility = utilities(&situation, &mut gain, &routes, &kinds);
        for &cell in routes.candidates() {
            let bound = bounds[cell.index()] * ROUNDING + LEAST_NATS;
            assert!(f64::from(utility[cell.index()]) <= bound, "{} {bound}", utility[cell.index()]);
        }
    }

    proptest! {
        #[test]
        fn no_path_is_worth_more_than_its_first_view_and_its_fronts(
            radius in 1_u32..5, rows in 1_u32..20, columns in 1_u32..20, blocked in 0.0..0.4, seed in any::<u64>(),
        ) {
            check(radius, rows, columns, blocked, seed);
        }
    }
}
