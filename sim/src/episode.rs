//! Whole episodes in this process: no socket, no thread, thousands of seeds.

use std::ops::ControlFlow;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, ParticipantError};
use dragnet_scenario::Scenario;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::belief::Belief;
use dragnet_search::evidence::Digest;
use dragnet_search::measures::{Score, Truth};
use dragnet_search::reach::Reach;

use crate::faults::Faults;
use crate::participants::{LocalParticipants, Participants};
use crate::simulation::{End, Membership, Outcome, Rules, Simulation, StepObserver};
use crate::world::World;

/// What an episode came to.
#[derive(Clone, Debug)]
pub struct Episode {
    /// Where the objects were.
    pub truth: Truth,
    /// The belief that all readings together support.
    pub belief: Belief,
    /// What robots could see from where they started.
    pub reach: Reach,
    /// How the belief compares with the truth, as far as robots could see.
    pub score: Score,
    /// Objects that the belief expects not to be found, of those that robots could see: `score.false_negatives` are not.
    pub expected_remaining: f64,
    /// Way covered by each robot, cells.
    pub path_cells: Vec<f64>,
    /// What was measured on the way.
    pub outcome: Outcome,
}

impl Episode {
    /// The end of an episode.
    #[must_use]
    pub fn new(world: World, outcome: Outcome) -> Self {
        Self {
            truth: world.truth().clone(),
            reach: world.reach().clone(),
            score: world.score(),
            expected_remaining: world.expected_remaining(),
            path_cells: world.path_cells().collect(),
            belief: world.into_merged(),
            outcome,
        }
    }
}

/// Runs a scenario with robots alone, no coordinator.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn run(scenario: &Scenario, seed: u64, end: End) -> Result<Episode, ParticipantError> {
    run_robots(scenario, seed, end, &mut team(scenario, seed, Agent::new))
}

/// Runs a scenario with these robots alone.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn run_robots(
    scenario: &Scenario,
    seed: u64,
    end: End,
    robots: &mut [Agent],
) -> Result<Episode, ParticipantError> {
    run_with(scenario, seed, alone(end), &mut LocalParticipants::new(robots, None), &mut |_, _| ())
}

/// Runs a scenario with any participants, watched.
///
/// # Errors
/// If a participant cannot go on.
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

/// The same, with faults of the participants themselves.
///
/// # Errors
/// If a participant cannot go on.
pub fn run_with_faults<C: Participants>(
    scenario: &Scenario,
    seed: u64,
    rules: Rules,
    faults: Faults,
    participants: &mut C,
) -> Result<Episode, C::Error> {
    let mut nobody = |_, _| ();
    let simulation = Simulation::new(scenario, seed, rules, participants, &mut nobody).with_faults(faults);
    let (world, outcome) = simulation.run()?;
    Ok(Episode::new(world, outcome))
}

/// Runs a scenario with these robots alone until it ends or the witness has seen enough.
///
/// # Errors
/// Never, as long as robots of this process cannot fail.
pub fn watch(
    scenario: &Scenario,
    seed: u64,
    end: End,
    robots: &mut [Agent],
    witness: &mut dyn Observer,
) -> Result<(), ParticipantError> {
    let mut participants = Witnessed { participants: LocalParticipants::new(robots, None), witness };
    match run_with(scenario, seed, alone(end), &mut participants, &mut |_, _| ()) {
        Ok(_) | Err(Left::SeenEnough) => Ok(()),
        Err(Left::Failed(error)) => Err(error),
    }
}

/// The robots of a scenario, as `robot` makes each of its orders.
pub fn team(scenario: &Scenario, seed: u64, robot: impl FnMut(AgentConfig) -> Agent) -> Vec<Agent> {
    AgentConfig::of_team(scenario, seed).into_iter().map(robot).collect()
}

const fn alone(end: End) -> Rules {
    Rules { end, coordinator: Membership::Absent }
}

/// Who sees what happens to robots, and what they do about it.
pub trait Observer {
    /// Something happens to a robot.
    fn happens(&mut self, _stimulus: &Event<Message>) {}

    /// A robot did something about it. Whether that is enough.
    fn reacts(&mut self, effects: &Effects<Message>) -> ControlFlow<()>;
}

struct Witnessed<'a> {
    participants: LocalParticipants<'a>,
    witness: &'a mut dyn Observer,
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
        who: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, Left> {
        self.witness.happens(&event);
        let effects = self.participants.step(who, now, event).map_err(Left::Failed)?;
        match self.witness.reacts(&effects) {
            ControlFlow::Continue(()) => Ok(effects),
            ControlFlow::Break(()) => Err(Left::SeenEnough),
        }
    }

    fn digest(&mut self, who: Participant, now: MissionTime) -> Result<Digest, Left> {
        self.participants.digest(who, now).map_err(Left::Failed)
    }
}
