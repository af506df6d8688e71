//! A team by the wall clock: all participants run as in the field, in a simulated world.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_coordinator::node::CoordinatorNode;
use dragnet_export::cot::{self, Source};
use dragnet_proto::convert::Codec;
use dragnet_proto::state_machine::StateMachine;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::{Places, Scenario};
use dragnet_sim::simulation::StepObserver;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

use super::children::{Brief, Children};
use super::{Mesh, Options, Run, RunObserver, joined, mission, recording, target};
use crate::RuntimeError;
use crate::clock::Clock;
use crate::config::TimeSource;
use crate::link::Link;
use crate::stop::{self, Bond};
use crate::tak::{self, Feed};
use crate::wall_clock::{self, Log};
use crate::world::{self, WorldServer};

pub(super) async fn run(
    scenario: &Scenario,
    seed: u64,
    real_time_factor: f64,
    options: &Options,
    observer: RunObserver,
    spectator: StepObserver<'_>,
) -> Result<Run, RuntimeError> {
    let mission = mission(scenario)?;
    let codec = Codec::of(scenario);
    let RunObserver { listener, commands, messages } = observer;
    let commands = commands.unwrap_or_else(|| mpsc::channel(1).1);
    // Before there is a recording: whoever stops the run from now on gets one that is finished.
    let asked = stop::asked(Bond::Output)?;
    let feed = |target| {
        let (name, source) = (&mission.to_string(), Source::Simulation);
        tak::feed(target, &cot::Mission { name, scenario, source, real_time_factor })
    };
    let (feed, told) = target(options)?.map(feed).transpose()?.unzip();
    let node = recording::node(scenario, seed, options, recording::Existing::Rejected, messages)?;
    let node = node.with_listener(listener).with_listener(told);
    let mesh = Mesh::new(scenario)?;
    let world = mesh.open_world().await?;
    let (stop, stopped) = watch::channel(());
    let (stop_node, node_stopped) = watch::channel(());
    let clock = Clock::new(real_time_factor);
    let session = mesh.open_participant(Participant::Coordinator).await?;
    let link = Link::join(session, mission.clone(), Participant::Coordinator, codec.clone()).await?;
    let mut node: JoinHandle<Result<Finished, RuntimeError>> =
        participate(link, node, scenario.places(), real_time_factor, commands, node_stopped);
    let sending = feed.map(Feed::start);
    let mut children = Children::default();
    let mut robots = Vec::new();
    let search = async {
        for agent_config in AgentConfig::of_team(scenario, seed) {
            let robot = agent_config.robot.id;
            let participant = Participant::Robot(robot);
            if let Some(program) = &options.processes {
                let time = TimeSource::Wall;
                let brief = Brief { program, scenario, seed, mission: &mission, time, real_time_factor };
                children.start(&brief, robot, mesh.participant(participant))?;
            } else {
                let session = mesh.open_participant(participant).await?;
                let link = Link::join(session, mission.clone(), participant, codec.clone()).await?;
                let reports = world::sensor(&link, robot, codec.clone()).await?;
                robots.push(participate(
                    link,
                    Agent::new(agent_config),
                    scenario.places(),
                    real_time_factor,
                    reports,
                    stopped.clone(),
                ));
            }
        }
        let mission = mission.clone();
        WorldServer::open(world, mission, scenario, seed, real_time_factor, false, spectator)
            .await?
            .run()
            .await
    };
    let (mut ended, over) = ended(search, asked, &mut node).await?;
    // It ends first: robots that leave after the search are not lost.
    drop(stop_node);
    let (node, is_ended_by_operator) = match over {
        Some((node, _)) => (node, true),
        None => (joined(node).await?.0, false),
    };
    if let Some(sending) = sending {
        sending.finish().await;
    }
    drop(stop);
    let mut decisions = Vec::new();
    for robot in robots {
        match joined(robot).await {
            Ok((_, log)) => decisions.extend(log.decisions),
            Err(error) => ended = Some(Err(error)),
        }
    }
    let observations_merged = node.observations();
    let recording = options.recording.clone();
    match ended {
        Some(Ok(mut episode)) => {
            episode.outcome.decisions.extend(decisions);
            let unrecorded =
                node.finish(episode.outcome.ended, recording::summary(&episode)).err().map(Into::into);
            Ok(Run { episode, observations_merged, recording, unrecorded })
        }
        Some(Err(error)) => {
            node.finish(clock.now(), BTreeMap::from([("failed".to_owned(), error.to_string())]))?;
            Err(error)
        }
        None => {
            let why = ("stopped".to_owned(), "before the search was over".to_owned());
            node.finish(clock.now(), BTreeMap::from([why]))?;
            Err(stopped_by(is_ended_by_operator, recording))
        }
    }
}

/// Why a search was not over: its operator has ended the mission, or the user the program.
fn stopped_by(is_operator: bool, recording: Option<PathBuf>) -> RuntimeError {
    if is_operator { RuntimeError::Ended { recording } } else { RuntimeError::Stopped { recording } }
}

/// A coordinator that has ended, with the measurements of its run.
type Finished = (CoordinatorNode, Log);

/// What the search ends with, `None` if it is stopped before, and the coordinator, if that has ended before: its operator has
/// ended the mission. However it ends, the coordinator's recording is to be finished.
async fn ended<E>(
    search: impl Future<Output = E>,
    asked: impl Future<Output = ()>,
    node: &mut JoinHandle<Result<Finished, RuntimeError>>,
) -> Result<(Option<E>, Option<Finished>), RuntimeError> {
    tokio::pin!(search, asked);
    let (node, log) = tokio::select! {
        ended = &mut search => return Ok((Some(ended), None)),
        () = &mut asked => return Ok((None, None)),
        finished = joined(node) => finished?,
    };
    let ended = if node.mission().awaited().is_some_and(|awaited| !awaited.is_empty()) {
        None
    } else {
        // All robots are back: the search is over too.
        tokio::select! { ended = search => Some(ended), () = asked => None }
    };
    Ok((ended, Some((node, log))))
}

/// Runs a participant until the mission stops; returns its final state.
fn participate<M: StateMachine + 'static>(
    mut link: Link,
    mut machine: M,
    places: Places,
    real_time_factor: f64,
    reports: mpsc::Receiver<wall_clock::Report>,
    mut stopped: watch::Receiver<()>,
) -> JoinHandle<Result<(M, Log), RuntimeError>> {
    tokio::spawn(async move {
        link.announce().await?;
        let stop = async move { while stopped.changed().await.is_ok() {} };
        let log = wall_clock::run(
            &mut link,
            &mut machine,
            places,
            Clock::new(real_time_factor),
            None,
            reports,
            stop,
        )
        .await?;
        Ok((machine, log))
    })
}
