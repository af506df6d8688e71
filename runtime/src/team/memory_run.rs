//! A team in simulated time in the memory of this process: the simulator calls every participant, and nothing is sent.

use std::num::NonZeroUsize;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::state_machine::StateMachine;
use dragnet_scenario::Scenario;
use dragnet_sim::episode;
use dragnet_sim::participants::SharedParticipants;
use dragnet_sim::simulation::{End, Membership, Rules, StepObserver};

use super::{Options, Run, recording};
use crate::RuntimeError;

pub(super) fn run(
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    spectator: StepObserver<'_>,
) -> Result<Run, RuntimeError> {
    let mut node = recording::node(scenario, seed, options, recording::Existing::Rejected, None)?;
    let mut robots: Vec<Agent> = AgentConfig::of_team(scenario, seed).into_iter().map(Agent::new).collect();
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = if options.threads == 0 { cores } else { options.threads };
    let mut participants = SharedParticipants::new(&mut robots, Some(&mut node), threads);
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let episode = episode::run_with(scenario, seed, rules, &mut participants, spectator)?;
    let observations_merged = node.observations();
    let unrecorded = node.finish(episode.outcome.ended, recording::summary(&episode)).err().map(Into::into);
    Ok(Run { episode, observations_merged, recording: options.recording.clone(), unrecorded })
}
