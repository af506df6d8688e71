//! The world: objects, robots, and readings.

use std::sync::Arc;
use std::time::Duration;

use dragnet_proto::marks::Marks;
use dragnet_proto::verdict::Verdicts;
use dragnet_proto::zones::Zones;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Class, Objects, Scenario, Start};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::evidence::{CellEvidence, Reading};
use dragnet_search::line_of_sight::LineOfSight;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::observation::RobotId;
use dragnet_search::reach::Reach;
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::separation::{Separation, swept};
use dragnet_search::subjects::{Standing, Subjects};
use dragnet_search::terrain::Terrain;
use rand::RngExt;
use rand::seq::IndexedRandom;

/// Maximum time to the next cell, beyond any mission.
const LONGEST_SECONDS: f64 = 1e10;

/// Objects and robots on the map, and the belief from all readings together.
#[derive(Clone)]
pub struct World {
    terrain: Terrain,
    truth: Truth,
    bodies: Vec<Body>,
    separation: Separation,
    /// Robots that cannot enter the next cell of their routes yet, because of others; who waits longest is first.
    held: Vec<RobotId>,
    /// The belief from all readings of all robots.
    merged: Belief,
    /// That the number of objects is known, if so.
    subjects: Option<Subjects>,
    /// Cells that robots can observe, given their start cells.
    reach: Reach,
    detection_threshold: f64,
    score: Score,
    /// The operator's verdicts, which the merged belief contains.
    verdicts: Verdicts,
    /// The operator's zones.
    zones: Zones,
    /// The operator's marks, which the merged belief contains.
    marks: Marks,
    /// Whether readings are rounded as radios carry them.
    is_rounding: bool,
}

/// A robot's body.
#[derive(Clone)]
pub struct Body {
    /// Its cell.
    pub cell: Cell,
    /// The cell that it started in.
    start: Cell,
    /// Cells to enter, the next one last.
    route: Vec<Cell>,
    /// Whether it is on its way to the next one.
    is_under_way: bool,
    /// Number of its routes: an arrival of an older one is ignored.
    pub route_number: u64,
    /// Path length, in cells; a diagonal counts sqrt 2.
    pub path_cells: f64,
    class: Arc<Class>,
    noise: Stream,
}

impl Body {
    /// Whether its route has further cells.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        !self.route.is_empty()
    }

    /// The cells that it is in: its own, and those of a move that it is making.
    fn occupied(&self, grid: Grid) -> Vec<Cell> {
        match self.route.last().filter(|_| self.is_under_way) {
            Some(&next) => swept(grid, self.cell, next),
            None => vec![self.cell],
        }
    }
}

impl World {
    /// The world of an episode: truth, starts and noise depend on the seed alone, not on the policy.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64) -> Self {
        let terrain = scenario.terrain();
        let truth = draw_truth(scenario, &mut stream(seed, Purpose::Truth, 0));
        let bodies = draw_starts(scenario, seed)
            .into_iter()
            .zip(scenario.robots())
            .map(|(cell, robot)| Body {
                cell,
                start: cell,
                route: Vec::new(),
                is_under_way: false,
                route_number: 0,
                path_cells: 0.0,
                class: Arc::clone(&robot.class),
                noise: stream(seed, Purpose::Noise, robot.id.number()),
            })
            .collect();
        let reach = draw_reach(scenario, seed);
        let (merged, detection_threshold) =
            (scenario.prior().clone(), scenario.mission().detection_threshold);
        let score = Score::of(terrain, &reach, &merged, &truth, detection_threshold);
        Self {
            terrain: terrain.clone(),
            truth,
            bodies,
            separation: scenario.separation(),
            held: Vec::new(),
            merged,
            subjects: scenario.subjects(),
            reach,
            detection_threshold,
            score,
            verdicts: Verdicts::default(),
            zones: Zones::default(),
            marks: Marks::default(),
            is_rounding: scenario.network().bytes_per_second.is_some(),
        }
    }

    /// The objects.
    #[must_use]
    pub const fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The belief from all readings together.
    #[must_use]
    pub fn into_merged(self) -> Belief {
        self.merged
    }

    /// The belief from all readings together.
    #[must_use]
    pub const fn merged(&self) -> &Belief {
        &self.merged
    }

    /// Cells that robots can observe, given their start cells.
    #[must_use]
    pub const fn reach(&self) -> &Reach {
        &self.reach
    }

    /// Expected number of objects that the merged belief has not found, counting cells in reach.
    #[must_use]
    pub fn expected_remaining(&self) -> f64 {
        match self.subjects {
            Some(it) => {
                it.expected_remaining(&self.merged, &self.terrain, &self.reach, |cell| self.is_found(cell))
            }
            None => self.merged.expected_remaining(&self.terrain, &self.reach, self.detection_threshold),
        }
    }

    /// Where the subjects are by the merged belief, if their number is known.
    #[must_use]
    pub fn subject(&self) -> Option<Standing> {
        let posterior = self.subjects?.posterior(&self.merged);
        Some(posterior.standing(&self.terrain, &self.reach, |cell| self.is_found(cell)))
    }

    /// Probability of an object in a cell by the merged belief; of a subject, if their number is known.
    #[must_use]
    pub fn probability(&self, cell: Cell) -> f64 {
        match self.subjects.map(|it| it.posterior(&self.merged)) {
            Some(posterior) => posterior.probability(cell),
            None => self.merged.probability(cell),
        }
    }

    /// The merged belief compared with the truth, counting cells in reach.
    #[must_use]
    pub const fn score(&self) -> Score {
        self.score
    }

    /// The body of a robot of the scenario.
    #[must_use]
    pub fn body(&self, robot: RobotId) -> &Body {
        &self.bodies[robot.index()]
    }

    fn body_mut(&mut self, robot: RobotId) -> &mut Body {
        &mut self.bodies[robot.index()]
    }

    /// Path length of each robot, cells.
    pub fn path_cells(&self) -> impl Iterator<Item = f64> + '_ {
        self.bodies.iter().map(|body| body.path_cells)
    }

    /// Whether each robot is in the cell that it started in.
    pub fn at_start(&self) -> impl Iterator<Item = bool> + '_ {
        self.bodies.iter().map(|body| body.cell == body.start)
    }

    /// The longest path length of a robot, cells.
    #[must_use]
    pub fn farthest_cells(&self) -> f64 {
        self.path_cells().fold(0.0, f64::max)
    }

    /// Sets a robot's route: cells to enter, in order. Between two cells it turns around.
    pub fn set_route(&mut self, robot: RobotId, mut route: Vec<Cell>) {
        route.reverse();
        let body = self.body_mut(robot);
        body.route = route;
        body.route_number += 1;
        body.is_under_way = false;
        self.held.retain(|&held| held != robot);
    }

    /// A robot sets off for the next cell of its route: the time that it takes. `None` where its route ends, and while robots
    /// are to keep apart and another one is in its way; then it is held until [`World::set_off_held`] finds the way clear.
    #[must_use]
    pub fn set_off(&mut self, robot: RobotId) -> Option<Duration> {
        let body = self.body(robot);
        let next = *body.route.last()?;
        if !self.is_clear(robot, next) {
            if !self.held.contains(&robot) {
                self.held.push(robot);
            }
            return None;
        }
        let time = self.time_over(robot, self.distance_cells(body.cell, next));
        self.body_mut(robot).is_under_way = true;
        Some(time)
    }

    /// Robots that were held and now set off, with the times that they take; to be called whenever one has come to a cell, or
    /// has a new route.
    #[must_use]
    pub fn set_off_held(&mut self) -> Vec<(RobotId, Duration)> {
        let held = std::mem::take(&mut self.held);
        held.into_iter().filter_map(|robot| Some((robot, self.set_off(robot)?))).collect()
    }

    /// Whether no other robot is nearer to a robot's move than robots are to be. What flies passes above the others.
    fn is_clear(&self, robot: RobotId, next: Cell) -> bool {
        if !self.separation.is_kept() {
            return true;
        }
        let (grid, own) = (self.terrain.grid(), self.body(robot));
        let swept = swept(grid, own.cell, next);
        // Both may be a cell from where they were.
        let near = self.separation.wider(2);
        let others = self.bodies.iter().enumerate().filter(|&(place, _)| place != robot.index());
        others
            .filter(|(_, body)| {
                body.class.flies == own.class.flies && !near.is_apart(grid, own.cell, body.cell)
            })
            .all(|(_, body)| self.separation.are_apart(grid, &swept, &body.occupied(grid)))
    }

    /// A robot enters the next cell of its route.
    pub fn advance(&mut self, robot: RobotId) {
        let body = self.body(robot);
        if let Some(&next) = body.route.last() {
            let distance = self.distance_cells(body.cell, next);
            let body = self.body_mut(robot);
            body.route.pop();
            body.is_under_way = false;
            body.cell = next;
            body.path_cells += distance;
        }
    }

    /// The time that a robot takes over a number of cells.
    #[must_use]
    pub fn time_over(&self, robot: RobotId, distance_cells: f64) -> Duration {
        let speed = self.body(robot).class.speed_meters_per_second;
        let seconds = distance_cells * self.terrain.cell_meters() / speed;
        Duration::from_secs_f64(seconds.min(LONGEST_SECONDS))
    }

    fn distance_cells(&self, from: Cell, to: Cell) -> f64 {
        self.terrain.grid().offset(from, to).euclidean()
    }

    /// Moves a robot to another cell, independently of its route; the path length grows by the straight-line distance.
    pub fn enter(&mut self, robot: RobotId, cell: Cell) {
        let distance = self.distance_cells(self.body(robot).cell, cell);
        let body = self.body_mut(robot);
        body.cell = cell;
        body.path_cells += distance;
    }

    /// A robot observes: a reading of every cell of its footprint. Returns them, and the cells that have become found
    /// in the merged belief.
    pub fn sense(&mut self, robot: RobotId) -> (Vec<Reading>, Vec<Cell>) {
        let cells = self.body(robot).class.sensor.footprint().len();
        let (mut readings, mut found) = (Vec::with_capacity(cells), Vec::new());
        self.sense_into(robot, &mut readings, &mut found);
        (readings, found)
    }

    /// Like [`World::sense`], appending to the given lists.
    pub fn sense_into(&mut self, robot: RobotId, readings: &mut Vec<Reading>, found: &mut Vec<Cell>) {
        let sensor = Arc::clone(&self.body(robot).class.sensor);
        let (grid, from) = (self.terrain.grid(), self.body(robot).cell);
        let line_of_sight = if self.body(robot).class.flies {
            LineOfSight::everywhere()
        } else {
            self.terrain.line_of_sight().clone()
        };
        for (cell, footprint_cell) in line_of_sight.seen(grid, &sensor, from) {
            let is_object = self.truth.is_object(cell);
            let value = sensor.draw(is_object, footprint_cell, &mut self.body_mut(robot).noise);
            let reading = Reading { cell, value, variance: footprint_cell.variance };
            let reading = if self.is_rounding { reading.rounded() } else { reading };
            if self.merge(cell, reading.evidence_of(footprint_cell.precision)) {
                found.push(cell);
            }
            readings.push(reading);
        }
    }

    /// Whether the merged belief has found a cell.
    #[must_use]
    pub fn is_found(&self, cell: Cell) -> bool {
        self.merged.is_found(cell, self.detection_threshold)
    }

    /// Merges the operator's marks into the merged belief.
    pub fn mark(&mut self, now: MissionTime, marks: &Marks) {
        // Robots repeat them beside each heartbeat.
        if self.marks.includes_all(marks) {
            return;
        }
        let was_found: Vec<Cell> =
            self.terrain.searched_cells().filter(|&cell| self.is_found(cell)).collect();
        let (grid, prior) = (self.terrain.grid(), self.merged.shared_prior());
        let marked = self.marks.merge_into(now, marks, grid, &prior, &mut self.merged);
        for cell in marked.into_iter().flatten() {
            self.rate(cell, was_found.binary_search(&cell).is_ok());
        }
    }

    /// Merges the operator's verdicts into the merged belief.
    pub fn judge(&mut self, now: MissionTime, verdicts: &Verdicts) {
        let before: Vec<(Cell, bool)> =
            verdicts.iter().map(|(cell, _)| (cell, self.is_found(cell))).collect();
        self.verdicts.merge(now, verdicts, &mut self.merged);
        for (cell, was_found) in before {
            self.rate(cell, was_found);
        }
    }

    /// Merges the operator's zones.
    pub fn close(&mut self, now: MissionTime, zones: &Zones) {
        self.zones.merge(now, zones);
    }

    /// The operator's zones.
    #[must_use]
    pub const fn zones(&self) -> &Zones {
        &self.zones
    }

    /// The operator's verdicts.
    #[must_use]
    pub const fn verdicts(&self) -> &Verdicts {
        &self.verdicts
    }

    /// Whether a cell has become found.
    fn merge(&mut self, cell: Cell, evidence: CellEvidence) -> bool {
        let before = self.is_found(cell);
        self.merged.add_evidence(cell, evidence);
        self.rate(cell, before)
    }

    /// Updates the score by a cell that was found before or not; returns whether it has become found.
    fn rate(&mut self, cell: Cell, was_found: bool) -> bool {
        let is_found = self.is_found(cell);
        if was_found != is_found && self.terrain.is_searched(cell) && self.reach.covers(cell) {
            self.score.change(is_found, self.truth.is_object(cell));
        }
        is_found && !was_found
    }
}

pub(crate) fn draw_truth(scenario: &Scenario, random: &mut Stream) -> Truth {
    let terrain = scenario.terrain();
    let searched: Vec<Cell> = terrain.searched_cells().collect();
    let cells = match (scenario.objects(), scenario.object_weights()) {
        (Objects::Count(count), weights) => match (scenario.subjects(), weights) {
            (Some(subjects), _) if subjects.number() > 1 => several(scenario, subjects, random),
            (Some(subjects), _) if random.random::<f64>() < subjects.rest_of_world() => Vec::new(),
            (_, None) => searched.sample(random, *count as usize).copied().collect(),
            (_, Some(weights)) => sample(searched, weights, *count, random),
        },
        (Objects::Density(density), None) => {
            searched.into_iter().filter(|_| random.random::<f64>() < *density).collect()
        }
        (Objects::Density(density), Some(weights)) => {
            let factor = density * searched.len() as f64 / weights.iter().sum::<f64>();
            let is_drawn = |cell: &Cell| random.random::<f64>() < factor * weights[cell.index()];
            searched.into_iter().filter(is_drawn).collect()
        }
        (Objects::Cells(cells), _) => cells.clone(),
    };
    Truth::new(terrain, cells)
}

/// Cells of several subjects, by the prior or in all searched cells alike.
fn several(scenario: &Scenario, subjects: Subjects, random: &mut Stream) -> Vec<Cell> {
    let terrain = scenario.terrain();
    let searched = terrain.searched_cells().count() as f64;
    let share = f64::from(subjects.number()) * (1.0 - subjects.rest_of_world()) / searched;
    let alike = Belief::uniform(terrain, share).ok().filter(|_| scenario.object_weights().is_none());
    let places = subjects.draw(alike.as_ref().unwrap_or(scenario.prior()), random);
    let cells: Vec<Cell> = terrain.grid().cells().collect();
    places.into_iter().map(|place| cells[place]).collect()
}

/// So many of the cells, one after the other, each in proportion to its weight.
fn sample(mut cells: Vec<Cell>, weights: &[f64], count: u32, random: &mut Stream) -> Vec<Cell> {
    cells.retain(|cell| weights[cell.index()] > 0.0);
    let mut drawn = Vec::new();
    while drawn.len() < count as usize && !cells.is_empty() {
        let total: f64 = cells.iter().map(|cell| weights[cell.index()]).sum();
        let mut left = random.random::<f64>() * total;
        let place = cells.iter().position(|cell| {
            left -= weights[cell.index()];
            left < 0.0
        });
        // By rounding the sum may end above 0: that is the last cell.
        drawn.push(cells.remove(place.unwrap_or(cells.len() - 1)));
    }
    drawn
}

pub(crate) fn draw_starts(scenario: &Scenario, seed: u64) -> Vec<Cell> {
    let areas = scenario.terrain().connected_areas();
    let any = |area: usize, robot: Option<RobotId>| {
        let mut random = stream(seed, Purpose::Start, robot.map_or(0, RobotId::number));
        let cells = &areas[area];
        cells[random.random_range(0..cells.len())]
    };
    let drawn = scenario.robots().iter().map(|robot| match robot.start {
        Start::Together { area } => any(area, None),
        Start::Scattered => any(0, Some(robot.id)),
        Start::Cell(cell) => cell,
    });
    scenario.apart(drawn.collect())
}

/// Cells that robots can observe, given their start cells.
pub(crate) fn draw_reach(scenario: &Scenario, seed: u64) -> Reach {
    let mut reach = Reach::unknown(scenario.terrain().grid());
    for (robot, start) in scenario.robots().iter().zip(draw_starts(scenario, seed)) {
        reach.add_robot(scenario.terrain(), robot.class.sight(), start);
    }
    reach
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A scenario of 2 x 4 cells, blocked in the north-east, whose prior is 0 in the first of its southern cells.
    fn with_prior(objects: &str) -> Scenario {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.txt"), "...#\n....\n").unwrap();
        std::fs::write(folder.path().join("a.csv"), "0.01,0.01,0.01,0.01\n0,0.03,0.2,0.05\n").unwrap();
        let text = format!(
            "name = 'a'\nmap = {{ file = 'a.txt', cell_meters = 10.0 }}\nsensor.radius = 1\n\
             prior.file = 'a.csv'\nmission.budget_seconds = 60.0\n[objects]\n{objects}\n"
        );
        Scenario::from_text(&folder.path().join("a.toml"), text).unwrap()
    }

    /// In how many of 4,000 seeds each searched cell holds an object.
    fn drawn(objects: &str) -> Vec<u32> {
        let scenario = with_prior(objects);
        let mut counts = vec![0; 8];
        for seed in 0..4_000 {
            let truth = draw_truth(&scenario, &mut stream(seed, Purpose::Truth, 0));
            truth.objects().iter().for_each(|cell| counts[cell.index()] += 1);
        }
        counts
    }

    fn assert_near(counts: &[u32], expected: [f64; 8]) {
        for (&count, expected) in counts.iter().zip(expected) {
            let (mean, deviation) = (4_000.0 * expected, (4_000.0 * expected * (1.0 - expected)).sqrt());
            assert!((f64::from(count) - mean).abs() <= 4.0 * deviation, "{counts:?}: {count}, {mean}");
        }
    }

    #[test]
    fn objects_lie_where_the_prior_expects_them() {
        // Of 0.31 in all, row by row from the south.
        let shares = [0.0, 0.03, 0.2, 0.05, 0.01, 0.01, 0.01, 0.0].map(|share| share / 0.31);
        assert_near(&drawn("count = 1"), shares);
        // The mean over seven searched cells is the density.
        assert_near(&drawn("density = 0.1"), shares.map(|share| 0.7 * share));
        let all = drawn("count = 6");
        assert_eq!(all, [0, 4_000, 4_000, 4_000, 4_000, 4_000, 4_000, 0]);
        let alike = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0].map(|share: f64| share / 7.0);
        assert_near(&drawn("count = 1\nplacement = 'uniform'"), alike);
    }

    #[test]
    fn however_slow_a_robot_is_its_path_takes_some_time() {
        let text = "name = 'a'\nmap = { shape = 'all_traversable', rows = 1, columns = 2, cell_meters = 10.0 }\n\
                    sensor.radius = 1\nobjects.count = 1\nrobots.start = [0, 0]\nmission.budget_seconds = 60.0\n";
        let scenario = Scenario::from_text(Path::new("a.toml"), text.to_owned()).unwrap();
        let mut world = World::new(&scenario, 1);
        assert_eq!(world.set_off(RobotId::FIRST), None);
        world.set_route(RobotId::FIRST, scenario.terrain().grid().cells().skip(1).collect());
        for (speed, seconds) in [(2.0, 5.0), (5e-324, LONGEST_SECONDS)] {
            Arc::make_mut(&mut world.bodies[0].class).speed_meters_per_second = speed;
            let time = world.set_off(RobotId::FIRST);
            assert_eq!(time, Some(Duration::from_secs_f64(seconds)), "{speed}");
        }
    }
}
