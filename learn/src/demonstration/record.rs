//! A policy that records an expert.

use std::sync::mpsc::Sender;

use dragnet_search::policy::{Decision, Policy};
use dragnet_search::route::ShortestPathTree;
use dragnet_search::seed::Stream;
use dragnet_search::situation::Situation;
use rand::RngExt;

use super::Demonstration;

/// A policy that decides like an expert, and records the expert's decisions with their situations.
///
/// With `explore` above 0 the robot sometimes goes to a random cell instead, but the expert's choice is recorded: so
/// the network also learns from situations that the expert would not reach, as in DART (Laskey et al., 2017).
/// Departure: the rate of the noise is fixed, not fitted to the network's errors.
pub struct Recorder {
    expert: Box<dyn Policy + Send>,
    /// Who is followed instead of the expert, whose decisions are recorded all the same.
    followed: Option<Box<dyn Policy + Send>>,
    explore: f64,
    sink: Sender<Demonstration>,
}

impl Recorder {
    /// Records an expert. `explore` is the share of decisions that the robot does not follow, `0..=1`.
    #[must_use]
    pub fn new(expert: Box<dyn Policy + Send>, explore: f64, sink: Sender<Demonstration>) -> Self {
        Self { expert, followed: None, explore, sink }
    }

    /// Records the expert in the situations that another policy reaches, as in `DAgger` (Ross, Gordon and Bagnell, 2011).
    #[must_use]
    pub fn following(self, policy: Box<dyn Policy + Send>) -> Self {
        Self { followed: Some(policy), ..self }
    }
}

impl Policy for Recorder {
    fn decide(&mut self, situation: &Situation<'_>, random: &mut Stream) -> Decision {
        let decision = self.expert.decide(situation, random);
        // A network does not choose to rest: it rests where its expert does, by the same rule.
        if !decision.is_rest() {
            // The receiver may be closed: then the search is about to be stopped.
            let _ = self.sink.send(demonstration(situation, &decision));
        }
        let decision = match &mut self.followed {
            Some(policy) => policy.decide(situation, random),
            None => decision,
        };
        // Drawn always, so that the robot's other random choices do not depend on the rate.
        let (strays, place) = (random.random::<f64>() < self.explore, random.random::<f64>());
        if !strays || decision.is_rest() {
            return decision;
        }
        let routes = ShortestPathTree::from(situation.terrain, situation.connectivity, situation.robot);
        let candidates = routes.candidates();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the number of candidates"
        )]
        let place = (place * candidates.len() as f64) as usize;
        match candidates.get(place) {
            Some(&chosen) => Decision { chosen, path: routes.path(chosen), ..decision },
            None => decision,
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "kept as f32")]
fn demonstration(situation: &Situation<'_>, decision: &Decision) -> Demonstration {
    let cells = situation.terrain.grid().cells();
    Demonstration {
        log_odds_nats: cells.map(|cell| situation.belief.log_odds_nats(cell) as f32).collect(),
        planned_precision: situation.planned_precision.clone(),
        robot: situation.robot,
        chosen: decision.chosen,
        scores: decision.scores.iter().map(|&score| score as f32).collect(),
    }
}
