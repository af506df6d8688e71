//! The network's input: the map as a graph, with features of each cell.
//!
//! A node is a traversable cell that the robot can reach; edges join cells that touch, corners included. The graph does
//! not contain a node's position on the map or the direction of north, only neighbors, paths and features. So a map
//! that is moved, turned or mirrored gives the same graph with its nodes in another order.

mod features;
mod levels;
mod topology;

use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_search::policy::HiddenMass;
use dragnet_search::route::ShortestPathTree;
use dragnet_search::situation::Situation;
use dragnet_search::utility_gain::UtilityGain;

use crate::shape::Shape;

pub(crate) use features::feature_names;
pub use features::{FEATURE_NAMES, FEATURES, PLANNING_FEATURES};
pub use levels::{COARSE_NEIGHBORS, Level};
pub use topology::{Edge, Edges, NEIGHBORS, Topology};

/// One situation as a graph. Nodes are numbered in order of the indices of their cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Nodes and edges, which stay the same while a robot searches one map.
    pub topology: Arc<Topology>,
    /// Features of each node, shape `[nodes, features]`; see [`FEATURE_NAMES`].
    pub features: Vec<f32>,
    /// The node of the robot's own cell.
    pub root: u32,
    /// The node before each on the shortest path from the robot to it, shape `[nodes]`; of the root itself.
    pub parent: Vec<u32>,
    /// All nodes, parents before children, the root first: shape `[nodes]`.
    pub order: Vec<u32>,
    /// Coarser graphs, the finest first; none for networks without.
    pub levels: Vec<Level>,
}

/// What is kept from one graph to the next.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    topology: Option<Arc<Topology>>,
    hidden: HiddenMass,
    hidden_total: f32,
}

impl Memory {
    /// The sum of what all cells hid in the last situation, as `tour` counts it; 0 for networks without levels.
    #[must_use]
    pub const fn hidden_total(&self) -> f32 {
        self.hidden_total
    }
}

impl Graph {
    /// The graph of a situation. `topology` is kept between calls, and rebuilt when the map has changed.
    #[must_use]
    pub fn new(
        situation: &Situation<'_>,
        routes: &ShortestPathTree,
        topology: &mut Option<Arc<Topology>>,
    ) -> Self {
        let topology = match topology {
            Some(known) if known.is_of(situation.terrain, routes) => Arc::clone(known),
            other => Arc::clone(other.insert(Arc::new(Topology::new(situation.terrain, routes)))),
        };
        let gains = UtilityGain::information(situation).observation_gains(situation, routes);
        let node = |cell: Cell| topology.node(cell);
        let mut parent = vec![0; topology.len()];
        for &cell in routes.reached() {
            parent[node(cell) as usize] = node(routes.parent(cell));
        }
        Self {
            features: features::of(situation, routes, &topology, &gains),
            root: node(routes.root()),
            parent,
            order: routes.reached().iter().map(|&cell| node(cell)).collect(),
            topology,
            levels: Vec::new(),
        }
    }

    /// The graph that a network of this shape takes.
    #[must_use]
    pub fn of_shape(
        shape: Shape,
        situation: &Situation<'_>,
        routes: &ShortestPathTree,
        memory: &mut Memory,
    ) -> Self {
        let mut graph = Self::new(situation, routes, &mut memory.topology);
        if shape.levels > 0 {
            let (topology, grid) = (&graph.topology, situation.terrain.grid());
            let hidden = memory.hidden.of(situation);
            memory.hidden_total = hidden.mass.iter().sum();
            graph.levels = levels::levels(topology, grid, situation.robot, shape.levels);
            graph.features = features::with_planning(&graph.features, situation, routes, topology, &hidden);
        }
        graph
    }
}
