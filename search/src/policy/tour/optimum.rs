//! The tour of the planner beside the best of all paths, where all can be tried.
//!
//! A search of [`STEPS`] steps, without knowledge of what it will read: of all paths the one of least cost, as [`Planner`]
//! defines it, by depth-first branch and bound. The first decision of the policy, held to as many steps, is compared
//! with it.

use rand::RngExt;

use super::ground::{Ground, NOWHERE};
use super::hidden::HiddenTable;
use super::planner::{Leg, Planner, Progress};
use super::{FIRST_FACTOR, HOT, anneal, best_lanes};
use crate::belief::Belief;
use crate::cell::Grid;
use crate::evidence::Reading;
use crate::intent::PlannedPrecision;
use crate::policy::Parameters;
use crate::route::Connectivity;
use crate::seed::{Purpose, Stream, stream};
use crate::sensor::{Noise, Sensor};
use crate::situation::{DEFAULT_DETECTION_THRESHOLD, Place, Situation};
use crate::terrain::{Ground as Surface, Terrain};

const STEPS: u16 = 12;
const INSTANCES: u64 = 100;

/// A random map with a random belief.
struct Instance {
    terrain: Terrain,
    sensor: Sensor,
    belief: Belief,
    planned_precision: PlannedPrecision,
}

impl Instance {
    /// 6 x 6 to 10 x 10 cells, of which up to 30 % are blocked, a sensor of radius 1 to 3, an uneven prior, and some
    /// readings already.
    fn new(seed: u64) -> Self {
        let mut random = stream(seed, Purpose::Map, 0);
        let grid = Grid::new(random.random_range(6..=10), random.random_range(6..=10)).unwrap();
        let blocked = random.random_range(0.0..0.3);
        let mut any = |_| if random.random::<f64>() < blocked { Surface::BLOCKED } else { Surface::OPEN };
        let surface: Vec<Surface> = (0..grid.cell_count()).map(&mut any).collect();
        let terrain = Terrain::new(grid, 1.0, surface).unwrap();
        let sensor = Sensor::new(random.random_range(1..=3), 0.02, Noise::Gaussian).unwrap();
        let density: f64 = random.random_range(0.01..0.2);
        let prior: Vec<f64> = grid.cells().map(|_| density * random.random_range(0.1..2.0)).collect();
        let mut belief = Belief::new(&terrain, &prior).unwrap();
        for cell in grid.cells() {
            if random.random_range(0..4) == 0 {
                belief.add(&Reading { cell, value: random.random_range(-0.3..1.0), variance: 0.3 });
            }
        }
        let planned_precision = PlannedPrecision::nothing(&terrain);
        Self { terrain, sensor, belief, planned_precision }
    }

    fn situation(&self, random: &mut Stream) -> Situation<'_> {
        let area = self.terrain.largest_area();
        Situation {
            terrain: &self.terrain,
            connectivity: Connectivity::Four,
            sensor: &self.sensor,
            belief: &self.belief,
            planned_precision: &self.planned_precision,
            robot: area[random.random_range(0..area.len())],
            place: Place::ALONE,
            detection_threshold: DEFAULT_DETECTION_THRESHOLD,
            remaining_cells: f64::INFINITY,
            ways_home: None,
        }
    }

    /// Costs of the first tour and of the best path, and the cost of staying.
    fn costs(&self, seed: u64) -> Costs {
        let situation = self.situation(&mut stream(seed, Purpose::Start, 0));
        let (ground, table) = (Ground::new(&situation), HiddenTable::new(DEFAULT_DETECTION_THRESHOLD));
        let robot = ground.number(situation.robot).unwrap();
        let mut planner = Planner::new(&ground, &table, &situation, robot);
        // The longest tour has fewer steps than this.
        planner.most_steps = STEPS + 1;
        let evaluations = Parameters::DEFAULT.evaluations * FIRST_FACTOR;
        let mut random = stream(seed, Purpose::Decision, 0);
        let (tour, cost) = anneal::anneal(&planner, best_lanes(&planner), evaluations, HOT, &mut random);
        assert!(planner.cells(&tour).0.len() <= usize::from(STEPS));
        let mut search = Search::new(&planner);
        search.run(&planner.root);
        // The best path, leg by leg, costs what the search says.
        let legs: Vec<Leg> = search.best.iter().map(|&to| Leg { to, bend: 0 }).collect();
        assert!((planner.cost(&legs) - search.least).abs() < 1e-9);
        Costs { tour: cost, best: search.least, none: planner.cost(&[]) }
    }
}

struct Costs {
    tour: f64,
    best: f64,
    none: f64,
}

/// Depth-first branch and bound over all paths.
struct Search<'a> {
    planner: &'a Planner<'a>,
    /// The most precision that a place of the frame can get within so many steps from a position, by steps and position.
    reachable: Vec<Vec<Vec<u8>>>,
    path: Vec<u16>,
    best: Vec<u16>,
    least: f64,
    visited: u64,
}

impl<'a> Search<'a> {
    fn new(planner: &'a Planner<'a>) -> Self {
        let ground = planner.ground;
        let mut reachable = vec![vec![vec![0_u8; ground.frame_len()]; usize::from(ground.count())]];
        for _ in 0..STEPS {
            let fewer = &reachable[reachable.len() - 1];
            let of = |at: u16| {
                let mut most: Vec<u8> = vec![0; ground.frame_len()];
                for next in neighbors(ground, at) {
                    let mut precision = fewer[usize::from(next)].clone();
                    for (start, row) in ground.observation(next) {
                        precision[start..]
                            .iter_mut()
                            .zip(row)
                            .for_each(|(sum, &it): (&mut u8, &u8)| *sum = sum.saturating_add(it));
                    }
                    most.iter_mut().zip(precision).for_each(|(most, it)| *most = (*most).max(it));
                }
                most
            };
            reachable.push((0..ground.count()).map(of).collect());
        }
        let least = planner.cost(&[]);
        Self { planner, reachable, path: Vec::new(), best: Vec::new(), least, visited: 0 }
    }

    /// Tries all paths that go on from here.
    fn run(&mut self, progress: &Progress) {
        self.visited += 1;
        let cost = progress.cost + self.planner.tail * self.planner.rate(progress.left);
        if cost < self.least {
            (self.least, self.best) = (cost, self.path.clone());
        }
        let left = usize::from(STEPS) - self.path.len();
        if left == 0 || left > 1 && self.bound(progress, left) >= self.least {
            return;
        }
        for to in neighbors(self.planner.ground, progress.at) {
            let mut next = progress.clone();
            assert!(self.planner.walk(&mut next, Leg { to, bend: 0 }, f64::INFINITY));
            self.path.push(to);
            self.run(&next);
            self.path.pop();
        }
    }

    /// No path of up to so many steps more costs less: every place hides at least what it would if the path were the best
    /// for it alone, and if all of that were seen at once.
    fn bound(&self, progress: &Progress, steps: usize) -> f64 {
        let planner = self.planner;
        let most = &self.reachable[steps][usize::from(progress.at)];
        let places = planner.rows.iter().zip(&progress.precision).zip(most).zip(&progress.hidden);
        let gain = places.map(|(((&row, &precision), &more), &hidden)| {
            if more == 0 {
                0.0
            } else {
                f64::from(hidden - planner.table.hidden(row, precision.saturating_add(more)))
            }
        });
        // Sums of f32 differences, as progress counts them, are exact to less than this.
        let left = (progress.left - gain.sum::<f64>() - 1e-4).max(0.0);
        progress.cost + planner.tail * planner.rate(left)
    }
}

fn neighbors(ground: &Ground, at: u16) -> impl Iterator<Item = u16> {
    let (row, column) = ground.place(at);
    let near = [(-1, 0), (0, -1), (0, 1), (1, 0)].map(|(north, east)| ground.at(row + north, column + east));
    near.into_iter().filter(|&to| to != NOWHERE)
}

#[test]
fn a_first_tour_costs_at_most_a_twentieth_more_than_the_best_path() {
    let mut excess = Vec::new();
    let (mut saved, mut most_saved) = (0.0, 0.0);
    for seed in 0..INSTANCES {
        let Costs { tour, best, none } = Instance::new(seed).costs(seed);
        assert!(tour >= best - 1e-6, "{seed}: {tour} {best}");
        excess.push(tour / best - 1.0);
        saved += none - tour;
        most_saved += none - best;
    }
    let mean = excess.iter().sum::<f64>() / INSTANCES as f64;
    let optimal = excess.iter().filter(|&&it| it < 1e-6).count();
    let worst = excess.iter().copied().fold(0.0, f64::max);
    let share = saved / most_saved;
    println!("above the best by {mean:.4} in the mean, {worst:.3} at most; {optimal} are the best");
    println!("share of what the best paths save: {share:.3}");
    assert!(mean < 0.05, "{mean}");
    // Most of a cost may be what no path can save, so what is saved is compared too.
    assert!(share > 0.9, "{share}");
}
