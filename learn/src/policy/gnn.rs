//! A network as a policy.

use std::sync::Arc;

use dragnet_search::cell::Cell;
use dragnet_search::policy::{self, Decision, Parameters, Policy};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;

use crate::graph::{Graph, Memory};
use crate::network::{Network, Workspace};

/// Decisions that are remembered, to tell when the robot goes round in a circle.
const REMEMBERED: usize = 12;
/// The robot goes round in a circle if it decides where it has decided, and what is hidden is still this share of what it
/// was then.
const CIRCLING_SHARE: f32 = 0.995;
/// Then `path` decides until what is hidden has fallen to this share.
const ESCAPED_SHARE: f32 = 0.9;
/// That `path` keeps to what is near.
const ESCAPE: Parameters = Parameters { path_length_weight: 1.0, ..Parameters::DEFAULT };

/// Chooses the cell with the highest logit, the most probable choice of the expert, among the cells with an informative
/// path; rests if there is none, like its expert.
///
/// A network that chooses among near cells, as one that imitates `tour`, has no plan that it would keep. Where two ways
/// are about equally good it may drive to and fro between them; that is noticed, and `path` decides for a while.
pub struct Gnn {
    network: Arc<Network>,
    /// What serves the next decision too.
    memory: Memory,
    workspace: Workspace,
    circle: Circle,
}

impl Gnn {
    /// A policy that decides with a network.
    #[must_use]
    pub fn new(network: Arc<Network>) -> Self {
        Self {
            network,
            memory: Memory::default(),
            workspace: Workspace::default(),
            circle: Circle::default(),
        }
    }
}

/// What a network says in a situation.
pub(crate) struct Opinion {
    pub(crate) graph: Graph,
    /// To the candidates.
    pub(crate) routes: ShortestPathTree,
    /// The logit of each cell that may be chosen, shape `[cells]`; `-inf` for others.
    pub(crate) scores: Vec<f64>,
}

impl Gnn {
    /// What the network says; `None` if the robot goes round in a circle, and [`escape`] decides.
    pub(crate) fn opinion(&mut self, situation: &Situation<'_>) -> Option<Opinion> {
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let graph = Graph::of_shape(self.network.shape(), situation, &routes, &mut self.memory);
        let is_near_only = self.network.within_cells() < f32::INFINITY;
        if is_near_only && self.circle.is_entered(situation.robot, self.memory.hidden_total()) {
            return None;
        }
        let routes = situation.with_way_home(routes);
        let logits = self.network.logits_in(&graph, &mut self.workspace);
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for (&cell, &logit) in graph.topology.cells().iter().zip(logits) {
            if cell != situation.robot && routes.length(cell) < self.network.within_cells() {
                scores[cell.index()] = f64::from(logit);
            }
        }
        Some(Opinion { graph, routes, scores })
    }
}

impl Opinion {
    /// What the last layers had of a cell; `gnn` has not been asked since.
    pub(crate) fn head_inputs<'a>(&'a self, gnn: &'a Gnn, cell: Cell) -> impl Iterator<Item = f32> + 'a {
        let node = self.graph.topology.node(cell) as usize;
        gnn.network.head_inputs(&self.graph, &gnn.workspace, node)
    }
}

/// The decision of a robot that goes round in a circle.
pub(crate) fn escape(situation: &Situation<'_>, random: &mut Stream) -> Decision {
    policy::build(policy::PolicyName::Path, ESCAPE).decide(situation, random)
}

impl Policy for Gnn {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        match self.opinion(situation) {
            Some(Opinion { routes, scores, .. }) => Decision::best_of_informative(situation, &routes, scores),
            None => escape(situation, random),
        }
    }
}

/// Where the robot has decided lately, and what was hidden then.
#[derive(Clone, Debug, Default)]
struct Circle {
    recent: Vec<(Cell, f32)>,
    /// What has to be left for the circle to count as left.
    escaped_at: Option<f32>,
}

impl Circle {
    /// Whether the robot goes round in a circle when it decides here, with this much hidden.
    fn is_entered(&mut self, robot: Cell, hidden: f32) -> bool {
        if let Some(escaped_at) = self.escaped_at {
            if hidden > escaped_at {
                return true;
            }
            *self = Self::default();
        }
        let was_here = |&(cell, before): &(Cell, f32)| cell == robot && hidden > CIRCLING_SHARE * before;
        let is_entered = self.recent.iter().any(was_here);
        if is_entered {
            self.escaped_at = Some(ESCAPED_SHARE * hidden);
        }
        if self.recent.len() == REMEMBERED {
            self.recent.remove(0);
        }
        self.recent.push((robot, hidden));
        is_entered
    }
}

#[cfg(test)]
mod tests {
    use dragnet_search::cell::Grid;

    use super::*;

    #[test]
    fn a_circle_is_entered_where_nothing_has_changed_and_left_once_a_tenth_is_found() {
        let cells: Vec<Cell> = Grid::new(1, 4).unwrap().cells().collect();
        let mut circle = Circle::default();
        assert!(!circle.is_entered(cells[0], 8.0));
        assert!(!circle.is_entered(cells[1], 7.9));
        assert!(!circle.is_entered(cells[0], 7.0), "there again, but much was found");
        assert!(!circle.is_entered(cells[2], 6.99));
        assert!(circle.is_entered(cells[0], 6.98), "there again for nothing");
        assert!(circle.is_entered(cells[3], 6.5), "wherever the robot is");
        assert!(!circle.is_entered(cells[3], 6.2), "a tenth is found");
    }

    #[test]
    fn what_was_long_ago_is_forgotten() {
        let cells: Vec<Cell> = Grid::new(1, 20).unwrap().cells().collect();
        let mut circle = Circle::default();
        assert!(cells[..=REMEMBERED].iter().all(|&cell| !circle.is_entered(cell, 1.0)));
        assert!(!circle.is_entered(cells[0], 1.0));
        assert!(circle.is_entered(cells[2], 1.0));
    }
}
