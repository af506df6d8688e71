//! Every policy against a slow reference implementation, on random situations.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::ops::Range;

use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::Reading;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::policy::{Decision, LEAST_NATS, Parameters, PolicyName, build};
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::{Noise, Sensor};
use dragnet_search::situation::{DEFAULT_DETECTION_THRESHOLD, Place, Situation};
use dragnet_search::terrain::{Ground, Terrain};
use rand::RngExt;

mod information;
mod thompson;

/// A random map, belief and team.
struct Case {
    terrain: Terrain,
    sensor: Sensor,
    belief: Belief,
    planned_precision: PlannedPrecision,
    connectivity: Connectivity,
    robot: Cell,
}

impl Case {
    fn new(seed: u64) -> Self {
        Self::of_side(seed, 3..8)
    }

    fn of_side(seed: u64, side: Range<u32>) -> Self {
        let mut random = stream(seed, Purpose::Truth, 0);
        let grid = Grid::new(random.random_range(side.clone()), random.random_range(side)).unwrap();
        let mut ground: Vec<Ground> = (0..grid.cell_count()).map(|_| any_ground(&mut random)).collect();
        ground[0] = Ground::OPEN;
        let terrain = Terrain::new(grid, 30.0, ground).unwrap();
        let sensor = Sensor::new(random.random_range(1..4), 0.005, Noise::Gaussian).unwrap();
        // In a third of the cases walls hide what is behind them.
        let terrain =
            if seed.is_multiple_of(3) { terrain.with_opaque_walls(sensor.radius()) } else { terrain };
        let belief = Belief::uniform(&terrain, random.random_range(0.01..0.5)).unwrap();
        let area: Vec<Cell> = terrain.largest_area();
        let robot = area[random.random_range(0..area.len())];
        let planned_precision = PlannedPrecision::nothing(&terrain);
        let connectivity = if seed.is_multiple_of(2) { Connectivity::Four } else { Connectivity::Eight };
        let mut case = Self { terrain, sensor, belief, planned_precision, connectivity, robot };
        case.observe_around(&mut random);
        case
    }

    /// Readings of some cells, near and far, and a plan of a teammate.
    fn observe_around(&mut self, random: &mut Stream) {
        let grid = self.terrain.grid();
        let any_cell =
            |random: &mut Stream| grid.cells().nth(random.random_range(0..grid.cell_count())).unwrap();
        for _ in 0..random.random_range(1..grid.cell_count()) {
            let (cell, value) = (any_cell(random), random.random_range(-0.3..1.3));
            self.belief.add(&Reading { cell, value, variance: random.random_range(0.01..0.4) });
        }
        let plan: Vec<Cell> = (0..random.random_range(0..4)).map(|_| any_cell(random)).collect();
        self.planned_precision.add_path(&self.terrain, &self.sensor, &plan);
    }

    fn situation(&self) -> Situation<'_> {
        Situation {
            connectivity: self.connectivity,
            ..Situation::alone(&self.terrain, &self.sensor, &self.belief, &self.planned_precision, self.robot)
        }
    }

    fn decide(&self, name: PolicyName, seed: u64) -> Decision {
        let mut random = stream(seed, Purpose::Decision, 1);
        build(name, Parameters::default()).decide(&self.situation(), &mut random)
    }

    fn routes(&self) -> ShortestPathTree {
        ShortestPathTree::from(&self.terrain, self.connectivity, self.robot)
    }
}

fn any_ground(random: &mut Stream) -> Ground {
    match random.random_range(0..10) {
        0..7 => Ground::OPEN,
        7 => Ground::OUT_OF_REACH,
        8 => Ground::PASSAGE,
        _ => Ground::BLOCKED,
    }
}

/// The scores agree on every candidate, and the decision is the best of them with its shortest path, of equal ones the
/// nearest and then the first; or it is to rest, and none is above the least information of a path.
fn check(case: &Case, decision: &Decision, expected: impl Fn(Cell) -> f64, tolerance: f64) {
    let routes = case.routes();
    let is_candidate = |cell| routes.length(cell).is_finite() && cell != case.robot;
    let mut best = f64::NEG_INFINITY;
    for cell in case.terrain.grid().cells() {
        let score = decision.scores[cell.index()];
        if is_candidate(cell) {
            let expected = expected(cell);
            let allowed = tolerance * expected.abs().max(1.0);
            assert!((score - expected).abs() <= allowed, "{cell:?}: {score} instead of {expected}");
            best = best.max(score);
        } else {
            assert!(score == f64::NEG_INFINITY, "{cell:?} is no candidate and scores {score}");
        }
    }
    assert_eq!(decision.path, routes.path(decision.chosen));
    if decision.is_rest() {
        assert!(best <= LEAST_NATS, "it rests, and {best} was to be had");
        assert_eq!(decision.chosen, case.robot);
        return;
    }
    let rank = |cell: Cell| (routes.length(cell), cell);
    let equal = routes.candidates().iter().filter(|cell| decision.scores[cell.index()] >= best);
    let expected = equal.copied().min_by(|&a, &b| rank(a).partial_cmp(&rank(b)).unwrap());
    assert_eq!(Some(decision.chosen), expected);
}

#[test]
fn random_goes_everywhere_in_reach_and_nowhere_else() {
    let case = Case::new(4);
    let mut chosen: Vec<Cell> = (0..500).map(|seed| case.decide(PolicyName::Random, seed).chosen).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let mut candidates = case.routes().candidates().to_vec();
    candidates.sort_unstable();
    assert!(candidates.len() > 5);
    assert_eq!(chosen, candidates);
}

/// Coverage whose tracks touch.
const EVERY_ROW: Parameters = Parameters { lane_spacing_cells: Some(1), ..Parameters::DEFAULT };

#[test]
fn coverage_visits_every_cell_in_reach_once_around() {
    for seed in 0..20 {
        let mut case = Case::new(seed);
        let mut policy = build(PolicyName::Coverage, EVERY_ROW);
        let mut random = stream(seed, Purpose::Decision, 1);
        let mut left: Vec<Cell> = case.routes().reached().to_vec();
        left.retain(|&cell| cell != case.robot);
        for _ in 0..case.routes().reached().len() {
            let decision = policy.decide(&case.situation(), &mut random);
            case.robot = decision.chosen;
            left.retain(|&cell| cell != case.robot);
        }
        assert!(left.is_empty(), "{left:?} not visited");
    }
}

#[test]
fn a_coverage_team_shares_the_cells() {
    let terrain = Terrain::from_ascii("....\n....\n....\n", 1.0).unwrap();
    let (sensor, belief) = (Sensor::default(), Belief::uniform(&terrain, 0.1).unwrap());
    let planned_precision = PlannedPrecision::nothing(&terrain);
    let mut visited = Vec::new();
    for member in 0..3 {
        let mut policy = build(PolicyName::Coverage, EVERY_ROW);
        let mut robot = terrain.grid().cells().next().unwrap();
        for _ in 0..4 {
            let situation = Situation {
                terrain: &terrain,
                connectivity: Connectivity::Four,
                sensor: &sensor,
                belief: &belief,
                planned_precision: &planned_precision,
                robot,
                place: Place { member, team: 3 },
                detection_threshold: DEFAULT_DETECTION_THRESHOLD,
                remaining_cells: f64::INFINITY,
                ways_home: None,
            };
            robot = policy.decide(&situation, &mut stream(0, Purpose::Decision, 0)).chosen;
            visited.push(robot);
        }
    }
    visited.sort_unstable();
    visited.dedup();
    assert!(visited.len() >= 11, "{visited:?}");
}

/// Robots that follow every policy from decision to decision, until it rests.
#[test]
fn from_each_cell_of_a_path_the_budget_leaves_the_way_home() {
    let (mut driven, mut far) = (0.0, 0.0);
    for seed in 0..24 {
        for name in PolicyName::ALL {
            let mut case = Case::of_side(seed, 5..14);
            let home = case.routes();
            let mut policy = build(name, Parameters::default());
            let mut random = stream(seed, Purpose::Decision, 1);
            let budget = f64::from(u32::try_from(seed).unwrap() % 24);
            let mut left = budget;
            for _ in 0..30 {
                let situation =
                    Situation { remaining_cells: left, ways_home: Some(&home), ..case.situation() };
                let path = policy.choose(&situation, &mut random).path;
                for &cell in &path {
                    left -= case.terrain.grid().offset(case.robot, cell).euclidean();
                    case.robot = cell;
                    let way_home = f64::from(home.length(cell));
                    assert!(way_home <= left + 0.01, "{name} {seed}: {way_home} home, {left} left");
                    far = f64::max(far, way_home);
                }
                if path.is_empty() {
                    break;
                }
            }
            driven += budget - left;
        }
    }
    assert!(driven > 400.0 && far > 6.0, "{driven} {far}");
}

/// The cells of a tour that is planned for the way back show more than those of one that turns when it has to.
#[test]
fn a_tour_that_comes_home_is_planned_as_a_round() {
    let grid = Grid::new(24, 24).unwrap();
    let terrain = Terrain::new(grid, 1.0, vec![Ground::OPEN; grid.cell_count()]).unwrap();
    let robot = grid.cells().next().unwrap();
    let (sensor, belief) = (Sensor::default(), Belief::uniform(&terrain, 0.01).unwrap());
    let planned_precision = PlannedPrecision::nothing(&terrain);
    let home = ShortestPathTree::from(&terrain, Connectivity::Four, robot);
    let alone = Situation::alone(&terrain, &sensor, &belief, &planned_precision, robot);
    let mut found = [0.0, 0.0];
    for seed in 0..4 {
        let decide = |situation: &Situation<'_>| {
            build(PolicyName::Tour, Parameters::default())
                .decide(situation, &mut stream(seed, Purpose::Decision, 1))
        };
        let round = Situation { remaining_cells: 60.0, ways_home: Some(&home), ..alone };
        let mut turning = decide(&Situation { remaining_cells: 60.0, ..alone });
        turning.path.truncate(round.leading_cells_with_way_home(&turning.path));
        for (sum, decision) in found.iter_mut().zip([decide(&round), turning]) {
            *sum += decision.expected_found(&alone).last().copied().unwrap_or(0.0);
        }
    }
    assert!(found[0] > 1.2 * found[1], "{found:?}");
}

#[test]
fn with_nowhere_to_go_every_policy_stays() {
    let terrain = Terrain::from_ascii("#.#", 1.0).unwrap();
    let robot = terrain.traversable_cells().next().unwrap();
    let case = Case {
        sensor: Sensor::default(),
        belief: Belief::uniform(&terrain, 0.2).unwrap(),
        planned_precision: PlannedPrecision::nothing(&terrain),
        connectivity: Connectivity::Four,
        terrain,
        robot,
    };
    for name in PolicyName::ALL {
        let decision = case.decide(name, 0);
        assert_eq!((decision.chosen, decision.path.len()), (robot, 0), "{name}");
    }
}
