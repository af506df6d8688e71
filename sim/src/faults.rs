//! Faults of participants: crashes, clock errors, slow robots, full disks, one-way links; and commands of an operator.
//!
//! Faults that affect all messages equally are part of a scenario: [`dragnet_scenario::Network`].

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use dragnet_proto::command::Command;
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::RobotId;

/// All faults of an episode, planned before it starts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// At most one for each participant.
    pub crashes: BTreeMap<Participant, Crash>,
    /// By how much clocks are ahead of the simulator's.
    pub clocks: BTreeMap<Participant, Duration>,
    /// Factors by which robots take longer to the next cell: at least 1.
    pub slowness: BTreeMap<RobotId, f64>,
    /// When a robot's disk is full, by its own clock.
    pub full: BTreeMap<RobotId, Range<MissionTime>>,
    /// Links that lose messages in one direction.
    pub mute: Vec<OneWayLoss>,
    /// A robot that publishes false readings, if any. Its belief is not compared with the others'.
    pub liar: Option<RobotId>,
    /// The operator's commands to the coordinator with their times; delayed while there is no coordinator.
    pub commands: Vec<(MissionTime, Command)>,
}

/// A participant stops suddenly, and may restart.
#[derive(Clone, Debug, PartialEq)]
pub struct Crash {
    /// When, by the simulator's clock.
    pub at: MissionTime,
    /// When it restarts, and what it has stored; `None` if it does not restart.
    pub back: Option<(MissionTime, Memory)>,
}

/// The stored state of a restarted participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// All of [`dragnet_proto::state_machine::Effects::kept`] and the instructions that it passed on, as far as its disk was not
    /// full.
    Kept,
    /// Nothing.
    Lost,
}

/// A participant does not receive another's messages, while the reverse direction works.
#[derive(Clone, Debug, PartialEq)]
pub struct OneWayLoss {
    /// The sender.
    pub from: Participant,
    /// The receiver.
    pub to: Participant,
    /// When.
    pub during: Range<MissionTime>,
}

impl Faults {
    /// By how much a clock is ahead.
    pub(crate) fn ahead(&self, participant: Participant) -> Duration {
        self.clocks.get(&participant).copied().unwrap_or_default()
    }

    /// The factor by which a robot takes longer.
    pub(crate) fn slowness(&self, robot: RobotId) -> f64 {
        self.slowness.get(&robot).copied().unwrap_or(1.0)
    }
}
