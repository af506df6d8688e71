//! Each part of a mission as a separate process: `dragnet agent`, `dragnet coordinator` and `dragnet sim`.

use std::collections::{BTreeMap, BTreeSet};
use std::future::Future;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use dragnet_agent::agent::Agent;
use dragnet_coordinator::finds::FindCounts;
use dragnet_coordinator::node::{CoordinatorNode, Listener};
use dragnet_coordinator::record::encoder::MessageListener;
use dragnet_export::cot::{self, Source};
use dragnet_live::foxglove;
use dragnet_live::page::{Page, Settings};
use dragnet_live::view::About;
use dragnet_proto::convert::Codec;
use dragnet_proto::key::Mission;
use dragnet_proto::scenario_digest::ScenarioDigest;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Places, Scenario};
use dragnet_search::cell::Cell;
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::StepObserver;
use tokio::sync::{mpsc, watch};

use crate::clock::Clock;
use crate::config::{self, AgentSettings, Checked, CoordinatorSettings, OwnVehicle, SimSettings, TimeSource};
use crate::journal::{Journal, Subject};
use crate::link::Link;
use crate::lockstep::LockstepNode;
use crate::pictures::{self, Fetcher};
use crate::progress::{Expected, Mover};
use crate::session::{self, Endpoints, Mode, block_on, leaving, open_when_there};
use crate::stop::{self, Bond};
use crate::tak::{self, Feed};
use crate::team::recording::Existing;
use crate::team::{self, Options};
use crate::vehicle::{self, Embodied, detector};
use crate::wall_clock::{self, Reports};
use crate::world::{self, WorldServer};
use crate::{RuntimeError, mavlink, unix_time};

/// Which of several processes of one robot continues; the others stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precedence {
    /// The process that was started first.
    ByAge,
    /// This process.
    First,
}

/// Runs one robot until the process is asked to stop. `make` constructs the detector, if the settings have one.
///
/// # Errors
/// If the settings are invalid, or the robot fails.
pub fn agent(file: &Path, precedence: Precedence, make: detector::Make<'_>) -> Result<(), RuntimeError> {
    let mut config: AgentSettings = config::load(file)?;
    config.common.zenoh = config.common.zenoh.named_in(file);
    let Checked { mission, scenario } = config.common.check(file)?;
    let agent_config = config.agent_config(file, &scenario)?;
    let vehicle = config.vehicle(file, &scenario)?;
    let detector = match &vehicle {
        Some(OwnVehicle::Ros(body)) => body.make_detector(file, make)?,
        Some(OwnVehicle::Mavlink(_)) | None => None,
    };
    let robot = agent_config.robot.id;
    let participant = Participant::Robot(robot);
    let mut agent = Agent::new(agent_config);
    block_on(async {
        let stop = stopped(if config.attached { Bond::Input } else { Bond::None }, participant, &mission)?;
        tokio::pin!(stop);
        // Its network may be late; stopping does not wait for it.
        let session = tokio::select! {
            session = open_when_there(&config.common.zenoh) => session?,
            () = &mut stop => return Ok(()),
        };
        let searching = async {
            let (session, mission) = (session.clone(), mission.clone());
            if config.time == TimeSource::Simulator {
                let team = team::everybody(&scenario);
                let node =
                    LockstepNode::new(session, mission, participant, Codec::of(&scenario), team, &mut agent)
                        .await?;
                return tokio::select! {
                    outcome = node.serve() => outcome,
                    () = stop => Ok(()),
                };
            }
            let subject = Subject { mission: &mission, robot, terrain: scenario.terrain() };
            let (journal, clock) =
                resume(&mut agent, &config.journal(file), subject, config.common.real_time_factor)?;
            let codec = Codec::of(&scenario);
            let mut link = Link::join(session, mission, participant, codec.clone()).await?;
            link.set_scenario(ScenarioDigest::of(&scenario));
            if precedence == Precedence::First {
                link.take_over();
            }
            let Some(vehicle) = vehicle else {
                let readings = world::sensor(&link, robot, codec).await?;
                let factor = config.common.real_time_factor;
                let reports = Reports::of(readings, Expected::of(Mover::Simulator, &scenario, factor));
                enter(&mut link, &config.common.zenoh).await?;
                return wall_clock::run(
                    &mut link,
                    &mut agent,
                    scenario.places(),
                    clock,
                    Some(journal),
                    reports,
                    stop,
                )
                .await
                .map(|_| ());
            };
            enter(&mut link, &config.common.zenoh).await?;
            Own { vehicle, detector, scenario }
                .search(&mut link, agent, clock.listening(), journal, stop)
                .await
        };
        leaving(&session, Box::pin(searching)).await
    })
}

/// Joins a mission, and logs it.
async fn enter(link: &mut Link, endpoints: &Endpoints) -> Result<(), RuntimeError> {
    link.announce().await?;
    log_start(link, endpoints);
    Ok(())
}

/// A robot's own vehicle, with its requirements.
struct Own {
    vehicle: OwnVehicle,
    detector: Option<Box<dyn detector::Detector>>,
    scenario: Scenario,
}

impl Own {
    /// Searches with it until the robot is asked to stop, or the vehicle fails.
    async fn search(
        self,
        link: &mut Link,
        agent: Agent,
        clock: Clock,
        journal: Journal,
        stop: impl Future<Output = ()>,
    ) -> Result<(), RuntimeError> {
        let Self { vehicle, detector, scenario } = self;
        let places = scenario.places();
        let (mut machine, outputs) = Embodied::new(agent);
        let _pictures = match &vehicle {
            OwnVehicle::Ros(body) if body.ros.cameras_with_images().next().is_some() => {
                let pictures = Arc::clone(&outputs.shelf);
                Some(pictures::serve(link.session(), link.mission(), link.codec(), pictures).await?)
            }
            OwnVehicle::Ros(_) | OwnVehicle::Mavlink(_) => None,
        };
        let (sender, reports) = mpsc::channel(REPORTS);
        // A vehicle has its own time: the mission's may be set forward, which must not look like a silent camera.
        let time = Clock::new(1.0).at(MissionTime::START);
        let reports = Reports::of(reports, Expected::of(Mover::Vehicle, &scenario, 1.0));
        let mut vehicle = tokio::spawn(async move {
            match vehicle {
                OwnVehicle::Ros(body) => {
                    vehicle::serve::serve(*body, &scenario, time, detector, outputs, sender).await
                }
                OwnVehicle::Mavlink(body) => {
                    mavlink::serve::serve(*body, &scenario, time, outputs, sender).await
                }
            }
        });
        let mut broken = None;
        let stop = async {
            tokio::select! {
                () = stop => {}
                ended = &mut vehicle => broken = Some(ended),
            }
        };
        let searched = wall_clock::run(link, &mut machine, places, clock, Some(journal), reports, stop).await;
        // Its vehicle stops once the agent is gone; a network that is not there need not be waited for.
        drop(machine);
        let ended = match broken {
            Some(ended) => Some(ended),
            None => tokio::time::timeout(STANDSTILL, vehicle).await.ok(),
        };
        searched?;
        match ended {
            Some(Ok(ended)) => ended,
            Some(Err(error)) => {
                Err(RuntimeError::Participant { participant: link.me(), reason: error.to_string() })
            }
            None => Ok(()),
        }
    }
}

/// Maximum number of observations that wait for an agent that decides.
const REPORTS: usize = 1024;
/// Time for which the page of a mission that is over tells its viewers so.
const PARTING: Duration = Duration::from_secs(2);
/// Time limit for stopping the vehicle.
const STANDSTILL: Duration = Duration::from_secs(2);

/// A robot restores its journal; its clock continues from the stored time. The computer's date is not used: it may have
/// been set meanwhile.
fn resume(
    agent: &mut Agent,
    file: &Path,
    subject: Subject<'_>,
    real_time_factor: f64,
) -> Result<(Journal, Clock), RuntimeError> {
    let (journal, memory) = Journal::open(file, subject, unix_time::now_ns().unsigned_abs())?;
    for observation in &memory.observations {
        agent.recall(observation);
    }
    let clock = Clock::new(real_time_factor);
    let Some(now) = memory.resumed(journal.time(), &clock) else { return Ok((journal, clock)) };
    for message in &memory.instructions {
        agent.recall_instructions(now, message);
    }
    let (robot, count) = (subject.robot, memory.observations.len());
    let told = if memory.instructions.is_empty() { "" } else { " and what the operator had told it" };
    tracing::info!(
        "robot {robot} goes on with {count} observations{told}, from {}, {:.0} s into the mission",
        file.display(),
        now.as_seconds()
    );
    Ok((journal, clock.at(now)))
}

/// An additional role of the coordinator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// As configured in its settings.
    AsSet,
    /// It is the router for robots that cannot reach each other.
    Router,
}

/// Runs the coordinator until the process is asked to stop, or the operator's mission is over; then finishes the recording.
///
/// # Errors
/// If the settings are invalid, or not everything could be recorded.
pub fn coordinator(file: &Path, role: Role, version: &str) -> Result<(), RuntimeError> {
    let mut config: CoordinatorSettings = config::load(file)?;
    config.common.zenoh = config.common.zenoh.named_in(file);
    if role == Role::Router {
        config.common.zenoh.mode = Some(Mode::Router);
    }
    let Checked { mission, scenario } = config.common.check(file)?;
    let real_time_factor = config.common.real_time_factor;
    let options = Options {
        recording: config.recording.clone().or_else(|| scenario.recording().file.clone()),
        real_time_factor: Some(real_time_factor),
        version: version.to_owned(),
        medium: team::Medium::Zenoh,
        threads: 0,
        processes: None,
        tak: None,
    };
    let target = config.tak(file, &scenario)?;
    let is_field = real_time_factor.to_bits() == 1.0_f64.to_bits();
    let source = if is_field { Source::Field } else { Source::Simulation };
    let feed = |target| {
        let name = &mission.to_string();
        tak::feed(target, &cot::Mission { name, scenario: &scenario, source, real_time_factor })
    };
    let (feed, told) = target.map(feed).transpose()?.unzip();
    let shown = config.live.as_ref().map(|settings| show(settings, &scenario, file)).transpose()?;
    let (shown, listener, commands) = match shown {
        Some((server, listener, commands)) => (Some(server), Some(listener), commands),
        None => (None, None, mpsc::channel(1).1),
    };
    let (foxglove, messages) =
        config.foxglove.as_ref().map(|settings| serve_foxglove(settings, file)).transpose()?.unzip();
    let there = Existing::Beside;
    let node = team::recording::node(&scenario, config.common.seed, &options, there, messages)?;
    let (asking, wanted) = pictures::wanted();
    let mut node = node.with_listener(listener).with_listener(told).with_listener(Some(asking));
    let codec = Codec::of(&scenario);
    let clock = Clock::new(real_time_factor);
    let ended = block_on(async {
        let participant = Participant::Coordinator;
        let stop = stopped(Bond::None, participant, &mission)?;
        tokio::pin!(stop);
        // Its recording is finished, however early it is asked to stop.
        let session = tokio::select! {
            session = open_when_there(&config.common.zenoh) => session?,
            () = &mut stop => return Ok(clock.now()),
        };
        let watching = async {
            let mut link = Link::join(session.clone(), mission.clone(), participant, codec).await?;
            link.set_scenario(ScenarioDigest::of(&scenario));
            enter(&mut link, &config.common.zenoh).await?;
            if let Some(server) = &shown {
                tracing::info!("live page: {}", server.address());
            }
            if let Some(server) = &foxglove {
                tracing::info!("Foxglove: {}", server.address());
            }
            let sending = feed.map(Feed::start);
            let reports = with_pictures(&link, scenario.places(), wanted, commands);
            let log =
                wall_clock::run(&mut link, &mut node, scenario.places(), clock, None, reports, stop).await;
            if let Some(sending) = sending {
                sending.finish().await;
            }
            log.map(|log| log.ended)
        };
        leaving(&session, watching).await
    })?;
    conclude(node, ended, &mission, shown)
}

/// The operator's commands, and the pictures that robots are asked for.
fn with_pictures(
    link: &Link,
    places: Places,
    wanted: watch::Receiver<BTreeSet<Cell>>,
    mut commands: mpsc::Receiver<wall_clock::Report>,
) -> mpsc::Receiver<wall_clock::Report> {
    let (sender, reports) = mpsc::channel(REPORTS);
    tokio::spawn(Fetcher::new(link, places, wanted, sender.clone()).run());
    tokio::spawn(async move {
        while let Some(command) = commands.recv().await {
            if sender.send(command).await.is_err() {
                return;
            }
        }
    });
    reports
}

/// Finishes the recording; the page of a mission that the operator has ended still tells its viewers so.
fn conclude(
    node: CoordinatorNode,
    ended: MissionTime,
    mission: &Mission,
    shown: Option<Page>,
) -> Result<(), RuntimeError> {
    let by = node.ended();
    let finds = FindCounts::of(&node.finish(ended, BTreeMap::new())?.finds());
    if finds.has_verdicts() {
        tracing::info!("coordinator ends: {finds}");
    }
    if let Some(by) = by {
        tracing::info!("{} of mission {mission} ends: ended {by}", Participant::Coordinator);
        if let Some(page) = shown {
            page.serve_until(|| tokio::time::sleep(PARTING));
        }
    }
    Ok(())
}

/// Serves the page of a mission in the field, connected to the coordinator.
fn show(
    settings: &Settings,
    scenario: &Scenario,
    file: &Path,
) -> Result<(Page, Listener, mpsc::Receiver<wall_clock::Report>), RuntimeError> {
    Page::of_mission(settings, About::of(scenario, None))
        .map_err(|error| RuntimeError::Settings { file: file.to_owned(), reason: format!("live: {error}") })
}

/// Serves a mission in the field to Foxglove.
fn serve_foxglove(
    settings: &foxglove::Settings,
    file: &Path,
) -> Result<(foxglove::Server, MessageListener), RuntimeError> {
    foxglove::Server::start(settings).map_err(|error| RuntimeError::Settings {
        file: file.to_owned(),
        reason: format!("foxglove: {error}"),
    })
}

/// Runs the simulated world of a scenario for robots in other processes, until all of them rest.
///
/// # Errors
/// If the settings are invalid, a robot does not join, or the process is asked to stop before.
pub fn world(
    scenario: &Scenario,
    file: &Path,
    spectator: StepObserver<'_>,
) -> Result<(Episode, u64), RuntimeError> {
    let mut config: SimSettings = config::load(file)?;
    let mission = config.check(file)?;
    config.zenoh = config.zenoh.named_in(file);
    let episode = block_on(async {
        let stop = stop::asked(Bond::None)?;
        tokio::pin!(stop);
        let stopped = || Err(RuntimeError::Stopped { recording: None });
        let session = tokio::select! {
            session = open_when_there(&config.zenoh) => session?,
            () = &mut stop => return stopped(),
        };
        let searching = async {
            let (session, factor) = (session.clone(), config.real_time_factor);
            let server = WorldServer::open(session, mission, scenario, config.seed, factor, true, spectator);
            tokio::select! {
                ended = async { server.await?.run().await } => ended,
                () = stop => stopped(),
            }
        };
        leaving(&session, Box::pin(searching)).await
    })?;
    Ok((episode, config.seed))
}

/// Completes when the process is asked to stop; a process without a bond logs it.
fn stopped(
    bond: Bond,
    participant: Participant,
    mission: &Mission,
) -> Result<impl Future<Output = ()>, RuntimeError> {
    let stop = stop::asked(bond)?;
    Ok(async move {
        stop.await;
        if bond == Bond::None {
            tracing::info!("{participant} of mission {mission} was asked to stop, and ends");
        }
    })
}

/// Logs the endpoints, so that a process without peers can be diagnosed.
fn log_start(link: &Link, endpoints: &Endpoints) {
    let list = |endpoints: &[String]| match endpoints {
        [] => "nowhere".to_owned(),
        endpoints => endpoints.join(", "),
    };
    tracing::info!(
        "{} of mission {} listens at {} and connects to {}; arrivals are logged",
        link.me(),
        link.mission(),
        list(&endpoints.listen),
        list(&endpoints.connect),
    );
    if let Some([found, advice]) = session::alone(endpoints) {
        tracing::warn!("{found}; {advice}");
    }
}
