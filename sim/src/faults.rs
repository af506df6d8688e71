//! What goes wrong with the participants themselves: crashes, clocks, slow robots, full disks; and links that work one
//! way only. And a person, who interferes.
//!
//! What goes wrong with all messages alike is part of a scenario: [`dragnet_scenario::Network`].

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
    /// At most one a participant.
    pub crashes: BTreeMap<Participant, Crash>,
    /// How far clocks are ahead of the simulator's, where they are.
    pub clocks: BTreeMap<Participant, Duration>,
    /// How many times as long as others a robot takes to the next cell, where it does: at least 1.
    pub slowness: BTreeMap<RobotId, f64>,
    /// When a robot's disk takes nothing, if it ever does, by its own clock.
    pub full: BTreeMap<RobotId, Range<MissionTime>>,
    /// Links that fail.
    pub mute: Vec<OneWayLoss>,
    /// A robot that lies about what it sees, if one does: nobody waits for others to believe what it believes.
    pub liar: Option<RobotId>,
    /// What a person asks of the coordinator, and when; while there is none, later.
    pub commands: Vec<(MissionTime, Command)>,
}

/// A participant stops at once, and may start again.
#[derive(Clone, Debug, PartialEq)]
pub struct Crash {
    /// When, by the simulator's clock.
    pub at: MissionTime,
    /// When it starts again, if it does, and with what memory.
    pub back: Option<(MissionTime, Memory)>,
}

/// What a participant still knows when it starts again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// All that its disk took of what it was to keep: [`dragnet_proto::state_machine::Effects::kept`].
    Kept,
    /// Nothing.
    Lost,
}

/// A participant does not hear another, which may hear it.
#[derive(Clone, Debug, PartialEq)]
pub struct OneWayLoss {
    /// Who is not heard.
    pub from: Participant,
    /// By whom.
    pub to: Participant,
    /// When.
    pub during: Range<MissionTime>,
}

impl Faults {
    /// How far a clock is ahead.
    pub(crate) fn ahead(&self, who: Participant) -> Duration {
        self.clocks.get(&who).copied().unwrap_or_default()
    }

    /// How many times as long as others a robot takes.
    pub(crate) fn slowness(&self, robot: RobotId) -> f64 {
        self.slowness.get(&robot).copied().unwrap_or(1.0)
    }
}
