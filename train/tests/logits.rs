//! A network in libtorch and in plain Rust computes the same decisions.
#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dragnet_learn::graph::{Graph, Memory};
use dragnet_learn::network::Network;
use dragnet_learn::shape::Shape;
use dragnet_learn::weights::{Recipe, Weights};
use dragnet_search::belief::Belief;
use dragnet_search::cell::{Cell, Grid};
use dragnet_search::generated::Generated;
use dragnet_search::intent::PlannedPrecision;
use dragnet_search::route::{Connectivity, ShortestPathTree};
use dragnet_search::seed::{Purpose, Stream, stream};
use dragnet_search::sensor::Sensor;
use dragnet_search::situation::Situation;
use dragnet_search::terrain::Terrain;
use dragnet_train::{Device, Model, set_threads};
use rand::RngExt;
use rand::seq::IndexedRandom;

/// The shape of the built-in networks; one that only decays, one that only sums; one without paths; one with levels.
const SHAPES: [Shape; 5] = [
    Shape::DEFAULT,
    Shape { hidden: 64, layers: 1, decay_channels: 5, sum_channels: 0, ..Shape::DEFAULT },
    Shape { hidden: 32, layers: 2, decay_channels: 0, sum_channels: 3, ..Shape::DEFAULT },
    Shape { hidden: 32, layers: 3, decay_channels: 0, sum_channels: 0, ..Shape::DEFAULT },
    Shape::PLANNING,
];

#[test]
fn the_network_that_learns_and_the_one_that_decides_are_one() {
    set_threads(1);
    for (seed, shape) in (0..).zip(SHAPES) {
        let mut random = stream(seed, Purpose::Training, 0);
        let weights = weights(shape, &mut random);
        let (network, model) = (Network::new(&weights), Model::of(&weights, Device::Cpu));
        for graph in graphs(shape, seed, &mut random) {
            let (difference, spread) = worst(&network.logits(&graph), &model.logits_of(&graph));
            let nodes = graph.topology.len();
            assert!(difference < 1e-4, "{shape:?}, {nodes} nodes: {difference}");
            assert!(spread > 1.0 || nodes == 1, "{shape:?}, {nodes} nodes: {spread}");
        }
    }
}

/// Weights of about the size that training starts from, no two alike.
fn weights(shape: Shape, random: &mut Stream) -> Weights {
    let fill = |_: &str, shape: &[usize]| {
        let limit = if shape.len() < 2 { 0.5 } else { (6.0 / (shape[0] + shape[1]) as f32).sqrt() };
        (0..shape.iter().product()).map(|_| random.random_range(-limit..limit)).collect()
    };
    Weights::build(shape, Recipe::default(), fill).unwrap()
}

/// A single cell and generated maps, with four and eight moves, and random beliefs and plans.
fn graphs(shape: Shape, seed: u64, random: &mut Stream) -> Vec<Graph> {
    let grid = Grid::new(9, 14).unwrap();
    let mut terrains = vec![Terrain::from_ascii("#~#\n#.#\n.##\n", 30.0).unwrap()];
    terrains.extend(Generated::ALL.map(|kind| kind.terrain(grid, 30.0, seed).unwrap()));
    let pairs = terrains.iter().flat_map(|terrain| {
        [Connectivity::Four, Connectivity::Eight].map(|connectivity| (terrain, connectivity))
    });
    pairs.map(|(terrain, connectivity)| graph(shape, terrain, connectivity, random)).collect()
}

fn graph(shape: Shape, terrain: &Terrain, connectivity: Connectivity, random: &mut Stream) -> Graph {
    let log_odds_nats = terrain.grid().cells().map(|cell| match random.random_range(0..20) {
        _ if !terrain.is_searched(cell) => f64::NEG_INFINITY,
        0 => -40.0,
        1 => 40.0,
        _ => random.random_range(-6.0..3.0),
    });
    let belief = Belief::from_log_odds(terrain, log_odds_nats.collect()).unwrap();
    let open: Vec<Cell> = terrain.traversable_cells().collect();
    let sensor = Sensor::default();
    let mut planned_precision = PlannedPrecision::nothing(terrain);
    let path: Vec<Cell> = (0..3).filter_map(|_| open.choose(random).copied()).collect();
    planned_precision.add_path(terrain, &sensor, &path);
    let robot = *terrain.largest_area().choose(random).unwrap();
    let (belief, planned_precision) = (&belief, &planned_precision);
    let situation =
        Situation { connectivity, ..Situation::alone(terrain, &sensor, belief, planned_precision, robot) };
    let routes = ShortestPathTree::from(terrain, connectivity, robot);
    Graph::of_shape(shape, &situation, &routes, &mut Memory::default())
}

/// The largest difference between two lists of logits, and the range of the first.
fn worst(ours: &[f32], theirs: &[f32]) -> (f32, f32) {
    assert_eq!(ours.len(), theirs.len());
    let differences = ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs());
    let most = ours.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let least = ours.iter().copied().fold(f32::INFINITY, f32::min);
    (differences.fold(0.0, f32::max), most - least)
}
