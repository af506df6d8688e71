use std::sync::Arc;

use rand::RngExt;

use super::*;
use crate::belief::Belief;
use crate::cell::Grid;
use crate::evidence::Reading;
use crate::intent::{PlannedPrecision, TeammatePlan};
use crate::policy::{Parameters, PolicyName, build};
use crate::route::{Connectivity, ShortestPathTree};
use crate::seed::{Purpose, stream};
use crate::sensor::{Noise, Sensor};
use crate::situation::{DEFAULT_DETECTION_THRESHOLD, Place};
use crate::terrain::{Ground as Surface, Terrain};

/// A random map and belief.
struct Case {
    terrain: Terrain,
    sensor: Sensor,
    belief: Belief,
    planned_precision: PlannedPrecision,
    connectivity: Connectivity,
    robot: Cell,
    place: Place,
}

impl Case {
    fn new(seed: u64, side: std::ops::Range<u32>) -> Self {
        let mut random = stream(seed, Purpose::Map, 0);
        let grid = Grid::new(random.random_range(side.clone()), random.random_range(side)).unwrap();
        let mut surface: Vec<Surface> = (0..grid.cell_count())
            .map(|_| if random.random_range(0..5) == 0 { Surface::BLOCKED } else { Surface::OPEN })
            .collect();
        surface[0] = Surface::OPEN;
        let terrain = Terrain::new(grid, 1.0, surface).unwrap();
        let sensor = Sensor::new(random.random_range(1..6), 0.005, Noise::Gaussian).unwrap();
        // In a third of the cases walls hide what is behind them.
        let terrain =
            if seed.is_multiple_of(3) { terrain.with_opaque_walls(sensor.radius()) } else { terrain };
        let mut belief = Belief::uniform(&terrain, random.random_range(0.01..0.3)).unwrap();
        for _ in 0..grid.cell_count() / 3 {
            let cell = grid.cells().nth(random.random_range(0..grid.cell_count())).unwrap();
            belief.add(&Reading { cell, value: random.random_range(-0.3..1.3), variance: 0.2 });
        }
        let planned_precision = PlannedPrecision::nothing(&terrain);
        let connectivity = if seed.is_multiple_of(2) { Connectivity::Four } else { Connectivity::Eight };
        let robot = terrain.largest_area()[0];
        let place = Place::ALONE;
        Self { terrain, sensor, belief, planned_precision, connectivity, robot, place }
    }

    fn situation(&self) -> Situation<'_> {
        Situation {
            terrain: &self.terrain,
            connectivity: self.connectivity,
            sensor: &self.sensor,
            belief: &self.belief,
            planned_precision: &self.planned_precision,
            robot: self.robot,
            place: self.place,
            detection_threshold: DEFAULT_DETECTION_THRESHOLD,
            remaining_cells: f64::INFINITY,
            ways_home: None,
        }
    }

    /// An open map, one object in a hundred cells, and a team of which this robot is one.
    fn of_team(side: u32, place: Place) -> Self {
        let grid = Grid::new(side, side).unwrap();
        let terrain = Terrain::new(grid, 1.0, vec![Surface::OPEN; grid.cell_count()]).unwrap();
        let robot = grid.cells().nth((side / 2 * side + side / 2) as usize).unwrap();
        Self {
            belief: Belief::uniform(&terrain, 0.01).unwrap(),
            planned_precision: PlannedPrecision::nothing(&terrain),
            sensor: Sensor::default(),
            connectivity: Connectivity::Four,
            terrain,
            robot,
            place,
        }
    }

    fn decide(&self, seed: u64) -> Vec<Cell> {
        let mut tour = build(PolicyName::Tour, Parameters { evaluations: 400, ..Parameters::default() });
        tour.decide(&self.situation(), &mut stream(seed, Purpose::Decision, u16::from(self.place.member > 0)))
            .path
    }

    /// A teammate's path becomes known.
    fn plan(&mut self, member: u16, path: &[Cell]) {
        let plan = TeammatePlan {
            member: Some(member),
            cell: Some(self.robot),
            path: path.to_vec().into(),
            driven_cells: 0.0,
            sensor: Arc::new(self.sensor.clone()),
            line_of_sight: self.terrain.line_of_sight().clone(),
            pace: 1.0,
        };
        self.planned_precision.add_plan(&self.terrain, plan);
    }

    /// The share of the map that is within the sensor's radius of a path.
    fn seen(&self, path: &[Cell]) -> Vec<bool> {
        let mut planned = PlannedPrecision::nothing(&self.terrain);
        planned.add_path(&self.terrain, &self.sensor, path);
        self.terrain.grid().cells().map(|cell| planned.precision(cell) > 0).collect()
    }

    fn with_planner<T>(&self, with: impl FnOnce(&Planner<'_>) -> T) -> T {
        let (ground, table) = (Ground::new(&self.situation()), HiddenTable::new(DEFAULT_DETECTION_THRESHOLD));
        let robot = ground.number(self.robot).unwrap();
        with(&Planner::new(&ground, &table, &self.situation(), robot))
    }

    fn check_path(&self, decision: &Decision) {
        let mut at = self.robot;
        for &cell in &decision.path {
            assert!(
                self.connectivity.neighbors(&self.terrain, at).any(|near| near == cell),
                "{at:?} to {cell:?}"
            );
            at = cell;
        }
        assert_eq!(at, decision.chosen);
    }
}

fn any_tour(ground: &Ground, random: &mut Stream) -> Vec<Leg> {
    let any = |random: &mut Stream| ground.waypoint(random.random_range(0..ground.count()));
    (0..random.random_range(1..8)).map(|_| Leg { to: any(random), bend: random.random_range(0..2) }).collect()
}

#[test]
fn legs_are_shortest_paths_along_either_axis() {
    for seed in 0..20 {
        let case = Case::new(seed, 3..12);
        let ground = Ground::new(&case.situation());
        let routes = ShortestPathTree::from(&case.terrain, case.connectivity, case.robot);
        assert_eq!(usize::from(ground.count()), routes.reached().len());
        let root = ground.number(case.robot).unwrap();
        for (to, bend) in (0..ground.count()).flat_map(|to| [(to, 0), (to, 1)]) {
            let (mut at, mut straight, mut diagonal) = (root, 0, 0);
            while at != to {
                let step = ground.step(bend, at, to);
                let (from, next) = (ground.cell(at), ground.cell(step.to));
                assert!(case.connectivity.neighbors(&case.terrain, from).any(|near| near == next));
                *(if step.length == 5 { &mut straight } else { &mut diagonal }) += 1;
                at = step.to;
            }
            assert_eq!(ground.length(root, to), 5 * straight + 7 * diagonal);
            let shortest = f64::from(routes.length(ground.cell(to)));
            let length = f64::from(straight) + f64::from(diagonal) * std::f64::consts::SQRT_2;
            assert!(length >= shortest - 1e-4 && length <= 1.01 * shortest, "{length} instead of {shortest}");
        }
    }
}

#[test]
fn a_change_costs_what_the_whole_tour_costs() {
    for seed in 0..60 {
        let case = Case::new(seed, 4..14);
        case.with_planner(|planner| {
            let mut random = stream(seed, Purpose::Decision, 0);
            let tour = any_tour(planner.ground, &mut random);
            let mut walked = planner::WalkedTour::new(planner, &tour);
            assert!((walked.cost(planner, &tour) - planner.cost(&tour)).abs() < 1e-9);
            for _ in 0..20 {
                let (first, last) =
                    (random.random_range(0..=tour.len()), random.random_range(0..=tour.len()));
                let (first, last) = (first.min(last), first.max(last));
                let middle = any_tour(planner.ground, &mut random);
                let trial = [&tour[..first], &middle, &tour[last..]].concat();
                let common = tour.len() - last;
                let cost = walked.cost_of_changed(planner, (&tour, &trial), (first, common), f64::INFINITY);
                let expected = planner.cost(&trial);
                assert!((cost - expected).abs() < 1e-3 * expected, "{cost} instead of {expected}");
            }
            // Walking a changed tour from the first leg that differs gives the same as walking it all.
            let changed = [&tour[..1], &any_tour(planner.ground, &mut random)].concat();
            walked.walk(planner, &changed, 1);
            assert!((walked.cost(planner, &changed) - planner.cost(&changed)).abs() < 1e-9);
        });
    }
}

/// A robot that stays while its teammate drives a tour waits for what it would find itself on that tour, and is spared
/// the moves.
/// A search of 40 cells on the open map.
#[test]
fn a_tour_that_the_budget_cuts_is_planned_for_the_budget() {
    let mut found = [0.0, 0.0];
    for seed in 0..6 {
        let case = Case::of_team(24, Place::ALONE);
        let decide = |remaining_cells: f64| {
            let mut tour = build(PolicyName::Tour, Parameters::default());
            let situation = Situation { remaining_cells, ..case.situation() };
            tour.decide(&situation, &mut stream(seed, Purpose::Decision, 1))
        };
        let (whole, cut) = (decide(f64::INFINITY), decide(40.0));
        assert!(whole.path.len() > 60, "{}", whole.path.len());
        assert!((30..=40).contains(&cut.path.len()), "{}", cut.path.len());
        for (sum, decision) in found.iter_mut().zip([&whole, &cut]) {
            let expected = decision.expected_found(&case.situation());
            *sum += expected[40.min(expected.len() - 1)];
        }
        case.check_path(&cut);
        assert_eq!(decide(1e9), whole, "a budget that lasts changes nothing");
        case.check_path(&decide(0.0));
    }
    assert!(found[1] > 1.03 * found[0], "{found:?}");
}

#[test]
fn what_teammates_observe_counts_from_when_they_observe_it() {
    let mut lumped = 0;
    for seed in 0..30 {
        Case::new(seed, 4..12).with_planner(|alone| {
            let mut random = stream(seed, Purpose::Decision, 0);
            let (own, mates) = (any_tour(alone.ground, &mut random), any_tour(alone.ground, &mut random));
            let (mut at, mut time, mut steps) = (alone.root.at, 0, Vec::new());
            for leg in &mates {
                while at != leg.to {
                    let step = alone.ground.step(leg.bend, at, leg.to);
                    (at, time) = (step.to, time + u32::from(step.length));
                    steps.push((at, time));
                }
            }
            let each: Vec<planner::PlannedObservation> = steps
                .iter()
                .flat_map(|&(from, time)| {
                    let rows = alone.ground.observation(from);
                    rows.flat_map(move |(start, row)| {
                        (start..).zip(row).map(move |(place, &precision)| planner::PlannedObservation {
                            time,
                            place,
                            precision,
                        })
                    })
                })
                .collect();
            let expected = alone.cost(&mates) - 0.02 * f64::from(time) / 5.0;
            let cost = alone.beside(alone.root.at, each.clone()).cost(&[]);
            assert!((cost - expected).abs() < 1e-3 * expected, "{seed}: {cost} instead of {expected}");
            // Counting a teammate's observations of a cell together keeps their precision.
            let placed = steps.iter().map(|&(at, time)| (alone.ground.cell(at), time));
            let planned = alone.ground.planned(alone.ground.seen(), 1.0, placed);
            let sum =
                |of: &[planner::PlannedObservation]| of.iter().map(|it| u32::from(it.precision)).sum::<u32>();
            assert!(sum(&planned) <= sum(&each) && !planned.is_empty() || each.is_empty());
            lumped += each.len() - planned.len();
            // A changed tour costs the same whether it is walked whole or from its first change.
            let beside = alone.beside(alone.root.at, planned);
            let mut walked = planner::WalkedTour::new(&beside, &own);
            let trial = [&own[..1], &any_tour(alone.ground, &mut random)].concat();
            let changed = walked.cost_of_changed(&beside, (&own, &trial), (1, 0), f64::INFINITY);
            assert!((changed - beside.cost(&trial)).abs() < 1e-9);
        });
    }
    assert!(lumped > 1000, "{lumped}");
}

/// Neither has heard the other: both divide the map alike.
#[test]
fn two_robots_in_one_cell_take_different_halves_with_and_without_messages() {
    for is_heard in [false, true] {
        let mut second = Case::of_team(24, Place { member: 1, team: 2 });
        let first = Case::of_team(24, Place { member: 0, team: 2 }).decide(1);
        if is_heard {
            second.plan(0, &first);
        }
        let ahead = |path: Vec<Cell>| path.into_iter().take(30).collect::<Vec<Cell>>();
        let (one, two) = (second.seen(&ahead(first)), second.seen(&ahead(second.decide(2))));
        let count = |is_seen: &dyn Fn(bool, bool) -> bool| {
            one.iter().zip(&two).filter(|&(&one, &two)| is_seen(one, two)).count()
        };
        let (either, both) = (count(&|one, two| one || two), count(&|one, two| one && two));
        println!("heard {is_heard}: {either} seen, {both} of them twice");
        assert!(either > 24 * 24 * 7 / 10, "{either}");
        assert!(both < either * 2 / 5, "{both} of {either}");
    }
}

#[test]
fn the_part_of_a_lost_robot_is_taken_over() {
    let mut case = Case::of_team(24, Place { member: 0, team: 2 });
    let mut mate = Case::of_team(24, Place { member: 1, team: 2 }).decide(2);
    mate.truncate(30);
    case.plan(1, &mate);
    let mut tour = build(PolicyName::Tour, Parameters { evaluations: 400, ..Parameters::default() });
    let mut random = stream(1, Purpose::Decision, 0);
    let before = tour.decide(&case.situation(), &mut random).path;
    case.planned_precision = PlannedPrecision::nothing(&case.terrain);
    let after = tour.decide(&case.situation(), &mut random).path;
    let part = case.seen(&mate);
    // Cells of the teammate's part that are seen in this many cells.
    let seen = |path: &[Cell]| {
        let seen = case.seen(&path[..path.len().min(60)]);
        seen.into_iter().zip(&part).filter(|&(is_seen, &is_part)| is_seen && is_part).count()
    };
    let (before, after, all) = (seen(&before), seen(&after), seen(&mate));
    println!("of {all} cells {before} while the teammate is there, {after} without it");
    assert!(before < all * 2 / 3, "{before} of {all}");
    assert!(after > all * 4 / 5, "{after} of {all}");
}

#[test]
fn annealing_returns_the_cost_of_its_tour_and_never_a_worse_one() {
    for seed in 0..10 {
        Case::new(seed, 4..14).with_planner(|planner| {
            let mut random = stream(seed, Purpose::Decision, 0);
            let start = any_tour(planner.ground, &mut random);
            let (tour, cost) = anneal::anneal(planner, start.clone(), 400, HOT, &mut random);
            assert!((cost - planner.cost(&tour)).abs() < 1e-9);
            assert!(cost <= planner.cost(&start) + 1e-9);
        });
    }
}

#[test]
fn a_tour_is_drivable_and_rests_only_when_path_does() {
    let mut driven = 0;
    for seed in 0..40 {
        let mut case = Case::new(seed, 1..14);
        let parameters = Parameters { evaluations: 60, ..Parameters::default() };
        let (mut tour, mut path) = (build(PolicyName::Tour, parameters), build(PolicyName::Path, parameters));
        let mut random = stream(seed, Purpose::Decision, 1);
        for _ in 0..3 {
            let decision = tour.decide(&case.situation(), &mut random);
            case.check_path(&decision);
            let other = path.decide(&case.situation(), &mut random);
            assert!(!decision.is_rest() || other.is_rest(), "{seed}");
            let Some(&cell) = decision.path.get(2).or(decision.path.last()) else { break };
            case.robot = cell;
            driven += 1;
        }
    }
    assert!(driven > 50);
}

#[test]
fn the_rest_of_a_tour_is_kept() {
    let mut case = Case::new(3, 12..14);
    let mut tour = build(PolicyName::Tour, Parameters { evaluations: 0, ..Parameters::default() });
    let mut random = stream(0, Purpose::Decision, 1);
    let first = tour.decide(&case.situation(), &mut random).path;
    assert!(first.len() > 12, "{}", first.len());
    for driven in [4, 4, 7] {
        case.robot = first[driven - 1];
        assert_eq!(tour.decide(&case.situation(), &mut random).path, first[driven..]);
    }
}

/// A tour that looks at its cells again and again passes its start on the way.
#[test]
fn a_tour_that_comes_back_is_not_started_over() {
    let grid = Grid::new(1, 9).unwrap();
    let cells: Vec<Cell> = grid.cells().collect();
    let plan = |way: &[usize]| Plan {
        root: Some(cells[0]),
        cells: way.iter().map(|&cell| cells[cell]).collect(),
        legs: vec![(0, way.len())],
    };
    let back = plan(&[1, 0, 1, 0, 1, 2, 3, 4, 3]);
    let driven = [0, 1, 2, 3, 4, 5].map(|cell| back.driven(cells[cell]));
    assert_eq!(driven, [4, 3, 6, 7, 8, 0]);
    let late = plan(&[1, 2, 3, 4, 3, 2, 1, 0]);
    assert_eq!([0, 1, 4].map(|cell| late.driven(cells[cell])), [0, 1, 4], "it has not moved");
}

/// From the middle of a corridor a tour to both ends enters half of the cells twice.
#[test]
fn no_path_is_longer_than_the_map_has_cells() {
    let mut case = Case::new(1, 3..4);
    case.terrain = Terrain::from_ascii(&format!("{}\n", ".".repeat(60)), 1.0).unwrap();
    case.belief = Belief::uniform(&case.terrain, 0.2).unwrap();
    case.planned_precision = PlannedPrecision::nothing(&case.terrain);
    case.sensor = Sensor::default();
    case.robot = case.terrain.grid().cells().nth(30).unwrap();
    let mut tour = Tour::new(300, 0.2);
    let decision = tour.decide(&case.situation(), &mut stream(0, Purpose::Decision, 1));
    case.check_path(&decision);
    assert!(tour.plan.cells.len() > 60, "{}", tour.plan.cells.len());
    assert_eq!(decision.path, tour.plan.cells[..60]);
}

#[test]
fn wide_sensors_get_fewer_evaluations() {
    let of = |radius| affordable(1000, &Sensor::new(radius, 0.0005, Noise::Gaussian).unwrap());
    assert_eq!([1, 5, 10, 60].map(of), [1000, 1000, 276, 8]);
}

#[test]
fn decisions_are_those_of_the_seed() {
    let case = Case::new(5, 12..14);
    let decide = |seed| {
        let mut tour = build(PolicyName::Tour, Parameters { evaluations: 100, ..Parameters::default() });
        tour.decide(&case.situation(), &mut stream(seed, Purpose::Decision, 1)).path
    };
    assert_eq!(decide(1), decide(1));
    assert_ne!(decide(1), decide(2));
}

#[test]
fn large_maps_are_planned_around_the_robot_within_bounded_memory() {
    let grid = Grid::new(200, 200).unwrap();
    let terrain = Terrain::new(grid, 1.0, vec![Surface::OPEN; grid.cell_count()]).unwrap();
    let robot = grid.cells().nth(100 * 200 + 100).unwrap();
    let mut case = Case { robot, ..Case::new(2, 3..4) };
    case.belief = Belief::uniform(&terrain, 0.01).unwrap();
    case.planned_precision = PlannedPrecision::nothing(&terrain);
    case.sensor = Sensor::default();
    case.terrain = terrain;
    let ground = Ground::new(&case.situation());
    assert_eq!(ground.count(), 4096);
    let mut waypoints: Vec<u16> = (0..ground.count()).map(|number| ground.waypoint(number)).collect();
    waypoints.sort_unstable();
    waypoints.dedup();
    assert!(waypoints.len() * 4096 < 1 << 23, "{}", waypoints.len());
    let mut tour = build(PolicyName::Tour, Parameters { evaluations: 100, ..Parameters::default() });
    let decision = tour.decide(&case.situation(), &mut stream(0, Purpose::Decision, 1));
    case.check_path(&decision);
    assert!(decision.path.len() > 200, "{}", decision.path.len());
}

#[test]
fn a_tour_that_is_too_long_counts_as_none() {
    let mut case = Case::new(1, 3..4);
    case.terrain = Terrain::from_ascii(&format!("{}.", ".\n".repeat(2000)), 1.0).unwrap();
    case.belief = Belief::uniform(&case.terrain, 0.01).unwrap();
    case.planned_precision = PlannedPrecision::nothing(&case.terrain);
    case.robot = case.terrain.grid().cells().next().unwrap();
    case.with_planner(|planner| {
        let ends = [planner.ground.count() - 1, 0].map(|end| planner.ground.waypoint(end));
        let tour: Vec<Leg> = ends.into_iter().cycle().take(40).map(|to| Leg { to, bend: 0 }).collect();
        let (none, cost) = anneal::anneal(planner, tour, 0, HOT, &mut stream(0, Purpose::Decision, 0));
        assert!(none.is_empty() && cost.is_finite());
    });
}

#[test]
fn an_expert_scores_near_cells_and_drives_to_the_best() {
    for seed in 0..6 {
        let case = Case::new(seed, 8..14);
        let situation = case.situation();
        let mut expert = TourScores::new(Parameters { evaluations: 60, ..Parameters::default() });
        let decision = expert.decide(&situation, &mut stream(seed, Purpose::Decision, 0));
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let scored: Vec<Cell> =
            case.terrain.grid().cells().filter(|cell| decision.scores[cell.index()].is_finite()).collect();
        assert!(scored.len() > 3, "seed {seed}: {scored:?}");
        assert!(scored.iter().all(|&cell| routes.length(cell) < SCORED_WITHIN_CELLS), "seed {seed}");
        let best = scored.iter().map(|cell| decision.scores[cell.index()]).fold(f64::MIN, f64::max);
        assert!(decision.scores[decision.chosen.index()] >= best, "seed {seed}");
        assert_eq!(decision.path, routes.path(decision.chosen), "seed {seed}");
        // No score promises more than finding all at once would save.
        let most = case.with_planner(|planner| planner.cost(&[]));
        assert!(best < most, "seed {seed}: {best} of {most}");
    }
}

#[test]
fn a_detour_costs_its_length_in_the_scores() {
    // All that is hidden lies at the right end; the robot has seen its surroundings.
    let terrain = Terrain::from_ascii("....................", 1.0).unwrap();
    let log_odds = (0..20).map(|column| if column < 14 { -40.0 } else { -2.0 }).collect();
    let case = Case {
        belief: Belief::from_log_odds(&terrain, log_odds).unwrap(),
        sensor: Sensor::new(1, 0.005, Noise::Gaussian).unwrap(),
        planned_precision: PlannedPrecision::nothing(&terrain),
        connectivity: Connectivity::Four,
        robot: terrain.grid().cells().nth(6).unwrap(),
        place: Place::ALONE,
        terrain,
    };
    let mut expert = TourScores::new(Parameters::default());
    let decision = expert.decide(&case.situation(), &mut stream(1, Purpose::Decision, 0));
    let scores = &decision.scores;
    assert!(decision.chosen.index() > 6, "{}", decision.chosen.index());
    // Each cell to the left is driven twice, while all is hidden still: `g` is 1 - exp(-1) + 0.02 at least.
    let detour = scores[7] - scores[2];
    assert!((5.0..12.0).contains(&detour), "{detour}");
    assert!((scores[7] - scores[9]).abs() < 0.5, "{scores:?}");
}

#[test]
fn the_gain_of_a_look_is_what_is_hidden_less_afterwards() {
    let mut hidden = HiddenMass::default();
    for seed in 0..6 {
        let mut case = Case::new(seed, 6..12);
        let sum = |hidden: &Hidden| hidden.mass.iter().map(|&mass| f64::from(mass)).sum::<f64>();
        let before = hidden.of(&case.situation());
        assert!(sum(&before) > 0.1);
        for from in case.terrain.grid().cells().step_by(5) {
            case.planned_precision = PlannedPrecision::nothing(&case.terrain);
            case.planned_precision.add_path(&case.terrain, &case.sensor, &[from]);
            let taken = sum(&before) - sum(&hidden.of(&case.situation()));
            let gain = f64::from(before.gain[from.index()]);
            assert!((taken - gain).abs() < 1e-4 * (1.0 + taken), "seed {seed}: {gain}, {taken} taken");
        }
    }
}
