//! Whole teams under fire: seeds of which each is another search with other faults, and what must hold at every step.
//!
//! An episode is a function of its seed alone, so that a seed that fails is all that is needed to see it fail again.

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
use crate::simulation::{End, Membership, Rules};
use check::Checks;
use disk::Disk;

pub use plan::plan;

/// So few observations of each origin does a robot hold in memory, that it is asked for others.
const HELD: NonZeroUsize = NonZeroUsize::new(2).expect("above 0");

/// How often each fault has bitten.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FaultCounts {
    /// On messages.
    pub network: Tally,
    /// Robots that crashed for good.
    pub gone: u64,
    /// Robots that started again and remembered.
    pub returned_with_memory: u64,
    /// Of these, robots that did not remember what their disks had no room for.
    pub full_disks: u64,
    /// Robots that started again and did not.
    pub returned_without: u64,
    /// The coordinator, which remembers nothing.
    pub coordinator_returned: u64,
    /// Participants whose clocks were ahead.
    pub clocks: u64,
    /// Robots that were slow.
    pub slow: u64,
    /// Robots that lied.
    pub liars: u64,
    /// Lies that were refused.
    pub lies_refused: u64,
    /// Questions for what a robot has released, answered from its disk.
    pub repeated: u64,
    /// What a person asked for: pauses, marks, cells to be searched too.
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
        self.liars += other.liars;
        self.lies_refused += other.lies_refused;
        self.repeated += other.repeated;
        self.commands += other.commands;
    }
}

/// An episode that held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survived {
    /// What was survived.
    pub bites: FaultCounts,
    /// When the search ended.
    pub ended: MissionTime,
    /// Observations made.
    pub observations: u64,
    /// Steps after which all was checked.
    pub checked: u64,
}

/// What did not hold.
#[derive(Debug, thiserror::Error)]
pub enum Violation {
    /// A seed that makes no scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A participant gave up.
    #[error(transparent)]
    StateMachine(#[from] ParticipantError),
    /// Something that must hold did not.
    #[error("at {:.3} s, {who}: {what}", at.as_seconds())]
    Broken {
        /// When, by the clock of who is concerned.
        at: MissionTime,
        /// Whom it concerns.
        who: Participant,
        /// What.
        what: String,
    },
    /// After the end not all believed the same.
    #[error("the search ended at {:.3} s and the beliefs never became equal: {known}", at.as_seconds())]
    Unequal {
        /// When the search ended.
        at: MissionTime,
        /// What each knows, in words.
        known: String,
    },
}

/// Runs the search of a seed under its faults. `coordinator` makes one that has heard nothing yet.
///
/// # Errors
/// What did not hold.
pub fn run(
    seed: u64,
    coordinator: impl FnMut(&Scenario) -> Box<dyn StateMachine>,
) -> Result<Survived, Violation> {
    let (scenario, faults) = plan(seed)?;
    let mut participants = CheckedTeam::new(&scenario, seed, &faults, coordinator);
    let rules = Rules { end: End::Resting, coordinator: Membership::Present };
    let episode = episode::run_with_faults(&scenario, seed, rules, faults.clone(), &mut participants)?;
    let outcome = episode.outcome;
    if !outcome.beliefs_equal {
        return Err(Violation::Unequal { at: outcome.ended, known: participants.checks.known() });
    }
    participants.checks.end(outcome.ended)?;
    let is_gone = |crash: &&Crash| crash.back.is_none() && crash.at <= outcome.ended;
    let bites = FaultCounts {
        gone: faults.crashes.values().filter(is_gone).count() as u64,
        network: outcome.network,
        clocks: faults.clocks.len() as u64,
        slow: faults.slowness.len() as u64,
        liars: faults.liar.iter().count() as u64,
        ..participants.bites
    };
    let (observations, checked) = (outcome.observations, participants.checks.count());
    Ok(Survived { bites, ended: outcome.ended, observations, checked })
}

/// A team of this process whose members start again as the faults say, each step of it checked.
struct CheckedTeam<'a, F> {
    scenario: &'a Scenario,
    faults: &'a Faults,
    orders: Vec<AgentConfig>,
    robots: Vec<Agent>,
    /// Of each robot.
    disks: Vec<Disk>,
    coordinator: Box<dyn StateMachine>,
    new_coordinator: F,
    checks: Checks<'a>,
    bites: FaultCounts,
}

impl<'a, F: FnMut(&Scenario) -> Box<dyn StateMachine>> CheckedTeam<'a, F> {
    fn new(scenario: &'a Scenario, seed: u64, faults: &'a Faults, mut new_coordinator: F) -> Self {
        let orders = AgentConfig::of_team(scenario, seed);
        Self {
            scenario,
            faults,
            robots: orders.iter().cloned().map(Agent::new).collect(),
            disks: orders
                .iter()
                .map(|orders| Disk::new(faults.full.get(&orders.robot.id).cloned()))
                .collect(),
            orders,
            coordinator: new_coordinator(scenario),
            new_coordinator,
            checks: Checks::new(scenario, faults),
            bites: FaultCounts::default(),
        }
    }

    fn mind(&mut self, who: Participant) -> &mut dyn StateMachine {
        match who {
            Participant::Robot(robot) => &mut self.robots[robot.index()],
            Participant::Coordinator => &mut *self.coordinator,
        }
    }

    /// A robot's disk takes what it is to keep, and answers for what it releases then.
    fn keep(&mut self, robot: RobotId, now: MissionTime, effects: &mut Effects<Message>) {
        let place = robot.index();
        let disk = &mut self.disks[place];
        disk.keep(now, effects);
        if disk.is_level() {
            self.robots[place].release(HELD);
        }
        for request in std::mem::take(&mut effects.repeats) {
            self.bites.repeated += 1;
            effects.published.push((Audience::One(request.from), disk.answer(request)));
        }
    }

    /// The simulator's start of a participant is its return, if it has crashed before.
    fn start(&mut self, who: Participant, now: MissionTime) {
        if now == MissionTime::START + self.faults.ahead(who) {
            return;
        }
        let Participant::Robot(robot) = who else {
            self.coordinator = (self.new_coordinator)(self.scenario);
            self.bites.coordinator_returned += 1;
            self.checks.restart(who, now, &[]);
            return;
        };
        let place = robot.index();
        self.robots[place] = Agent::new(self.orders[place].clone());
        let back = self.faults.crashes.get(&who).and_then(|crash| crash.back);
        if matches!(back, Some((_, Memory::Kept))) {
            self.bites.returned_with_memory += 1;
            self.bites.full_disks += u64::from(self.disks[place].restart() > 0);
        } else {
            self.bites.returned_without += 1;
            self.disks[place].clear();
        }
        for observation in self.disks[place].written() {
            self.robots[place].recall(observation);
        }
        self.checks.restart(who, now, self.disks[place].written());
    }
}

impl<F: FnMut(&Scenario) -> Box<dyn StateMachine>> Participants for CheckedTeam<'_, F> {
    type MessageRef = Message;
    type Error = Violation;

    fn step(
        &mut self,
        who: Participant,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, Violation> {
        if event == Event::Start {
            self.start(who, now);
        }
        if matches!(event, Event::Commanded(_)) {
            self.bites.commands += 1;
        }
        self.checks.before(who, now, &event);
        let mut effects = self.mind(who).handle(now, event)?;
        if let Participant::Robot(robot) = who {
            self.keep(robot, now, &mut effects);
        }
        let (digest, observations) = (self.mind(who).digest(), self.mind(who).observations());
        self.checks.after(who, now, &effects, digest, observations)?;
        self.bites.lies_refused += effects.refused.len() as u64;
        if self.faults.liar.map(Participant::Robot) == Some(who) {
            effects.published.iter_mut().for_each(|(_, message)| lie::told(message));
        }
        Ok(effects)
    }

    fn digest(&mut self, who: Participant, _: MissionTime) -> Result<Digest, Violation> {
        Ok(self.mind(who).digest())
    }
}
