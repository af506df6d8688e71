//! Plans over 300 m at 10 cm: the time to the first path, and its cost after a second.
//!
//! A plain program, since what counts is one plan from a clean start: `cargo bench -p dragnet-vehicle --bench lattice`.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot run should say so and end")]

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use dragnet_lattice::costmap::{CostMap, LETHAL};
use dragnet_lattice::footprint::Footprint;
use dragnet_lattice::maneuvers::{Headings, Maneuvers};
use dragnet_lattice::plan::{Effort, Goal, Plan};
use dragnet_lattice::plane::Pose;
use dragnet_lattice::planner::Planner;
use dragnet_search::cell::{Grid, Position};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SIDE: u32 = 3_000;
const RESOLUTION_METERS: f64 = 0.1;
const MANEUVERS: Maneuvers = Maneuvers {
    resolution_meters: RESOLUTION_METERS,
    headings: Headings::Sixteen,
    turning_radius_meters: 1.0,
    reverse: None,
    turn_in_place: None,
};

/// The obstacles of a map.
#[derive(Clone, Copy, Debug)]
enum Obstacles {
    /// Nothing.
    None,
    /// Boxes of 1 to 6 m, on about an eighth of the ground.
    Boxes,
    /// Walls every 30 m, each with two doors of 3 m.
    Rooms,
    /// Boxes, on ground whose cost is drawn for each 5 m.
    Terrain,
}

fn map(obstacles: Obstacles, seed: u64) -> CostMap {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let mut costs = vec![0_u8; (SIDE * SIDE) as usize];
    let fill = |costs: &mut [u8], west: u32, south: u32, width: u32, height: u32, cost: u8| {
        for row in south..(south + height).min(SIDE) {
            let first = (row * SIDE) as usize;
            costs[first + west as usize..first + (west + width).min(SIDE) as usize].fill(cost);
        }
    };
    if matches!(obstacles, Obstacles::Terrain) {
        for south in (0..SIDE).step_by(50) {
            for west in (0..SIDE).step_by(50) {
                fill(&mut costs, west, south, 50, 50, draw.random_range(0..4));
            }
        }
    }
    match obstacles {
        Obstacles::None => {}
        Obstacles::Boxes | Obstacles::Terrain => {
            for _ in 0..1_000 {
                let (width, height) = (draw.random_range(10..60), draw.random_range(10..60));
                let (west, south) = (draw.random_range(0..SIDE), draw.random_range(0..SIDE));
                fill(&mut costs, west, south, width, height, LETHAL);
            }
        }
        Obstacles::Rooms => {
            for line in (300..SIDE).step_by(300) {
                fill(&mut costs, line, 0, 2, SIDE, LETHAL);
                fill(&mut costs, 0, line, SIDE, 2, LETHAL);
            }
            for line in (300..SIDE).step_by(300) {
                for room in (0..SIDE).step_by(300) {
                    let door = room + draw.random_range(40..230);
                    fill(&mut costs, line, door, 2, 30, 0);
                    let door = room + draw.random_range(40..230);
                    fill(&mut costs, door, line, 30, 2, 0);
                }
            }
        }
    }
    for (west, south) in [(0, 1450), (SIDE - 100, 1450), (0, 0), (SIDE - 100, SIDE - 100)] {
        fill(&mut costs, west, south, 100, 100, 0);
    }
    CostMap::new(Grid::new(SIDE, SIDE).unwrap(), RESOLUTION_METERS, (0.0, 0.0), costs).unwrap()
}

/// CPU time of this program, which has one thread, so that other programs do not count. Wall-clock time if the system
/// does not provide it.
fn computed() -> Duration {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    let text = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = text.and_then(|text| text.split_ascii_whitespace().next()?.parse().ok());
    nanoseconds.map_or_else(|| BEGIN.get_or_init(Instant::now).elapsed(), Duration::from_nanos)
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// A box appears halfway along; the vehicle receives it after a tenth of the path. Time to a new first path.
fn replan(planner: &mut Planner, plan: &Plan, goal: &Goal) -> Duration {
    let middle = plan.poses[plan.poses.len() / 2];
    let now = plan.poses[plan.poses.len() / 10];
    let grid = planner.map().grid();
    let Position { row, column } =
        grid.position(planner.map().cell_at(middle.x_meters, middle.y_meters).unwrap());
    let blocked: Vec<_> = (row - 10..row + 10)
        .flat_map(|row| (column - 10..column + 10).map(move |column| Position { row, column }))
        .filter_map(|position| grid.cell(position))
        .map(|cell| (cell, LETHAL))
        .collect();
    let begin = computed();
    planner.set_costs(&blocked).unwrap();
    planner.plan(now, goal, Effort::default(), &mut |progress| progress.solution.is_none()).unwrap();
    computed().saturating_sub(begin)
}

fn report(obstacles: Obstacles, seed: u64, from: (f64, f64), to: (f64, f64)) {
    let (map, set) = (map(obstacles, seed), MANEUVERS.primitives().unwrap());
    let begin = computed();
    let mut planner = Planner::new(set, &Footprint::rectangle(0.8, 0.6), map).unwrap();
    let making = computed().saturating_sub(begin);
    let start = Pose { x_meters: from.0, y_meters: from.1, heading_radians: 0.0 };
    let goal = Goal { x_meters: to.0, y_meters: to.1, heading_radians: Some(0.0), tolerance_meters: 0.0 };
    let begin = computed();
    let (mut first, mut received) = (None, begin);
    let plan = planner
        .plan(start, &goal, Effort::default(), &mut |progress| {
            received = computed();
            if first.is_none() && progress.solution.is_some() {
                first = Some(received.saturating_sub(begin));
            }
            received.saturating_sub(begin) < Duration::from_secs(1)
        })
        .unwrap();
    let whole = computed().saturating_sub(begin);
    let memory = planner.memory_bytes() as f64 / 1e6;
    println!(
        "{:8} {seed:4} {:9.1} {:9.1} {:6.3} {:10.4} {:8.1} {:9.5} {:9} {:8.1} {memory:9.1} {:9.1}",
        format!("{obstacles:?}"),
        milliseconds(making),
        milliseconds(first.unwrap()),
        plan.solutions[0].bound,
        f64::from(plan.solutions[0].cost) / plan.cost as f64,
        milliseconds(whole),
        plan.bound,
        plan.expansions,
        plan.length_meters,
        milliseconds(replan(&mut planner, &plan, &goal)),
    );
}

fn main() {
    println!(
        "                making     first        first /    plan,                                 memory    replan"
    );
    println!(
        "map      seed       ms  path, ms  bound       last  <= 1 s     bound  expanded length m        MB  first, ms"
    );
    for obstacles in [Obstacles::None, Obstacles::Boxes, Obstacles::Rooms, Obstacles::Terrain] {
        for (seed, from, to) in [
            (1, (5.0, 150.0), (295.0, 150.0)),
            (2, (5.0, 150.0), (295.0, 152.0)),
            (3, (5.0, 5.0), (295.0, 295.0)),
        ] {
            report(obstacles, seed, from, to);
        }
    }
}
