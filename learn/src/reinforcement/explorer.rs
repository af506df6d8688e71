//! A network that tries other choices than its best.

use std::sync::Arc;
use std::sync::mpsc::Sender;

use dragnet_search::cell::Cell;
use dragnet_search::policy::{CostToGo, Decision, Policy, TourCost};
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;
use rand::RngExt;

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
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// What the last layers had of each cell that the network could choose, shape `[candidates, Shape::head_inputs]`.
    pub inputs: Vec<f32>,
    /// Which of them it was.
    pub chosen: usize,
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
            Some(opinion) => self.drawn(&opinion, situation, random),
            None => (escape(situation, random), None),
        };
        let length_cells = length_cells(situation, &decision);
        // The receiver may be closed: then the search is about to be stopped.
        let _ = self.sink.send(Visit { to_go, length_cells, choice });
        decision
    }
}

impl Explorer {
    /// The best cell by logits to which noise of Gumbel's distribution is added: that of a draw by their softmax. Cells
    /// whose path tells nothing are passed over as always; then the draw is from the rest, whatever its noted probability.
    fn drawn(
        &self,
        opinion: &Opinion,
        situation: &Situation<'_>,
        random: &mut Stream,
    ) -> (Decision, Option<Choice>) {
        let log_policy = log_softmax(opinion.scores.iter().map(|score| score / self.temperature).collect());
        let mut gumbel = || -(-(random.random::<f64>().max(f64::MIN_POSITIVE)).ln()).ln();
        let noisy = log_policy.iter().map(|&it| if it.is_finite() { it + gumbel() } else { it }).collect();
        let decision = Decision::best_of_informative(situation, &opinion.routes, noisy);
        let cells = situation.terrain.grid().cells();
        let candidates: Vec<Cell> = cells.filter(|cell| log_policy[cell.index()].is_finite()).collect();
        let chosen = candidates.iter().position(|&cell| cell == decision.chosen && !decision.is_rest());
        let choice = chosen.map(|chosen| Choice {
            inputs: candidates.iter().flat_map(|&cell| opinion.head_inputs(&self.gnn, cell)).collect(),
            chosen,
            log_probability: log_policy[decision.chosen.index()],
        });
        (decision, choice)
    }
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

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use dragnet_search::belief::Belief;
    use dragnet_search::intent::PlannedPrecision;
    use dragnet_search::seed::{Purpose, stream};
    use dragnet_search::sensor::{Noise, Sensor};
    use dragnet_search::terrain::Terrain;

    use super::*;
    use crate::policy::Shipped;

    fn in_a_corner<T>(look: impl Fn(&Situation<'_>) -> T) -> T {
        let terrain = Terrain::from_ascii(".....\n.#.#.\n.....\n", 30.0).unwrap();
        let belief = Belief::from_log_odds(&terrain, vec![-2.0; 15]).unwrap();
        let sensor = Sensor::new(2, 0.05, Noise::Gaussian).unwrap();
        let nothing = PlannedPrecision::nothing(&terrain);
        let corner = terrain.grid().cells().next().unwrap();
        look(&Situation::alone(&terrain, &sensor, &belief, &nothing, corner))
    }

    const DRAWS: usize = 2000;

    /// How often each cell of a small map is chosen, with the noted probability; and the best.
    fn chosen(temperature: f64) -> (Vec<(f64, f64)>, Cell) {
        in_a_corner(|situation| {
            let mut random = stream(3, Purpose::Decision, 1);
            let network = Shipped::Tour.network();
            let mut explorer = Explorer::new(Arc::clone(&network), temperature, mpsc::channel().0);
            let opinion = explorer.gnn.opinion(situation).unwrap();
            let mut chosen = vec![(0.0, 0.0); 15];
            for _ in 0..DRAWS {
                let (decision, choice) = explorer.drawn(&opinion, situation, &mut random);
                let choice = choice.unwrap();
                let candidates = choice.inputs.len() / network.shape().head_inputs();
                assert!(choice.chosen < candidates && candidates < 12, "{candidates}");
                let of_cell = &mut chosen[decision.chosen.index()];
                *of_cell = (of_cell.0 + 1.0 / DRAWS as f64, choice.log_probability.exp());
            }
            (chosen, Gnn::new(network).decide(situation, &mut random).chosen)
        })
    }

    #[test]
    fn a_cell_is_drawn_as_often_as_its_probability_says() {
        let (chosen, _) = chosen(2.0);
        assert!(chosen.iter().filter(|(share, _)| *share > 0.02).count() > 3, "{chosen:?}");
        for (share, probability) in chosen {
            assert!((share - probability).abs() < 0.05, "{share} of {probability}");
        }
    }

    #[test]
    fn at_a_low_temperature_it_is_the_best() {
        let (chosen, best) = chosen(1e-4);
        assert!(chosen[best.index()].0 > 0.999, "{chosen:?}");
    }

    #[test]
    fn each_decision_is_told_with_its_way_and_what_is_to_come() {
        in_a_corner(|situation| {
            let (sink, visits) = mpsc::channel();
            let mut explorer = Explorer::new(Shipped::Tour.network(), 1.0, sink);
            let decision = explorer.decide(situation, &mut stream(3, Purpose::Decision, 1));
            let visit = visits.try_recv().unwrap();
            assert!((visit.length_cells - decision.path.len() as f64).abs() < 1e-9);
            assert!(visit.to_go.unfinished > 0.5 && visit.to_go.expected_cells > 1.0, "{visit:?}");
            assert!(visit.choice.is_some());
        });
    }

    #[test]
    fn without_candidates_there_is_no_probability() {
        let none = log_softmax(vec![f64::NEG_INFINITY; 3]);
        assert!(none.iter().all(|it| *it == f64::NEG_INFINITY));
        let two = log_softmax(vec![1000.0, f64::NEG_INFINITY, 1000.0]);
        assert!((two[0].exp() - 0.5).abs() < 1e-12 && two[1] == f64::NEG_INFINITY);
    }
}
