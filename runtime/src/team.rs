//! A whole team in one call: robots, coordinator and simulated world, each on a session of its own.

mod children;
mod lockstep_run;
mod memory_run;
pub(crate) mod recording;
mod wall_clock_run;

use std::path::{Path, PathBuf};

use dragnet_coordinator::node::Listener;
use dragnet_coordinator::record::encoder::MessageListener;
use dragnet_export::cot::NotOnEarth;
use dragnet_proto::key::Mission;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::{Network, Scenario};
use dragnet_sim::episode::Episode;
use dragnet_sim::simulation::StepObserver;
use serde::Serialize;
use tokio::sync::mpsc;
use tokio::task::JoinError;
use zenoh::Session;

use crate::RuntimeError;
use crate::config::check_real_time_factor;
use crate::session::{Endpoints, free_endpoints, open, runtime};
use crate::tak;
use crate::wall_clock::Report;

/// Medium of the messages of a team in simulated time. The search and its recording are the same, byte for byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Medium {
    /// Zenoh: each participant has its own session.
    #[default]
    Zenoh,
    /// The memory of this process: nothing is encoded or sent.
    Memory,
}

/// Options of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Medium of its messages.
    pub medium: Medium,
    /// A new file to record the mission to.
    pub recording: Option<PathBuf>,
    /// The program `dragnet`, to run each robot in a process of its own.
    pub processes: Option<PathBuf>,
    /// Mission seconds per second of the wall clock; `None`: simulated time.
    pub real_time_factor: Option<f64>,
    /// Number of threads that deliver messages in memory; 0 means the number of cores. The result does not depend on
    /// it.
    pub threads: usize,
    /// Version and commit of this program, for the recording.
    pub version: String,
    /// Where to send a mission by the wall clock on the maps of TAK.
    pub tak: Option<tak::settings::Settings>,
}

/// The results of a run.
#[derive(Debug)]
pub struct Run {
    /// The episode.
    pub episode: Episode,
    /// Number of observations that the coordinator merged.
    pub observations_merged: u64,
    /// The recording.
    pub recording: Option<PathBuf>,
    /// Why the recording is not complete.
    pub unrecorded: Option<RuntimeError>,
}

/// Runs a scenario over Zenoh on this computer's loopback interface, or in the memory of this process.
///
/// In simulated time the run is a function of scenario, seed and commit: the same recording, byte for byte.
///
/// # Errors
/// If the options do not fit the scenario, a session cannot be opened, a participant fails, or not all could be
/// recorded.
pub fn run(
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    spectator: StepObserver<'_>,
) -> Result<Run, RuntimeError> {
    run_watched(scenario, seed, options, RunObserver::default(), spectator)
}

/// Observers of a team that searches by the wall clock, who may send commands to its coordinator.
#[derive(Default)]
pub struct RunObserver {
    /// Receives each record of the coordinator.
    pub listener: Option<Listener>,
    /// Commands to the coordinator.
    pub commands: Option<mpsc::Receiver<Report>>,
    /// Receives each message of the mission, as it is recorded.
    pub messages: Option<MessageListener>,
}

impl RunObserver {
    const fn is_there(&self) -> bool {
        self.listener.is_some() || self.messages.is_some()
    }
}

/// Like [`run`], with observers.
///
/// # Errors
/// As [`run`], and if there are observers in simulated time.
pub fn run_watched(
    scenario: &Scenario,
    seed: u64,
    options: &Options,
    observer: RunObserver,
    spectator: StepObserver<'_>,
) -> Result<Run, RuntimeError> {
    check(scenario, options)?;
    match options.real_time_factor {
        None if observer.is_there() => {
            unsupported("a search that is watched runs by the wall clock: give it a real_time_factor")
        }
        None if options.medium == Medium::Memory => memory_run::run(scenario, seed, options, spectator),
        None => lockstep_run::run(&runtime()?, scenario, seed, options, spectator),
        Some(real_time_factor) => runtime()?.block_on(wall_clock_run::run(
            scenario,
            seed,
            real_time_factor,
            options,
            observer,
            spectator,
        )),
    }
}

/// Checks what [`run`] refuses before it starts anything.
///
/// # Errors
/// If the options do not fit the scenario.
pub fn check(scenario: &Scenario, options: &Options) -> Result<(), RuntimeError> {
    if options.medium == Medium::Memory && (options.processes.is_some() || options.real_time_factor.is_some())
    {
        return unsupported("robots in processes of their own, and teams by the wall clock, need Zenoh");
    }
    if options.medium == Medium::Zenoh {
        mission(scenario)?;
    }
    let Some(real_time_factor) = options.real_time_factor else {
        return match options.tak {
            Some(_) => {
                unsupported("a search that is sent to TAK runs by the wall clock: give it a real_time_factor")
            }
            None => Ok(()),
        };
    };
    target(options)?;
    if options.tak.is_some() && scenario.georeference().is_none() {
        return Err(NotOnEarth.into());
    }
    check_real_time_factor(real_time_factor).map_err(RuntimeError::Unsupported)?;
    let faults = Network { bytes_per_second: None, ..scenario.network().clone() };
    if faults != Network::default() {
        return unsupported(
            "[network] faults but bytes_per_second are simulated in simulated time only: run without a \
             real_time_factor, or remove them",
        );
    }
    Ok(())
}

fn unsupported<T>(why: &str) -> Result<T, RuntimeError> {
    Err(RuntimeError::Unsupported(why.to_owned()))
}

/// Where to send the mission on the maps of TAK.
fn target(options: &Options) -> Result<Option<tak::settings::Checked>, RuntimeError> {
    let target = options.tak.as_ref().map(|settings| settings.check(Path::new("")));
    target.transpose().map_err(RuntimeError::Unsupported)
}

/// All participants of a scenario: robots by number, then the coordinator.
pub(crate) fn everybody(scenario: &Scenario) -> Vec<Participant> {
    let robots = scenario.robots().iter().map(|robot| Participant::Robot(robot.id));
    robots.chain([Participant::Coordinator]).collect()
}

/// The mission's name on the network.
fn mission(scenario: &Scenario) -> Result<Mission, RuntimeError> {
    let name = scenario.name().to_ascii_lowercase();
    name.parse().map_err(|error| RuntimeError::Unsupported(format!("mission name {name:?}: {error}")))
}

/// The result of a participant's task.
async fn joined<T>(
    task: impl Future<Output = Result<Result<T, RuntimeError>, JoinError>>,
) -> Result<T, RuntimeError> {
    task.await.map_err(|error| RuntimeError::Zenoh {
        what: "end a participant".to_owned(),
        reason: error.to_string(),
    })?
}

/// The endpoints of a mesh: each session listens, and connects to all before it, so that each pair has one connection.
struct Mesh {
    /// One for each session.
    listen: Vec<String>,
    config: Option<PathBuf>,
}

impl Mesh {
    fn new(scenario: &Scenario) -> Result<Self, RuntimeError> {
        let sessions = scenario.robots().len() + 2;
        // A child process reads it from settings in another folder.
        let config = scenario.zenoh_config().map(std::path::absolute).transpose();
        let config = config.map_err(|error| RuntimeError::Unsupported(format!("zenoh.config: {error}")))?;
        Ok(Self { listen: free_endpoints(sessions)?, config })
    }

    /// The endpoints of the simulated world.
    fn world(&self) -> Endpoints {
        self.endpoints(0)
    }

    /// The endpoints of a participant.
    fn participant(&self, participant: Participant) -> Endpoints {
        match participant {
            Participant::Coordinator => self.endpoints(1),
            Participant::Robot(robot) => self.endpoints(robot.index() + 2),
        }
    }

    fn endpoints(&self, place: usize) -> Endpoints {
        Endpoints {
            listen: vec![self.listen[place].clone()],
            connect: self.listen[..place].to_vec(),
            config: self.config.clone(),
            mode: None,
        }
    }

    async fn open_world(&self) -> Result<Session, RuntimeError> {
        open(&self.world()).await
    }

    async fn open_participant(&self, participant: Participant) -> Result<Session, RuntimeError> {
        open(&self.participant(participant)).await
    }
}
