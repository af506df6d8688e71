//! A network that tries other choices than its best.

use std::sync::Arc;
use std::sync::mpsc::Sender;

use dragnet_search::policy::{CostToGo, Decision, Policy, TourCost};
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;
use rand::RngExt;

use crate::graph::Graph;
use crate::network::Network;
use crate::policy::{Gnn, Opinion, escape};

/// One decision of a search.
#[derive(Clone, Debug)]
pub struct Visit {
    /// What was to come before it, by the belief.
    pub to_go: CostToGo,
    /// The way that was chosen, cells.
    pub length_cells: f64,
    /// The network's choice; `None` where it did not choose: the robot rested, went round in a circle, or had nothing to
    /// look at nearby.
    pub choice: Option<Choice>,
}

/// A choice that was drawn.
#[derive(Clone, Debug)]
pub struct Choice {
    /// What the network saw.
    pub graph: Graph,
    /// The chosen node.
    pub chosen: u32,
    /// Whether the network may choose a node, shape `[nodes]`.
    pub is_candidate: Vec<bool>,
    /// `ln pi(chosen)`.
    pub log_probability: f64,
}

/// Searches like [`Gnn`], except that a cell is drawn with probability `softmax(logit / temperature)`, and tells of each
/// decision.
pub struct Explorer {
    gnn: Gnn,
    critic: TourCost,
    temperature: f64,
    sink: Sender<Visit>,
}

impl Explorer {
    /// A policy that draws from a network's choices, at a temperature above 0.
    #[must_use]
    pub fn new(network: Arc<Network>, temperature: f64, sink: Sender<Visit>) -> Self {
        Self { gnn: Gnn::new(network), critic: TourCost::default(), temperature, sink }
    }
}

impl Policy for Explorer {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let to_go = self.critic.to_go(situation, random);
        let (decision, choice) = match self.gnn.opinion(situation) {
            Some(opinion) => drawn(opinion, self.temperature, situation, random),
            None => (escape(situation, random), None),
        };
        let length_cells = length_cells(situation, &decision);
        // The receiver may be closed: then the search is about to be stopped.
        let _ = self.sink.send(Visit { to_go, length_cells, choice });
        decision
    }
}

/// The best cell by logits to which noise of Gumbel's distribution is added: that of a draw by their softmax. Cells
/// whose path tells nothing are passed over as always; then the draw is from the rest, whatever its noted probability.
fn drawn(
    opinion: Opinion,
    temperature: f64,
    situation: &Situation<'_>,
    random: &mut Stream,
) -> (Decision, Option<Choice>) {
    let Opinion { graph, routes, scores } = opinion;
    let log_policy = log_softmax(scores.iter().map(|score| score / temperature).collect());
    let mut gumbel = || -(-(random.random::<f64>().max(f64::MIN_POSITIVE)).ln()).ln();
    let noisy = log_policy.iter().map(|&it| if it.is_finite() { it + gumbel() } else { it }).collect();
    let decision = Decision::best_of_informative(situation, &routes, noisy);
    let log_probability = log_policy[decision.chosen.index()];
    let choice = (!decision.is_rest() && log_probability.is_finite()).then(|| Choice {
        chosen: graph.topology.node(decision.chosen),
        is_candidate: graph.topology.cells().iter().map(|it| log_policy[it.index()].is_finite()).collect(),
        log_probability,
        graph,
    });
    (decision, choice)
}

/// `ln softmax`; `-inf` stays what it is.
fn log_softmax(mut logits: Vec<f64>) -> Vec<f64> {
    let most = logits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return logits;
    }
    let sum: f64 = logits.iter().map(|logit| (logit - most).exp()).sum();
    for logit in &mut logits {
        *logit -= most + sum.ln();
    }
    logits
}

/// Length of a decision's path.
fn length_cells(situation: &Situation<'_>, decision: &Decision) -> f64 {
    let grid = situation.terrain.grid();
    let from = std::iter::once(&situation.robot).chain(&decision.path);
    from.zip(&decision.path).map(|(&from, &to)| grid.offset(from, to).euclidean()).sum()
}
