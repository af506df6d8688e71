//! A network's own searches in simulation, to learn from.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::mpsc;

use dragnet_agent::agent::Agent;
use dragnet_learn::network::Network;
use dragnet_learn::reinforcement::{Explorer, Visit};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, ParticipantError};
use dragnet_scenario::Scenario;

use crate::episode::{self, Observer};
use crate::simulation::End;

/// Runs a scenario of one robot until it rests or its budget is spent, with choices that are drawn from a network at
/// this temperature. It is not over when all is found: the robot does not know that, and the visits' costs are by what
/// it believes.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn explore(
    scenario: &Scenario,
    seed: u64,
    network: &Arc<Network>,
    temperature: f64,
) -> Result<Vec<Visit>, ParticipantError> {
    let (sink, visits) = mpsc::channel();
    let mut robots = episode::team(scenario, seed, |config| {
        let explorer = Explorer::new(Arc::clone(network), temperature, sink.clone());
        Agent::with_policy(config, Box::new(explorer))
    });
    let mut visited = Visited { visits, so_far: Vec::new() };
    episode::watch(scenario, seed, End::Resting, &mut robots, &mut visited)?;
    Ok(visited.so_far)
}

/// Below this probability that anything is left a search is over: what follows costs next to nothing.
const UNFINISHED: f64 = 0.02;

/// What the robot tells, until next to nothing is left.
struct Visited {
    visits: mpsc::Receiver<Visit>,
    so_far: Vec<Visit>,
}

impl Observer for Visited {
    fn reacts(&mut self, _: &Effects<Message>) -> ControlFlow<()> {
        self.so_far.extend(self.visits.try_iter());
        match self.so_far.last() {
            Some(last) if last.to_go.unfinished < UNFINISHED => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}
