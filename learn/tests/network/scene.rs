//! Random situations: maps of many kinds, beliefs from ignorance to certainty, with and without a teammate.

use std::sync::Arc;

use dragnet_learn::graph::{Graph, Memory, Topology};
use dragnet_learn::shape::Shape;
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid, Offset, Position};
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::{Ground, Terrain};
use rand::RngExt;
use rand::seq::IndexedRandom;

use crate::motion::Motion;

/// The parts of a situation.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) terrain: Terrain,
    pub(crate) connectivity: Connectivity,
    pub(crate) robot: Cell,
    log_odds_nats: Vec<f64>,
    planned_precision: PlannedPrecision,
}

impl Scene {
    /// A robot somewhere on a terrain, with a random belief and random plans of teammates.
    fn draw(name: &str, terrain: Terrain, connectivity: Connectivity, random: &mut Stream) -> Self {
        let open: Vec<Cell> = terrain.traversable_cells().collect();
        let log_odds_nats = terrain.grid().cells().map(|cell| match random.random_range(0..20) {
            _ if !terrain.is_searched(cell) => f64::NEG_INFINITY,
            0 => -40.0,
            1 => 40.0,
            _ => random.random_range(-6.0..3.0),
        });
        let log_odds_nats = log_odds_nats.collect();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        if random.random() {
            let path: Vec<Cell> = (0..3).filter_map(|_| open.choose(random).copied()).collect();
            planned_precision.add_path(&terrain, &Sensor::default(), &path);
        }
        let robot = *open.choose(random).unwrap();
        Self {
            name: format!("{name}, {connectivity:?} moves"),
            terrain,
            connectivity,
            robot,
            log_odds_nats,
            planned_precision,
        }
    }

    /// A robot with this belief, and a teammate that plans to observe from these cells.
    pub(crate) fn by_hand(terrain: Terrain, robot: Position, log_odds_nats: Vec<f64>, plan: &[Cell]) -> Self {
        let robot = terrain.grid().cell(robot).unwrap();
        let mut planned_precision = PlannedPrecision::nothing(&terrain);
        planned_precision.add_path(&terrain, &Sensor::default(), plan);
        Self {
            name: "by hand".to_owned(),
            terrain,
            connectivity: Connectivity::Four,
            robot,
            log_odds_nats,
            planned_precision,
        }
    }

    pub(crate) fn routes(&self) -> ShortestPathTree {
        ShortestPathTree::from(&self.terrain, self.connectivity, self.robot)
    }

    pub(crate) fn topology(&self) -> Arc<Topology> {
        Arc::new(Topology::new(&self.terrain, &self.routes()))
    }

    pub(crate) fn graph(&self) -> Graph {
        self.graph_of(Shape::DEFAULT)
    }

    /// The graph that a network of this shape takes.
    pub(crate) fn graph_of(&self, shape: Shape) -> Graph {
        let (belief, sensor) =
            (Belief::from_log_odds(&self.terrain, self.log_odds_nats.clone()).unwrap(), Sensor::default());
        let situation = Situation {
            connectivity: self.connectivity,
            ..Situation::alone(&self.terrain, &sensor, &belief, &self.planned_precision, self.robot)
        };
        Graph::of_shape(shape, &situation, &self.routes(), &mut Memory::default())
    }

    /// The same on a map that is mirrored, turned and moved; cells added around it are blocked.
    pub(crate) fn moved(&self, motion: Motion) -> Self {
        let grid = self.terrain.grid();
        let moved = motion.grid(grid);
        let mut ground = vec![Ground::BLOCKED; moved.cell_count()];
        let mut log_odds_nats = vec![f64::NEG_INFINITY; moved.cell_count()];
        let mut precision = vec![0; moved.cell_count()];
        for cell in grid.cells() {
            let to = motion.cell(grid, cell).index();
            ground[to] = self.terrain.ground(cell);
            log_odds_nats[to] = self.log_odds_nats[cell.index()];
            precision[to] = self.planned_precision.precision(cell);
        }
        Self {
            name: format!("{}, {motion:?}", self.name),
            terrain: Terrain::new(moved, self.terrain.cell_meters(), ground).unwrap(),
            connectivity: self.connectivity,
            robot: motion.cell(grid, self.robot),
            log_odds_nats,
            planned_precision: PlannedPrecision::from_precision(precision).unwrap(),
        }
    }
}

/// An open map, one with obstacles of all kinds, a maze and a cell alone, each with both kinds of moves.
pub(crate) fn scenes(seed: u64) -> Vec<Scene> {
    let mut random = stream(seed, Purpose::Map, 0);
    let mut scenes = Vec::new();
    for connectivity in [Connectivity::Four, Connectivity::Eight] {
        let alone = Terrain::from_ascii("#~#\n#.#\n.##\n", 30.0).unwrap();
        let mut alone = Scene::draw("a cell alone", alone, connectivity, &mut random);
        alone.robot = at(alone.terrain.grid(), 1, 1);
        scenes.extend([alone, maze(5, 7, connectivity, &mut random)]);
        scenes.push(open(9, connectivity, &mut random));
        let grid = Grid::new(8, 13).unwrap();
        let ground = grid.cells().map(|_| match random.random_range(0..10) {
            0 | 1 => Ground::BLOCKED,
            2 => Ground::OUT_OF_REACH,
            3 => Ground::PASSAGE,
            _ => Ground::OPEN,
        });
        let terrain = Terrain::new(grid, 30.0, ground.collect()).unwrap();
        let largest = terrain.largest_area();
        let mut scene = Scene::draw("obstacles", terrain, connectivity, &mut random);
        scene.robot = *largest.choose(&mut random).unwrap();
        scenes.push(scene);
    }
    scenes
}

/// An all-traversable map.
pub(crate) fn open(side: u32, connectivity: Connectivity, random: &mut Stream) -> Scene {
    let grid = Grid::new(side, side).unwrap();
    let terrain = Terrain::new(grid, 30.0, vec![Ground::OPEN; grid.cell_count()]).unwrap();
    Scene::draw(&format!("open, {side} x {side}"), terrain, connectivity, random)
}

/// A maze without loops, whose halls are one cell wide: rooms are the cells of odd rows and columns, and a random walk
/// with backtracking opens a wall to each. So there is one path between any two cells, with diagonals too, since none
/// cuts a corner.
pub(crate) fn maze(rows: u32, columns: u32, connectivity: Connectivity, random: &mut Stream) -> Scene {
    let grid = Grid::new(2 * rows + 1, 2 * columns + 1).unwrap();
    let mut ground = vec![Ground::BLOCKED; grid.cell_count()];
    let mut walk = vec![at(grid, 1, 1)];
    ground[walk[0].index()] = Ground::OPEN;
    while let Some(&room) = walk.last() {
        let sides = [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(north, east)| Offset { north, east });
        let unseen = |side: &Offset| {
            let beyond = grid.step(room, Offset { north: 2 * side.north, east: 2 * side.east })?;
            (ground[beyond.index()] == Ground::BLOCKED).then_some((grid.step(room, *side)?, beyond))
        };
        let unseen: Vec<(Cell, Cell)> = sides.iter().filter_map(unseen).collect();
        if let Some(&(wall, beyond)) = unseen.choose(random) {
            ground[wall.index()] = Ground::OPEN;
            ground[beyond.index()] = Ground::OPEN;
            walk.push(beyond);
        } else {
            walk.pop();
        }
    }
    let terrain = Terrain::new(grid, 30.0, ground).unwrap();
    Scene::draw("maze", terrain, connectivity, random)
}

fn at(grid: Grid, row: u32, column: u32) -> Cell {
    grid.cell(Position { row, column }).unwrap()
}
