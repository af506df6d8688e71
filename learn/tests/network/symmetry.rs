//! A map that is mirrored, turned or moved changes no decision.

use std::sync::Arc;

use dragnet_learn::graph::{FEATURES, Graph};
use dragnet_learn::network::Network;
use dragnet_search::cell::Grid;
use dragnet_search::route::Connectivity;
use dragnet_search::seed::{Purpose, stream};

use crate::motion::{Margin, Motion};
use crate::scene::{Scene, maze, open, scenes};
use crate::{LEVELS, PATHLESS, PATHLESS_LEVELS, SHAPES, TOLERANCE, weights};

const SEEDS: std::ops::Range<u64> = 0..3;

/// The graph of a scene with its nodes permuted by a motion, paths included.
fn carried(graph: &Graph, scene: &Scene, motion: Motion) -> Graph {
    let grid = scene.terrain.grid();
    let topology = scene.moved(motion).topology();
    let cells = graph.topology.cells();
    let node: Vec<u32> = cells.iter().map(|&cell| topology.node(motion.cell(grid, cell))).collect();
    let to = |from: u32| node[from as usize];
    let mut features = vec![0.0; graph.features.len()];
    let mut parent = vec![0; node.len()];
    for (from, &node) in node.iter().enumerate() {
        let place = node as usize * FEATURES;
        features[place..place + FEATURES].copy_from_slice(&graph.features[from * FEATURES..][..FEATURES]);
        parent[node as usize] = to(graph.parent[from]);
    }
    Graph {
        features,
        root: to(graph.root),
        parent,
        order: graph.order.iter().map(|&from| to(from)).collect(),
        topology: Arc::clone(&topology),
        levels: Vec::new(),
    }
}

/// The output of a network for a graph.
struct Answer<'a> {
    graph: &'a Graph,
    logits: Vec<f32>,
}

impl<'a> Answer<'a> {
    fn of(network: &Network, graph: &'a Graph) -> Self {
        Self { graph, logits: network.logits(graph) }
    }

    /// The difference between logits and those of the moved map; `None` if the motion maps a node to a cell that is
    /// none.
    fn difference(&self, grid: Grid, motion: Motion, moved: &Answer<'_>) -> Option<f32> {
        let mut difference = 0.0_f32;
        for (&cell, logit) in self.graph.topology.cells().iter().zip(&self.logits) {
            let node = moved.graph.topology.cells().binary_search(&motion.cell(grid, cell)).ok()?;
            difference = difference.max((logit - moved.logits[node]).abs());
        }
        Some(difference)
    }

    /// The logits move with their cells, and differ from those of a wrong motion.
    fn check(&self, scene: &Scene, motion: Motion, moved: &Answer<'_>) {
        let grid = scene.terrain.grid();
        let right = self.difference(grid, motion, moved).unwrap();
        assert!(right < TOLERANCE, "{}, {motion:?}: {right}", scene.name);
        let wrong = self.difference(grid, motion.mistaken(), moved);
        let is_told_apart = wrong.is_none_or(|wrong| wrong > 1000.0 * TOLERANCE);
        assert!(is_told_apart || self.logits.len() == 1, "{}, {motion:?}: {wrong:?}", scene.name);
    }
}

/// All of these networks, which take the same graphs, on a scene and on its graph under each motion.
fn check_all(networks: &[Network], scene: &Scene, moved: impl Fn(&Graph, Motion) -> Graph) {
    let graph = scene.graph_of(networks[0].shape());
    let moved: Vec<_> = Motion::of_a_square().map(|motion| (motion, moved(&graph, motion))).collect();
    for network in networks {
        let answer = Answer::of(network, &graph);
        for (motion, moved) in &moved {
            answer.check(scene, *motion, &Answer::of(network, moved));
        }
    }
}

#[test]
fn a_graph_is_independent_of_position_and_direction() {
    for seed in SEEDS {
        let networks = SHAPES.map(|shape| Network::new(&weights(shape, seed)));
        for scene in scenes(seed) {
            check_all(&networks, &scene, |graph, motion| carried(graph, &scene, motion));
        }
    }
}

#[test]
fn without_routes_a_turned_map_gives_turned_logits() {
    for seed in SEEDS {
        let networks = [Network::new(&weights(PATHLESS, seed))];
        for scene in scenes(seed) {
            check_all(&networks, &scene, |_, motion| scene.moved(motion).graph());
            let networks = [Network::new(&weights(PATHLESS_LEVELS, seed))];
            check_all(&networks, &scene, |_, motion| scene.moved(motion).graph_of(PATHLESS_LEVELS));
        }
    }
}

/// Of equally short paths the robot takes the one by the smaller cell index, which depends on direction, and paths are
/// part of the network's input. So the paths of a turned map are the turned paths only where the shortest path to each
/// cell is unique.
#[test]
fn with_routes_it_does_where_shortest_paths_are_unique() {
    for seed in SEEDS {
        let networks = SHAPES.map(|shape| Network::new(&weights(shape, seed)));
        let mut random = stream(seed, Purpose::Map, 0);
        for connectivity in [Connectivity::Four, Connectivity::Eight] {
            let scene = maze(6, 6, connectivity, &mut random);
            assert_is_tree(&scene);
            check_all(&networks, &scene, |_, motion| scene.moved(motion).graph());
            let networks = [Network::new(&weights(LEVELS, seed))];
            check_all(&networks, &scene, |_, motion| scene.moved(motion).graph_of(LEVELS));
        }
    }
}

/// One edge fewer than cells, counted from both ends; paths are long and branch.
fn assert_is_tree(scene: &Scene) {
    let routes = scene.routes();
    let paths = |&cell: &_| scene.connectivity.neighbors(&scene.terrain, cell).count();
    let count = routes.reached().len();
    assert_eq!(routes.reached().iter().map(paths).sum::<usize>(), 2 * (count - 1));
    assert!(routes.reached().iter().any(|cell| paths(cell) > 2));
    let longest = routes.reached().iter().map(|&cell| routes.length(cell)).fold(0.0, f32::max);
    assert!(longest > 15.0, "{longest}");
}

/// Why the test above uses mazes.
#[test]
fn where_paths_are_equally_short_direction_decides() {
    let scene = open(9, Connectivity::Four, &mut stream(1, Purpose::Map, 0));
    let network = Network::new(&weights(SHAPES[0], 1));
    let graph = scene.graph();
    let answer = Answer::of(&network, &graph);
    let difference = |motion: Motion| {
        let moved = scene.moved(motion).graph();
        answer.difference(scene.terrain.grid(), motion, &Answer::of(&network, &moved)).unwrap()
    };
    let differences: Vec<f32> = Motion::of_a_square().map(difference).collect();
    assert!(differences[0] < f32::MIN_POSITIVE);
    assert!(differences.iter().any(|&difference| difference > 1000.0 * TOLERANCE), "{differences:?}");
}

#[test]
fn a_map_that_is_moved_gives_the_same_logits_bit_for_bit() {
    let margins = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 7, 0), (0, 0, 0, 7), (6, 1, 2, 9)];
    for seed in SEEDS {
        let shapes = SHAPES.into_iter().chain([LEVELS]);
        let networks: Vec<Network> = shapes.map(|shape| Network::new(&weights(shape, seed))).collect();
        for scene in scenes(seed) {
            for (south, west, north, east) in margins {
                let motion = Motion { margin: Margin { south, west, north, east }, ..Motion::default() };
                for network in &networks {
                    let (graph, moved) =
                        (scene.graph_of(network.shape()), scene.moved(motion).graph_of(network.shape()));
                    let (before, after) = (Answer::of(network, &graph), Answer::of(network, &moved));
                    assert_eq!(before.logits, after.logits, "{}, {motion:?}", scene.name);
                    before.check(&scene, motion, &after);
                }
            }
        }
    }
}
