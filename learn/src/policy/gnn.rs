//! A network as a policy.

use std::sync::Arc;

use dragnet_search::policy::{Decision, Policy};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;

use crate::graph::{Graph, Topology};
use crate::network::{Network, Workspace};

/// Chooses the cell with the highest logit, the most probable choice of the expert, among the cells with an informative
/// path; rests if there is none, like its expert.
#[derive(Clone, Debug)]
pub struct Gnn {
    network: Arc<Network>,
    /// The topology of the last decision.
    topology: Option<Arc<Topology>>,
    workspace: Workspace,
}

impl Gnn {
    /// A policy that decides with a network.
    #[must_use]
    pub fn new(network: Arc<Network>) -> Self {
        Self { network, topology: None, workspace: Workspace::default() }
    }
}

impl Policy for Gnn {
    fn decide(&mut self, situation: &Situation<'_>, _: &mut Stream) -> Decision {
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let graph = Graph::new(situation, &routes, &mut self.topology);
        let logits = self.network.logits_in(&graph, &mut self.workspace);
        let mut scores = vec![f64::NEG_INFINITY; situation.terrain.grid().cell_count()];
        for (&cell, &logit) in graph.topology.cells().iter().zip(logits) {
            if cell != situation.robot {
                scores[cell.index()] = f64::from(logit);
            }
        }
        Decision::best_of_informative(situation, &routes, scores)
    }
}
