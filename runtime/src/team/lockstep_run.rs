//! A team in simulated time: the simulator drives every participant, event by event.

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_proto::convert::Codec;
use dragnet_proto::key::Mission;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_sim::episode;
use dragnet_sim::simulation::{End, Membership, Rules, StepObserver};
use tokio::runtime::Runtime;
use zenoh::Session;

use super::children::{Brief, Children};
use super::{Mesh, Options, Run, everybody, joined, mission, recording};
use crate::RuntimeError;
use crate::config::TimeSource;
use crate::lockstep::LockstepNode;
use crate::remote_participants::RemoteParticipants;

pub(super) fn run(
    runtime: &Runtime,
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    spectator: StepObserver<'_>,
) -> Result<Run, RuntimeError> {
    let node = recording::node(scenario, seed, options, recording::Existing::Rejected, None)?;
    let stage = Stage { mission: mission(scenario)?, codec: Codec::of(scenario), team: everybody(scenario) };
    let mesh = Mesh::new(scenario)?;
    let world = runtime.block_on(mesh.open_world())?;
    let session = runtime.block_on(mesh.open_participant(Participant::Coordinator))?;
    let node = runtime.spawn(stage.clone().coordinate(session, node));
    let mut children = Children::default();
    let mut robots = Vec::new();
    for agent_config in AgentConfig::of_team(scenario, seed) {
        let participant = Participant::Robot(agent_config.robot.id);
        if let Some(program) = &options.processes {
            let (mission, time) = (&stage.mission, TimeSource::Simulator);
            let brief = Brief { program, scenario, seed, mission, time, real_time_factor: 1.0 };
            children.start(&brief, agent_config.robot.id, mesh.participant(participant))?;
        } else {
            let session = runtime.block_on(mesh.open_participant(participant))?;
            robots.push(runtime.spawn(stage.clone().search(session, participant, agent_config)));
        }
    }
    let mut participants =
        RemoteParticipants::new(world, stage.mission, stage.codec.grid(), Box::new(move || children.check()));
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let episode = episode::run_with(scenario, seed, rules, &mut participants, spectator)?;
    let observations_merged = participants.observations(Participant::Coordinator)?;
    for &participant in &stage.team {
        participants.dismiss(participant)?;
    }
    for robot in robots {
        runtime.block_on(joined(robot))?;
    }
    let node = runtime.block_on(joined(node))?;
    let unrecorded = node.finish(episode.outcome.ended, recording::summary(&episode)).err().map(Into::into);
    Ok(Run { episode, observations_merged, recording: options.recording.clone(), unrecorded })
}

/// What all participants of a run share.
#[derive(Clone)]
struct Stage {
    mission: Mission,
    codec: Codec,
    team: Vec<Participant>,
}

impl Stage {
    async fn search(
        self,
        session: Session,
        participant: Participant,
        agent_config: AgentConfig,
    ) -> Result<(), RuntimeError> {
        let mut agent = Agent::new(agent_config);
        LockstepNode::new(session, self.mission, participant, self.codec, self.team, &mut agent)
            .await?
            .serve()
            .await
    }

    async fn coordinate(
        self,
        session: Session,
        mut node: CoordinatorNode,
    ) -> Result<CoordinatorNode, RuntimeError> {
        let participant = Participant::Coordinator;
        LockstepNode::new(session, self.mission, participant, self.codec, self.team, &mut node)
            .await?
            .serve()
            .await?;
        Ok(node)
    }
}
