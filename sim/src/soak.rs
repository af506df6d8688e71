//! Teams under injected faults: each seed is a different search with different faults, and invariants are checked at
//! every step.
//!
//! An episode is a function of its seed alone, so that a failing seed is sufficient to reproduce the failure.

mod bodies;
mod check;
mod disk;
mod lie;
mod plan;

use std::num::NonZeroUsize;
use std::ops::AddAssign;

use dragnet_agent::agent::{Agent, AgentConfig};
use dragnet_proto::message::{Audience, Message};
use dragnet_proto::state_machine::{Effects, Event, ParticipantError, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_scenario::{Scenario, ScenarioError};
use dragnet_search::evidence::Digest;
use dragnet_search::observation::RobotId;

use crate::episode;
use crate::faults::{Crash, Faults, Memory};
use crate::network::Tally;
use crate::participants::Participants;
use crate::simulation::{End, Membership, Rules, StepContext};
use bodies::Bodies;
use check::Checks;
use disk::Disk;

pub use plan::plan;

/// Number of observations of each origin that a robot holds in memory: so few that others are requested from it.
const HELD: NonZeroUsize = NonZeroUsize::new(2).expect("above 0");

/// Number of occurrences of each fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FaultCounts {
    /// Faults of messages.
    pub network: Tally,
    /// Robots that crashed and did not restart.
    pub gone: u64,
    /// Robots that restarted with their stored state.
    pub returned_with_memory: u64,
    /// Of these, robots that lost observations because their disks were full.
    pub full_disks: u64,
    /// Robots that restarted without stored state.
    pub returned_without: u64,
    /// Restarts of the coordinator, which stores nothing.
    pub coordinator_returned: u64,
    /// Participants whose clocks were ahead.
    pub clocks: u64,
    /// Robots that were slow.
    pub slow: u64,
    /// Robots that published false readings.
    pub false_reporters: u64,
    /// False readings that were rejected.
    pub false_readings_rejected: u64,
    /// Requests for released observations, answered from disk.
    pub repeated: u64,
    /// Commands of the operator: pauses, marks, cells added to the search.
    pub commands: u64,
}

impl AddAssign for FaultCounts {
    fn add_assign(&mut self, other: Self) {
        self.network += other.network;
        self.gone += other.gone;
        self.returned_with_memory += other.returned_with_memory;
        self.full_disks += other.full_disks;
        self.returned_without += other.returned_without;
        self.coordinator_returned += other.coordinator_returned;
        self.clocks += other.clocks;
        self.slow += other.slow;
        self.false_reporters += other.false_reporters;
        self.false_readings_rejected += other.false_readings_rejected;
        self.repeated += other.repeated;
        self.commands += other.commands;
    }
}

/// An episode without violations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survived {
    /// The faults that occurred.
    pub fault_counts: FaultCounts,
    /// When the search ended.
    pub ended: MissionTime,
    /// Observations made.
    pub observations: u64,
    /// Number of checked steps.
    pub checked: u64,
}

/// A violated invariant.
#[derive(Debug, thiserror::Error)]
pub enum Violation {
    /// An invalid scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A participant failed.
    #[error(transparent)]
    StateMachine(#[from] ParticipantError),
    /// An invariant does not hold.
    #[error("at {:.3} s, {participant}: {what}", at.as_seconds())]
    Broken {
        /// When, by the participant's clock.
        at: MissionTime,
        /// The participant.
        participant: Participant,
        /// The invariant.
        what: String,
    },
    /// After the end, beliefs differ.
    #[error("the search ended at {:.3} s and the beliefs never became equal: {known}", at.as_seconds())]
    Unequal {
        /// When the search ended.
        at: MissionTime,
        /// The observations of each participant, in words.
        known: String,
    },
}

/// Runs the search of a seed under its faults. `coordinator` constructs a new coordinator.
///
/// # Errors
/// The first violated invariant.
pub fn run(
    seed: u64,
    coordinator: impl FnMut(&Scenario) -> Box<dyn StateMachine>,
) -> Result<Survived, Violation> {
    let (scenario, faults) = plan(seed)?;
    let mut participants = CheckedTeam::new(&scenario, seed, &faults, coordinator);
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let mut bodies = Bodies::new(&scenario, &faults);
    let mut spectator = |now, step| {
        if let StepContext::Arrives { robot, cell, .. } = step {
            bodies.is_in(now, robot, cell);
        }
    };
    let episode =
        episode::run_with_faults(&scenario, seed, rules, faults.clone(), &mut participants, &mut spectator)?;
    let outcome = episode.outcome;
    bodies.check(outcome.ended)?;
    if !outcome.beliefs_equal {
        return Err(Violation::Unequal { at: outcome.ended, known: participants.checks.known() });
    }
    participants.checks.end(outcome.ended, &episode.at_start)?;
    let is_gone = |crash: &&Crash| crash.back.is_none() && crash.at <= outcome.ended;
    let fault_counts = FaultCounts {
        gone: faults.crashes.values().filter(is_gone).count() as u64,
        network: outcome.network,
        clocks: faults.clocks.len() as u64,
        slow: faults.slowness.len() as u64,
        false_reporters: faults.liar.iter().count() as u64,
        ..participants.fault_counts
    };
    let (observations, checked) = (outcome.observations, participants.checks.count());
    Ok(Survived { fault_counts, ended: outcome.ended, observations, checked })
}

/// A team of this process whose members restart as planned; each of their steps is checked.
struct CheckedTeam<'a, F> {
    scenario: &'a Scenario,
    faults: &'a Faults,
    config: Vec<AgentConfig>,
    robots: Vec<Agent>,
    /// Of each robot.
    disks: Vec<Disk>,
    coordinator: Box<dyn StateMachine>,
    new_coordinator: F,
    checks: Checks<'a>,
    fault_counts: FaultCounts,
}

impl<'a, F: FnMut(&Scenario) -> Box<dyn StateMachine>> CheckedTeam<'a, F> {
    fn new(scenario: &'a Scenario, seed: u64, faults: &'a Faults, mut new_coordinator: F) -> Self {
        let config = AgentConfig::of_team(scenario, seed);
        Self {
            scenario,
            faults,
            robots: config.iter().cloned().map(Agent::new).collect(),
            disks: config
                .iter()
                .map(|config| Disk::new(faults.full.get(&config.robot.id).cloned()))
                .collect(),
            config,
            coordinator: new_coordinator(scenario),
            new_coordinator,
            checks: Checks::new(scenario, faults),
            fault_counts: FaultCounts::default(),
        }
    }

    fn machine(&mut self, participant: Participant) -> &mut dyn StateMachine {
        match participant {
            Participant::Robot(robot) => &mut self.robots[robot.index()],
            Participant::Coordinator => &mut *self.coordinator,
        }
    }

    /// A robot's disk stores its observations, and answers requests for released ones.
    fn keep(&mut self, robot: RobotId, now: MissionTime, effects: &mut Effects<Message>) {
        let place = robot.index();
        let disk = &mut self.disks[place];
        disk.keep(now, effects);
        if disk.is_level() {
            self.robots[place].release(HELD);
        }
        for request in std::mem::take(&mut effects.repeats) {
            self.fault_counts.repeated += 1;
            effects.published.push((Audience::One(request.from), disk.answer(request)));
        }
    }

    /// A simulator's start event is a restart, if the participant has crashed before.
    fn start(&mut self, participant: Participant, now: MissionTime) {
        if now == MissionTime::START + self.faults.ahead(participant) {
            return;
        }
        let Participant::Robot(robot) = participant else {
            self.coordinator = (self.new_coordinator)(self.scenario);
            self.fault_counts.coordinator_returned += 1;
            self.checks.restart(participant, now, &[], []);
            return;
        };
        let place = robot.index();
        self.robots[place] = Agent::new(self.config[place].clone());
        let back = self.faults.crashes.get(&participant).and_then(|crash| crash.back);
        if matches!(back, Some((_, Memory::Kept))) {
            self.fault_counts.returned_with_memory += 1;
            self.fault_counts.full_disks += u64::from(self.disks[place].restart() > 0);
        } else {
            self.fault_counts.returned_without += 1;
            self.disks[place].clear();
        }
        let disk = &self.disks[place];
        for observation in disk.written() {
            self.robots[place].recall(observation);
        }
        for message in disk.instructions() {
            self.robots[place].recall_instructions(now, message);
        }
        self.checks.restart(participant, now, disk.written(), disk.instructions());
    }
}

impl<F: FnMut(&Scenario) -> Box<dyn StateMachine>> Participants for CheckedTeam<'_, F> {
    type MessageRef = Message;
    type Error = Violation;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, Violation> {
        if event == Event::Start {
            self.start(participant, now);
        }
        if matches!(event, Event::Commanded(_)) {
            self.fault_counts.commands += 1;
        }
        self.checks.before(participant, now, &event);
        let mut effects = self.machine(participant).handle(now, event)?;
        if let Participant::Robot(robot) = participant {
            self.keep(robot, now, &mut effects);
        }
        let (digest, observations) =
            (self.machine(participant).digest(), self.machine(participant).observations());
        self.checks.after(participant, now, &effects, digest, observations)?;
        self.fault_counts.false_readings_rejected += effects.rejected.len() as u64;
        if self.faults.liar.map(Participant::Robot) == Some(participant) {
            effects.published.iter_mut().for_each(|(_, message)| lie::reported(message));
        }
        Ok(effects)
    }

    fn digest(&mut self, participant: Participant, _: MissionTime) -> Result<Digest, Violation> {
        Ok(self.machine(participant).digest())
    }
}
