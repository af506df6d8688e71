//! Whole episodes in the memory of this process, without sockets or threads.

use std::ops::ControlFlow;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_proto::verdict::Verdicts;
use dragnet_proto::zones::Zones;
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::evidence::Digest;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::reach::Reach;
use dragnet_search::subjects::Standing;

use crate::faults::Faults;
use crate::participants::{LocalParticipants, Participants};
use crate::simulation::{End, Membership, Outcome, Rules, Simulation, StepObserver};
use crate::world::World;

/// The result of an episode.
#[derive(Clone, Debug)]
pub struct Episode {
    /// The objects.
    pub truth: Truth,
    /// The belief from all readings together.
    pub belief: Belief,
    /// Cells that robots can observe, given their start cells.
    pub reach: Reach,
    /// The belief compared with the truth, counting cells in reach.
    pub score: Score,
    /// Expected number of objects in reach that are not found, by the belief; the true number is
    /// `score.false_negatives`.
    pub expected_remaining: f64,
    /// Where the subjects are, by what is found, if their number is known.
    pub subject: Option<Standing>,
    /// Path length of each robot, cells.
    pub path_cells: Vec<f64>,
    /// Whether each robot ended in the cell that it started in.
    pub at_start: Vec<bool>,
    /// The operator's verdicts on finds.
    pub verdicts: Verdicts,
    /// The operator's zones.
    pub zones: Zones,
    /// Measurements during the episode.
    pub outcome: Outcome,
}

impl Episode {
    /// The result of a completed episode.
    #[must_use]
    pub fn new(world: World, mut outcome: Outcome) -> Self {
        outcome.end(|cell| world.is_found(cell));
        Self {
            truth: world.truth().clone(),
            reach: world.reach().clone(),
            score: world.score(),
            expected_remaining: world.expected_remaining(),
            subject: world.subject(),
            path_cells: world.path_cells().collect(),
            at_start: world.at_start().collect(),
            verdicts: world.verdicts().clone(),
            zones: world.zones().clone(),
            belief: world.into_merged(),
            outcome,
        }
    }
}

/// Runs a scenario with robots only, without a coordinator.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn run(scenario: &Scenario, seed: u64, end: End) -> Result<Episode, ParticipantError> {
    run_robots(scenario, seed, end, &mut team(scenario, seed, Agent::new))
}

/// Runs a scenario with these robots only.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn run_robots(
    scenario: &Scenario,
    seed: u64,
    end: End,
    robots: &mut [Agent],
) -> Result<Episode, ParticipantError> {
    run_with(scenario, seed, alone(end), &mut LocalParticipants::new(robots, None), &mut |_, _| ())
}

/// Runs a scenario with given participants, and passes each step to an observer.
///
/// # Errors
/// If a participant fails.
pub fn run_with<C: Participants>(
    scenario: &Scenario,
    seed: u64,
    rules: Rules,
    participants: &mut C,
    spectator: StepObserver<'_>,
) -> Result<Episode, C::Error> {
    let (world, outcome) = Simulation::new(scenario, seed, rules, participants, spectator).run()?;
    Ok(Episode::new(world, outcome))
}

/// Like [`run_with`], with faults of the participants.
///
/// # Errors
/// If a participant fails.
pub fn run_with_faults<C: Participants>(
    scenario: &Scenario,
    seed: u64,
    rules: Rules,
    faults: Faults,
    participants: &mut C,
    spectator: StepObserver<'_>,
) -> Result<Episode, C::Error> {
    let simulation = Simulation::new(scenario, seed, rules, participants, spectator).with_faults(faults);
    let (world, outcome) = simulation.run()?;
    Ok(Episode::new(world, outcome))
}

/// Runs a scenario with these robots only, until it ends or the observer stops it.
///
/// # Errors
/// Never, since robots of this process cannot fail.
pub fn watch(
    scenario: &Scenario,
    seed: u64,
    end: End,
    robots: &mut [Agent],
    observer: &mut dyn Observer,
) -> Result<(), ParticipantError> {
    let mut participants = Witnessed { participants: LocalParticipants::new(robots, None), observer };
    match run_with(scenario, seed, alone(end), &mut participants, &mut |_, _| ()) {
        Ok(_) | Err(Left::SeenEnough) => Ok(()),
        Err(Left::Failed(error)) => Err(error),
    }
}

/// The robots of a scenario, each made by `robot` from its configuration.
pub fn team(scenario: &Scenario, seed: u64, robot: impl FnMut(AgentConfig) -> Agent) -> Vec<Agent> {
    AgentConfig::of_team(scenario, seed).into_iter().map(robot).collect()
}

const fn alone(end: End) -> Rules {
    Rules { end, coordinator: Membership::Absent }
}

/// Observes the events of robots, and their effects.
pub trait Observer {
    /// Receives an event of a robot before it is handled.
    fn happens(&mut self, _stimulus: &Event<Message>) {}

    /// Receives the effects of an event. Returns `Break` to stop the episode.
    fn reacts(&mut self, effects: &Effects<Message>) -> ControlFlow<()>;
}

struct Witnessed<'a> {
    participants: LocalParticipants<'a>,
    observer: &'a mut dyn Observer,
}

enum Left {
    SeenEnough,
    Failed(ParticipantError),
}

impl Participants for Witnessed<'_> {
    type MessageRef = Message;
    type Error = Left;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, Left> {
        self.observer.happens(&event);
        let effects = self.participants.step(participant, now, event).map_err(Left::Failed)?;
        match self.observer.reacts(&effects) {
            ControlFlow::Continue(()) => Ok(effects),
            ControlFlow::Break(()) => Err(Left::SeenEnough),
        }
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, Left> {
        self.participants.digest(participant, now).map_err(Left::Failed)
    }
}
