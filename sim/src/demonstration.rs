//! Recording of an expert in simulation.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::mpsc::{self, Sender};

use dragnet_agent::agent::Agent;
use dragnet_learn::demonstration::{Demonstration, Recorder, Source, Trajectory};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, ParticipantError};
use dragnet_scenario::Scenario;

use crate::episode::{self, Observer};
use crate::simulation::End;

/// Runs a scenario until all objects are found, the budget is spent or enough decisions are recorded. Every robot has
/// a recorder, made by `record`, and the decisions of all are recorded.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn watch(
    scenario: &Scenario,
    seed: u64,
    source: Source,
    scenario_digest: String,
    record: impl Fn(f64, Sender<Demonstration>) -> Recorder,
) -> Result<Trajectory, ParticipantError> {
    let (sink, taken) = mpsc::channel();
    let mut robots = episode::team(scenario, seed, |config| {
        Agent::with_policy(config, Box::new(record(source.explore, sink.clone())))
    });
    let mut enough = Enough { decisions_left: source.max_decisions };
    episode::watch(scenario, seed, End::AllFound, &mut robots, &mut enough)?;
    Ok(Trajectory {
        source,
        scenario: scenario.name().to_owned(),
        scenario_digest,
        seed,
        terrain: Arc::new(scenario.terrain().clone()),
        connectivity: scenario.connectivity(),
        sensor: Arc::clone(&scenario.robots()[0].class.sensor),
        decisions: taken.try_iter().collect(),
    })
}

/// Stops after a number of decisions.
struct Enough {
    decisions_left: u32,
}

impl Observer for Enough {
    fn reacts(&mut self, effects: &Effects<Message>) -> ControlFlow<()> {
        self.decisions_left -= u32::from(effects.decision.is_some());
        if self.decisions_left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
