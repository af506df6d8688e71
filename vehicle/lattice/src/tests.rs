//! Plans on many small maps, compared with an exhaustive search that shares only the primitives with the planner.

use std::collections::{BTreeMap, BTreeSet};

use dragnet_search::cell::{Grid, Position};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::costmap::{CostMap, LETHAL};
use super::footprint::{Footprint, nearest};
use super::maneuvers::{Headings, Maneuvers};
use super::plan::{Effort, Goal, Plan, PlanError, Solution};
use super::planner::Planner;
use super::primitives::{Primitive, PrimitiveSet};
use crate::mentions::assert_mentions;
use crate::plane::{Pose, turn_radians};

const RESOLUTION_METERS: f64 = 0.5;

/// A small map with a vehicle and a goal.
#[derive(Debug)]
struct World {
    map: CostMap,
    set: PrimitiveSet,
    footprint: Footprint,
    start: Pose,
    goal: Goal,
    /// Number of cells from which on there is a guide.
    guided_cells: usize,
    /// Shape `[primitives]`.
    drawn: Vec<Drawn>,
}

/// The ground under a primitive.
#[derive(Debug)]
struct Drawn {
    swept: BTreeSet<(i32, i32)>,
    path: BTreeSet<(i32, i32)>,
    units: u64,
}

impl Drawn {
    fn new(primitive: &Primitive, footprint: &Footprint) -> Self {
        let (mut swept, mut path) = (BTreeSet::new(), BTreeSet::new());
        let cell = |meters: f64| nearest(meters / RESOLUTION_METERS);
        for pair in primitive.poses.windows(2) {
            let turn = turn_radians(pair[0].heading_radians, pair[1].heading_radians);
            let moved = (pair[1].x_meters - pair[0].x_meters).hypot(pair[1].y_meters - pair[0].y_meters)
                + turn.abs() * footprint.circumscribed_meters();
            let count = (moved / RESOLUTION_METERS / 0.25).ceil().max(1.0);
            let mut index = 0.0;
            while index <= count {
                let part = index / count;
                let pose = Pose {
                    x_meters: pair[0].x_meters + part * (pair[1].x_meters - pair[0].x_meters),
                    y_meters: pair[0].y_meters + part * (pair[1].y_meters - pair[0].y_meters),
                    heading_radians: pair[0].heading_radians + part * turn,
                };
                path.insert((cell(pose.y_meters), cell(pose.x_meters)));
                swept.extend(footprint.cells(pose, RESOLUTION_METERS));
                index += 1.0;
            }
        }
        swept.extend(&path);
        let straight = f64::from(primitive.east_cells).hypot(f64::from(primitive.north_cells));
        let length = (primitive.length_meters() / RESOLUTION_METERS).max(straight);
        let turn = primitive.turned_radians() * footprint.circumscribed_meters() / RESOLUTION_METERS;
        let cells = if straight > 0.0 { length } else { turn };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "short")]
        let units = ((1_000.0 * cells).round() as u64).max(1);
        Self { swept, path, units: units * u64::from(primitive.cost_multiplier) }
    }
}

impl World {
    fn drawn(seed: u64) -> Self {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let (rows, columns) = (draw.random_range(8..32_u32), draw.random_range(8..32_u32));
        let lethal = draw.random_range(0.0..0.08);
        let dear = if draw.random_bool(0.5) { draw.random_range(0.0..0.8) } else { 0.0 };
        let grid = Grid::new(rows, columns).unwrap();
        let costs = grid
            .cells()
            .map(|_| match () {
                () if draw.random_bool(lethal) => draw.random_range(LETHAL..=u8::MAX),
                () if draw.random_bool(dear) => draw.random_range(0..=20),
                () => 0,
            })
            .collect();
        let origin = (draw.random_range(-50.0..50.0), draw.random_range(-50.0..50.0));
        let map = CostMap::new(grid, RESOLUTION_METERS, origin, costs).unwrap();
        let maneuvers = Maneuvers {
            resolution_meters: RESOLUTION_METERS,
            headings: [Headings::Eight, Headings::Sixteen, Headings::ThirtyTwo][draw.random_range(0..3)],
            turning_radius_meters: draw.random_range(0.3..2.0),
            reverse: draw.random_bool(0.5).then(|| draw.random_range(1..4)),
            turn_in_place: draw.random_bool(0.3).then(|| draw.random_range(1..4)),
        };
        let footprint = match draw.random_range(0..3) {
            0 => Footprint::Circle { radius_meters: draw.random_range(0.0..0.8) },
            1 => Footprint::rectangle(draw.random_range(0.3..2.0), draw.random_range(0.3..1.2)),
            _ => Footprint::Polygon {
                corners_meters: vec![(0.9, 0.0), (-0.4, 0.5), (-0.2, 0.0), (-0.4, -0.5)],
            },
        };
        let place = |draw: &mut ChaCha8Rng| {
            (
                origin.0 + draw.random_range(0.0..f64::from(columns)) * RESOLUTION_METERS,
                origin.1 + draw.random_range(0.0..f64::from(rows)) * RESOLUTION_METERS,
            )
        };
        let (from, to) = (place(&mut draw), place(&mut draw));
        let set = maneuvers.primitives().unwrap();
        Self {
            drawn: set.primitives().iter().map(|primitive| Drawn::new(primitive, &footprint)).collect(),
            set,
            footprint,
            start: Pose { x_meters: from.0, y_meters: from.1, heading_radians: draw.random_range(-4.0..4.0) },
            goal: Goal {
                x_meters: to.0,
                y_meters: to.1,
                heading_radians: draw.random_bool(0.5).then(|| draw.random_range(-4.0..4.0)),
                tolerance_meters: if draw.random_bool(0.5) { draw.random_range(0.0..2.0) } else { 0.0 },
            },
            guided_cells: if draw.random_bool(0.5) { 0 } else { usize::MAX },
            map,
        }
    }

    fn planner(&self) -> Planner {
        let mut planner = Planner::new(self.set.clone(), &self.footprint, self.map.clone()).unwrap();
        planner.guide_from(self.guided_cells);
        planner
    }

    fn cost(&self, north: i64, east: i64) -> Option<u8> {
        let position = Position { row: u32::try_from(north).ok()?, column: u32::try_from(east).ok()? };
        let cell = self.map.grid().cell(position)?;
        Some(self.map.costs()[cell.index()]).filter(|&cost| cost < LETHAL)
    }

    /// Whether the whole footprint is on free ground, at a pose relative to the center of a cell.
    fn is_free(&self, (north, east): (i64, i64), pose: Pose) -> bool {
        let cells = self.footprint.cells(pose, RESOLUTION_METERS);
        cells.iter().all(|&(n, e)| self.cost(north + i64::from(n), east + i64::from(e)).is_some())
    }

    /// The cost of a primitive from a cell, if the vehicle can drive it.
    fn drive(&self, from: (i64, i64), primitive: usize) -> Option<u64> {
        let drawn = &self.drawn[primitive];
        let cost = |&(n, e): &(i32, i32)| self.cost(from.0 + i64::from(n), from.1 + i64::from(e));
        if !drawn.swept.iter().all(|cell| cost(cell).is_some()) {
            return None;
        }
        let largest = drawn.path.iter().map(cost).max()??;
        Some(drawn.units * (1 + u64::from(largest)))
    }

    fn state(&self, pose: Pose) -> (i64, i64, usize) {
        let cell = self.map.cell_at(pose.x_meters, pose.y_meters).unwrap();
        let Position { row, column } = self.map.grid().position(cell);
        (i64::from(row), i64::from(column), self.set.nearest_heading(pose.heading_radians))
    }

    fn is_goal(&self, (north, east, heading): (i64, i64, usize)) -> bool {
        let position = Position { row: u32::try_from(north).unwrap(), column: u32::try_from(east).unwrap() };
        let cell = self.map.grid().cell(position).unwrap();
        let (x, y) = self.map.center_meters(cell);
        let is_near = (x - self.goal.x_meters).hypot(y - self.goal.y_meters) <= self.goal.tolerance_meters
            || Some(cell) == self.map.cell_at(self.goal.x_meters, self.goal.y_meters);
        is_near && self.goal.heading_radians.is_none_or(|goal| self.set.nearest_heading(goal) == heading)
    }

    /// Dijkstra over all states.
    fn cheapest(&self) -> Option<u64> {
        let mut known = BTreeMap::from([(self.state(self.start), 0_u64)]);
        let mut open = BTreeSet::from([(0_u64, self.state(self.start))]);
        while let Some((cost, state)) = open.pop_first() {
            if self.is_goal(state) {
                return Some(cost);
            }
            for (index, primitive) in self.set.primitives().iter().enumerate() {
                if primitive.start_heading != state.2 {
                    continue;
                }
                let Some(step) = self.drive((state.0, state.1), index) else { continue };
                let to = (
                    state.0 + i64::from(primitive.north_cells),
                    state.1 + i64::from(primitive.east_cells),
                    primitive.end_heading,
                );
                let longer = cost + step;
                if known.get(&to).is_none_or(|&known| longer < known) {
                    known.insert(to, longer);
                    open.insert((longer, to));
                }
            }
        }
        None
    }

    /// The path is valid: its steps join, each is free and has the right cost, and it ends at the goal.
    fn assert_path(&self, plan: &Plan) {
        let mut state = self.state(self.start);
        let mut cost = 0;
        let mut end = 0;
        for step in &plan.steps {
            let primitive = &self.set.primitives()[step.primitive];
            assert_eq!(primitive.start_heading, state.2);
            assert_eq!(self.drive((state.0, state.1), step.primitive), Some(step.cost));
            assert_eq!(step.poses.start, end);
            end = step.poses.end - 1;
            assert_eq!(step.poses.len(), primitive.poses.len());
            cost += step.cost;
            state.0 += i64::from(primitive.north_cells);
            state.1 += i64::from(primitive.east_cells);
            state.2 = primitive.end_heading;
            assert_eq!(self.state(plan.poses[end]), state);
        }
        assert!(self.is_goal(state));
        assert_eq!((cost, end + 1), (plan.cost, plan.poses.len()));
        for pose in &plan.poses {
            let (north, east, _) = self.state(*pose);
            let center = self.map.center_meters(self.map.cell_at(pose.x_meters, pose.y_meters).unwrap());
            let (x_meters, y_meters) = (pose.x_meters - center.0, pose.y_meters - center.1);
            assert!(self.is_free((north, east), Pose { x_meters, y_meters, ..*pose }));
        }
        let legs = plan.poses.windows(2);
        let length: f64 =
            legs.map(|p| (p[1].x_meters - p[0].x_meters).hypot(p[1].y_meters - p[0].y_meters)).sum();
        assert!((length - plan.length_meters).abs() < 1e-9);
    }
}

/// Every solution meets its bound, and each is at least as good as the one before.
fn assert_solutions(plan: &Plan, cheapest: u64) {
    let mut before: Option<Solution> = None;
    for solution in &plan.solutions {
        assert!(solution.bound >= 1.0);
        assert!(f64::from(solution.cost) <= solution.bound * cheapest as f64 * (1.0 + 1e-12));
        if let Some(before) = before {
            assert!(solution.cost <= before.cost && solution.bound <= before.bound);
            assert!(
                before.inflation.is_none_or(|before| solution.inflation.is_some_and(|now| now <= before))
            );
        }
        before = Some(*solution);
    }
    assert!(plan.bound <= before.unwrap().bound && plan.cost >= cheapest);
    assert!(plan.cost as f64 <= plan.bound * cheapest as f64 * (1.0 + 1e-12));
}

#[test]
fn plans_to_the_end_are_as_cheap_as_dijkstra_finds() {
    let (mut found, mut improved, mut none, mut guided) = (0, 0, 0, 0);
    for seed in 0..400 {
        let world = World::drawn(seed);
        let mut planner = world.planner();
        match planner.plan(world.start, &world.goal, Effort::default(), &mut |_| true) {
            Ok(plan) => {
                let cheapest = world.cheapest().unwrap_or_else(|| panic!("seed {seed}: there is no way"));
                assert_eq!((plan.cost, plan.bound.to_bits()), (cheapest, 1.0_f64.to_bits()), "seed {seed}");
                world.assert_path(&plan);
                assert_solutions(&plan, cheapest);
                found += 1;
                improved += usize::from(u64::from(plan.solutions[0].cost) > plan.cost);
                guided += usize::from(world.guided_cells == 0 && !plan.steps.is_empty());
            }
            Err(PlanError::NoWay { .. }) => {
                assert_eq!(world.cheapest(), None, "seed {seed}");
                none += 1;
            }
            Err(PlanError::GoalBlocked(..)) => {
                assert!(world.is_goal(world.state(world.start)) || world.cheapest().is_none(), "seed {seed}");
            }
            Err(PlanError::StartBlocked(..)) => {
                let (north, east, heading) = world.state(world.start);
                let heading_radians = world.set.headings_radians()[heading];
                let rest = Pose { x_meters: 0.0, y_meters: 0.0, heading_radians };
                let is_free = world.is_free((north, east), rest) && world.cost(north, east).is_some();
                assert!(!is_free, "seed {seed}");
            }
            Err(error) => panic!("seed {seed}: {error}"),
        }
    }
    let hard = (found, improved, none, guided);
    assert!(found > 100 && improved > 40 && none > 20 && guided > 40, "{hard:?}");
}

#[test]
fn a_plan_that_is_stopped_at_any_time_keeps_its_bounds() {
    let mut between = 0;
    for seed in 0..60 {
        let world = World::drawn(seed);
        let Some(cheapest) = world.cheapest() else { continue };
        for questions in 0..6 {
            let mut asked = 0;
            let plan = world.planner().plan(world.start, &world.goal, Effort::default(), &mut |_| {
                asked += 1;
                asked <= questions
            });
            if let Ok(plan) = plan {
                world.assert_path(&plan);
                assert_solutions(&plan, cheapest);
                between += usize::from(plan.bound > 1.0);
            }
        }
    }
    assert!(between > 10, "{between}");
}

#[test]
fn a_plan_on_a_changed_map_is_that_of_a_new_planner() {
    let mut other = 0;
    for seed in 0..60 {
        let mut world = World::drawn(seed);
        let mut planner = world.planner();
        let before = planner.plan(world.start, &world.goal, Effort::default(), &mut |_| true);
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        for _ in 0..3 {
            let cells: Vec<_> = world.map.grid().cells().filter(|_| draw.random_bool(0.02)).collect();
            let costs: Vec<_> =
                cells.into_iter().map(|cell| (cell, draw.random_range(0..=u8::MAX))).collect();
            planner.set_costs(&costs).unwrap();
            for (cell, cost) in costs {
                world.map.set(cell, cost).unwrap();
            }
            let again = planner.plan(world.start, &world.goal, Effort::default(), &mut |_| true);
            let fresh = world.planner().plan(world.start, &world.goal, Effort::default(), &mut |_| true);
            assert_eq!(again, fresh, "seed {seed}");
            other += usize::from(before != again);
        }
    }
    assert!(other > 20, "{other}");
}

#[test]
fn bad_starts_and_goals_are_reported() {
    let seed = (0..100).find(|&seed| World::drawn(seed).cheapest().is_some_and(|cost| cost > 0)).unwrap();
    let world = World::drawn(seed);
    let mut planner = world.planner();
    let mut plan = |start: Pose, goal: Goal| planner.plan(start, &goal, Effort::default(), &mut |_| true);
    let far = 1e6;
    assert_eq!(
        plan(Pose { x_meters: far, ..world.start }, world.goal),
        Err(PlanError::StartOutside(far, world.start.y_meters))
    );
    assert_eq!(
        plan(world.start, Goal { y_meters: -far, ..world.goal }),
        Err(PlanError::GoalOutside(world.goal.x_meters, -far))
    );
    assert_eq!(
        plan(Pose { heading_radians: f64::NAN, ..world.start }, world.goal),
        Err(PlanError::NotFinite)
    );
    assert_eq!(plan(world.start, Goal { tolerance_meters: -1.0, ..world.goal }), Err(PlanError::NotFinite));
    let effort = Effort { first_inflation: 0.5, ..Effort::default() };
    let error = planner.plan(world.start, &world.goal, effort, &mut |_| true);
    assert_eq!(error, Err(PlanError::Effort { first: 0.5, step: 0.5 }));
    let larger = CostMap::new(Grid::new(1, 1).unwrap(), 0.1, (0.0, 0.0), vec![0]).unwrap();
    let message = planner.replace_map(larger).unwrap_err().to_string();
    assert_mentions(&message, "0.5 m .. 0.1 m .. equal");
    let cell = Grid::new(1_000, 1_000).unwrap().cell_numbered(999_999).unwrap();
    let message = planner.set_costs(&[(cell, 0)]).unwrap_err().to_string();
    assert!(message.starts_with("cell 999999 of a map of"), "{message}");
}

proptest! {
    #[test]
    fn no_numbers_panic(x in any::<f64>(), y in any::<f64>(), heading in any::<f64>(), near in any::<f64>()) {
        let world = World::drawn(1);
        let mut planner = world.planner();
        let start = Pose { x_meters: x, y_meters: y, heading_radians: heading };
        let goal = Goal { x_meters: x, y_meters: y, heading_radians: Some(heading), tolerance_meters: near };
        let _ = planner.plan(start, &world.goal, Effort::default(), &mut |_| true);
        let _ = planner.plan(world.start, &goal, Effort::default(), &mut |_| true);
        let inside = Goal { x_meters: world.goal.x_meters, y_meters: world.goal.y_meters, ..goal };
        let _ = planner.plan(world.start, &inside, Effort::default(), &mut |_| true);
    }
}
