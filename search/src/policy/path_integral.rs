//! The joint information of all observations along a path.
//!
//! Paper, Eq. 3 read with its text ("after assimilating all en-route observations"), weighted by Eq. 4. Readings of one
//! cell are independent given its state, so the joint information of a path is exactly `U(x) = sum_c I(L_c, k_c(path))`
//! with `k_c` the summed precision. One depth-first traversal of the tree of shortest paths adds precision on descent
//! and restores it on return: every candidate is scored exactly, and no path is traversed twice. Most candidates of a
//! large map lie on straight runs ([`runs`]), where the gain of the last observation needs no traversal ([`stencil`]).
//! Departure: the observation from the robot's own cell is not part of the path, since it has already been made.

mod bound;
mod runs;
mod stencil;

use runs::Kind;

use super::{Decision, LEAST_NATS, Policy, path_length_weight};
use crate::cell::Cell;
use crate::line_of_sight::Views;
use crate::route::ShortestPathTree;
use crate::seed::Stream;
use crate::sensor::FootprintCell;
use crate::situation::Situation;
use crate::utility::{SATURATION, Tables, Utility, UtilityTable};
use crate::utility_gain::{CellGain, Frame, UtilityGain, saturated};

pub(super) struct Path {
    path_length_weight: f64,
    tables: Tables,
}

impl Path {
    pub(super) const fn new(path_length_weight: f64, utility: Utility) -> Self {
        Self { path_length_weight, tables: Tables::new(utility) }
    }
}

impl Policy for Path {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = situation.routes();
        let mut gain = UtilityGain::new(self.tables.of(situation), situation);
        best_within(situation, self.path_length_weight, &mut gain, &routes)
    }

    /// Exact, by bounds: the information gain of a path is at most that of all cells together, and its weight falls with
    /// its length. Near candidates are scored first. Then, if a longer path could score more than the best of them, the
    /// path is scored that promises most by its own bound ([`bound`]), and then all whose bound promises more than that
    /// holds, up to the length from which none can.
    fn choose(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let mut gain = UtilityGain::new(self.tables.of(situation), situation);
        let most = gain.most() * ROUNDING + LEAST_NATS;
        let weight = |length| path_length_weight(self.path_length_weight, length);
        let within = |longest| situation.routes_within(longest);
        let near = FIRST_RADII * situation.sensor.radius().max(1) as f32;
        let routes = within(near);
        let decision = best_within(situation, self.path_length_weight, &mut gain, &routes);
        let mut best = decision.scores[decision.chosen.index()].max(LEAST_NATS / ROUNDING);
        if weight(near) * most < best || !routes.is_cut() {
            return decision;
        }
        let reach = (most / best - 1.0) / self.path_length_weight * ROUNDING;
        #[expect(clippy::cast_possible_truncation, reason = "rounded up by far more")]
        let reach = reach as f32;
        // Where the weight hardly falls, or not at all, no length is too long to win.
        let mut routes = within(if reach > near { reach } else { f32::INFINITY });
        if let Some(bounds) = bound::of_paths(situation, &gain, &routes) {
            let most = |cell: Cell, length| weight(length) * (bounds[cell.index()] * ROUNDING + LEAST_NATS);
            let first = routes.candidates().iter().copied().map(|it| (it, most(it, routes.length(it))));
            if let Some((cell, _)) = first.max_by(|(_, a), (_, b)| a.total_cmp(b)) {
                best = best.max(best_along(
                    self.path_length_weight,
                    Walk::new(situation, &mut gain),
                    &routes,
                    cell,
                ));
            }
            routes = routes.only_to(|cell, length| most(cell, length) >= best);
        }
        if routes.candidates().is_empty() {
            return decision;
        }
        best_within(situation, self.path_length_weight, &mut gain, &routes)
    }
}

/// The best score of the candidates on the path to a cell.
fn best_along(weight_per_cell: f64, mut walk: Walk<'_>, routes: &ShortestPathTree, to: Cell) -> f64 {
    let mut best = f64::NEG_INFINITY;
    for (cell, depth) in routes.path(to).into_iter().zip(1..) {
        let utility = f64::from(walk.enter(cell, depth));
        best = best.max(path_length_weight(weight_per_cell, routes.length(cell)) * utility);
    }
    walk.leave_to(0);
    best
}

/// The first path length up to which candidates are scored, sensor radii.
const FIRST_RADII: f32 = 4.0;
/// The part of the map up to which candidates are few.
const FEW_OF: usize = 32;
/// Factor on the bound: scores are sums of 32-bit numbers, and the table of gains is interpolated.
const ROUNDING: f64 = 1.01;

/// The best of the paths of a tree.
fn best_within(
    situation: &Situation<'_>,
    weight_per_cell: f64,
    gain: &mut UtilityGain<'_>,
    routes: &ShortestPathTree,
) -> Decision {
    let cell_count = situation.terrain.grid().cell_count();
    // Few paths are walked sooner than straight runs are found on the whole map.
    let is_few = routes.candidates().len() * FEW_OF <= cell_count;
    let kinds = if is_few { runs::walked(routes, cell_count) } else { runs::kinds(situation, routes) };
    let utility = utilities(situation, gain, routes, &kinds);
    let mut scores = vec![f64::NEG_INFINITY; utility.len()];
    for &cell in routes.candidates() {
        let weight = path_length_weight(weight_per_cell, routes.length(cell));
        scores[cell.index()] = weight * f64::from(utility[cell.index()]);
    }
    Decision::most_informative(routes, scores)
}

/// Utility of the path to each candidate, shape `[cells]`.
fn utilities(
    situation: &Situation<'_>,
    gain: &mut UtilityGain<'_>,
    routes: &ShortestPathTree,
    kinds: &[Kind],
) -> Vec<f32> {
    let mut utility = vec![0.0; kinds.len()];
    walk(situation, gain, routes, kinds, &mut utility);
    stencil::score(situation, gain, routes, kinds, &mut utility);
    utility
}

/// Scores the candidates that are to be walked, depth first.
fn walk(
    situation: &Situation<'_>,
    gain: &mut UtilityGain<'_>,
    routes: &ShortestPathTree,
    kinds: &[Kind],
    utility: &mut [f32],
) {
    let mut walk = Walk::new(situation, gain);
    let mut waiting = Vec::new();
    let (mut cell, mut depth) = (routes.root(), 0);
    loop {
        let children = situation.connectivity.neighbors(situation.terrain, cell);
        let is_child = |next: &Cell| kinds[next.index()] == Kind::Walked && routes.parent(*next) == cell;
        waiting.extend(children.filter(is_child).map(|next| (next, depth + 1)));
        match waiting.pop() {
            Some(next) => (cell, depth) = next,
            None => break,
        }
        utility[cell.index()] = walk.enter(cell, depth);
    }
    walk.leave_to(0);
}

/// What to add to the index of a robot's cell, and the precision of the reading there.
type Observed = (isize, i32);

/// The state of the traversal: what to restore on return.
struct Walk<'w> {
    table: &'w UtilityTable,
    /// Precision of every cell on the way.
    gains: &'w mut [CellGain],
    frame: Frame,
    /// The footprint, and by place what is seen from cells from which walls hide something.
    observations: Vec<Observed>,
    views: Option<(Views<'w>, Vec<Observed>)>,
    changed: Vec<(u32, CellGain)>,
    /// Of each cell on the path: changes made before it, and utility of the path up to it.
    path: Vec<(usize, f32)>,
}

impl<'w> Walk<'w> {
    fn new(situation: &Situation<'w>, gain: &'w mut UtilityGain<'_>) -> Self {
        let frame = gain.frame();
        let sensor = situation.sensor;
        let observed = |it: &FootprintCell| (frame.stride_of(it.offset), saturated(it.precision));
        let observations = sensor.footprint().iter().map(observed).collect();
        let views = Views::of(situation).map(|views| {
            let by_place = views.by_place(sensor, observed);
            (views, by_place)
        });
        let (table, gains) = gain.table_and_cells();
        Self { table, gains, frame, observations, views, changed: Vec::new(), path: Vec::new() }
    }

    /// Utility of the path to the next cell of a depth-first walk; `depth` counts moves from the root, from 1.
    fn enter(&mut self, cell: Cell, depth: usize) -> f32 {
        self.leave_to(depth - 1);
        let before = self.path.last().map_or(0.0, |&(_, utility)| utility);
        let changes = self.changed.len();
        let gain = self.observe(cell);
        let utility = before + gain;
        self.path.push((changes, utility));
        utility
    }

    /// Utility of an observation from a cell.
    fn observe(&mut self, from: Cell) -> f32 {
        let Self { table, gains, changed, .. } = self;
        let at = self.frame.index(from);
        let mut gain = 0.0;
        let mut count = |&(step, precision): &Observed| {
            let index = at.wrapping_add_signed(step);
            let cell = &mut gains[index];
            if cell.precision >= SATURATION {
                return;
            }
            #[expect(clippy::cast_possible_truncation, reason = "a framed map has fewer than 2^32 cells")]
            changed.push((index as u32, *cell));
            cell.precision = (cell.precision + precision).min(SATURATION);
            let utility = table.utility(cell.row, cell.precision);
            gain += utility - cell.utility;
            cell.utility = utility;
        };
        match self.views.as_ref().and_then(|(views, by_place)| Some((views.seen(from)?, by_place))) {
            None => self.observations.iter().for_each(count),
            Some((seen, by_place)) => seen.for_each(|place| count(&by_place[place])),
        }
        gain
    }

    /// Goes back to the cell at a depth of the path.
    fn leave_to(&mut self, depth: usize) {
        let Some(&(changes, _)) = self.path.get(depth) else { return };
        self.path.truncate(depth);
        while self.changed.len() > changes {
            if let Some((index, before)) = self.changed.pop() {
                self.gains[index as usize] = before;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rand::RngExt;

    use super::*;
    use crate::belief::Belief;
    use crate::cell::Grid;
    use crate::intent::PlannedPrecision;
    use crate::route::Connectivity;
    use crate::seed::{Purpose, stream};
    use crate::sensor::{Noise, Sensor};
    use crate::terrain::{Ground, Terrain};

    /// Bits of the utility of all paths, with straight runs apart and all walked, and how many straight runs score.
    fn both_ways(radius: u32, rows: u32, columns: u32, blocked: f64, seed: u64) -> ([Vec<u32>; 2], usize) {
        let grid = Grid::new(rows, columns).unwrap();
        let mut random = stream(seed, Purpose::Start, 1);
        let robot = grid.cells().nth(random.random_range(0..grid.cell_count())).unwrap();
        let is_open = |cell: Cell, draw: f64| cell == robot || draw >= blocked;
        let ground = grid
            .cells()
            .map(|cell| if is_open(cell, random.random()) { Ground::OPEN } else { Ground::BLOCKED });
        let terrain = Terrain::new(grid, 1.0, ground.collect()).unwrap();
        let terrain = if seed.is_multiple_of(2) { terrain.with_opaque_walls(radius) } else { terrain };
        // Long runs of equal cells, as unseen ground has them, and cells like no other.
        let log_odds = grid.cells().map(|_| match random.random_range(0..4) {
            0 => random.random_range(-9.0..9.0),
            _ => -4.0,
        });
        let belief = Belief::from_log_odds(&terrain, log_odds.collect()).unwrap();
        let sensor = Sensor::new(radius, 0.005, Noise::Gaussian).unwrap();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        let promised: Vec<Cell> = grid.cells().filter(|_| random.random_bool(0.05)).collect();
        planned_precision.add_path(&terrain, &sensor, &promised);
        let situation = Situation::alone(&terrain, &sensor, &belief, &planned_precision, robot);
        let routes = ShortestPathTree::from(&terrain, Connectivity::Four, robot);
        let mut gain = UtilityGain::information(&situation);
        let kinds = runs::kinds(&situation, &routes);
        let straight = kinds.iter().filter(|kind| matches!(kind, Kind::Straight(_))).count();
        let mut bits = |kinds: &[Kind]| {
            utilities(&situation, &mut gain, &routes, kinds).into_iter().map(f32::to_bits).collect()
        };
        ([bits(&kinds), bits(&runs::walked(&routes, kinds.len()))], straight)
    }

    proptest! {
        #[test]
        fn straight_runs_score_the_same_bits_as_the_traversal(
            radius in 1_u32..4,
            rows in 1_u32..40,
            columns in 1_u32..40,
            blocked in prop_oneof![Just(0.0), 0.0..0.3],
            seed in any::<u64>(),
        ) {
            let ([apart, walked], _) = both_ways(radius, rows, columns, blocked, seed);
            prop_assert_eq!(apart, walked);
        }
    }

    #[test]
    fn most_candidates_of_a_large_map_lie_on_straight_runs() {
        let ([apart, walked], straight) = both_ways(5, 100, 90, 0.0, 1);
        assert_eq!(apart, walked);
        assert!(straight > 5_000, "{straight}");
        // Where walls turn paths around, runs beyond the bend count only where they are clear of the path before it.
        let ([apart, walked], straight) = both_ways(1, 60, 60, 0.1, 2);
        assert_eq!(apart, walked);
        assert!(straight > 500, "{straight}");
    }
}
