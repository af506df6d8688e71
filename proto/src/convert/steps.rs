//! Messages between simulator and participants, to the wire and back.

use std::time::Duration;

use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;

use super::check::{
    Check, Columns, activity_number, digest, digest_halves, numbers, participant_numbers, robot,
};
use super::error::ConvertError;
use crate::dragnet_msgs as wire;
use crate::message::{Audience, MessageKind};
use crate::radio::{Load, Priority};
use crate::state_machine::{Effects, Event};
use crate::step::{MessageRef, Sensed, Step, StepEvent, StepReply};

const START: u8 = 0;
const SENSED: u8 = 1;
const DELIVER: u8 = 2;
const WAKE: u8 = 3;
const LOST: u8 = 4;
const REPORT: u8 = 5;
const FINISH: u8 = 6;

/// A decision that took no time is one all the same.
const SHORTEST: Duration = Duration::from_nanos(1);
/// Of a participant that need not be woken.
const NEVER: MissionTime = MissionTime(u64::MAX);

/// An event that does not happen in simulated time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "arrivals, failed routes, positions, halts and commands do not exist in simulated time: run by the wall clock"
)]
pub struct NotSimulated;

impl TryFrom<&Step> for wire::Step {
    type Error = NotSimulated;

    fn try_from(step: &Step) -> Result<Self, NotSimulated> {
        let empty = Self { version: wire::VERSION, time_ns: step.time_ns, ..Self::default() };
        Ok(match &step.event {
            StepEvent::Event(Event::Start) => Self { kind: START, ..empty },
            StepEvent::Event(Event::Sensed { cell, readings }) => {
                let Columns { cells, values, variances } = readings.as_slice().into();
                Self { kind: SENSED, cell: cell.number(), cells, values, variances, ..empty }
            }
            StepEvent::Event(Event::Received { from, message }) => {
                let (sender_kind, sender_robot) = participant_numbers(*from);
                Self { kind: DELIVER, sender_kind, sender_robot, message: *message, ..empty }
            }
            StepEvent::Event(Event::Woke) => Self { kind: WAKE, ..empty },
            StepEvent::Event(Event::Lost(robot)) => {
                Self { kind: LOST, sender_robot: robot.number(), ..empty }
            }
            StepEvent::Event(
                Event::RouteFailed { .. }
                | Event::Doubted { .. }
                | Event::LineOfSight(_)
                | Event::Located(_)
                | Event::Came
                | Event::Commanded(_)
                | Event::Halted
                | Event::Released
                | Event::MustReturn(_)
                | Event::Doubled(_)
                | Event::Pictured(_)
                | Event::ClockSet(_)
                | Event::Began { .. },
            ) => return Err(NotSimulated),
            StepEvent::Report => Self { kind: REPORT, ..empty },
            StepEvent::Finish => Self { kind: FINISH, ..empty },
        })
    }
}

impl From<&StepReply> for wire::StepReply {
    fn from(reply: &StepReply) -> Self {
        let Effects { published, route, wake_at, activity, decision, .. } = &reply.effects;
        let (to_kinds, to_robots) = published.iter().map(|&(to, _)| audience_numbers(to)).unzip();
        Self {
            version: wire::STEP_REPLY_VERSION,
            messages: published.iter().map(|(_, message)| message.number).collect(),
            kinds: published.iter().map(|(_, message)| kind_number(message.load.kind)).collect(),
            to_kinds,
            to_robots,
            sizes: published.iter().map(|(_, message)| message.load.bytes).collect(),
            priorities: published.iter().map(|(_, it)| priority_number(it.load.priority)).collect(),
            about_robots: published.iter().map(|(_, message)| message.load.about).collect(),
            has_route: route.is_some(),
            route: numbers(route.as_deref().unwrap_or_default()),
            wake_at_ns: if *wake_at == NEVER { 0 } else { wake_at.0 },
            activity: activity_number(*activity),
            decision_seconds: decision.map_or(0.0, |time| time.max(SHORTEST).as_secs_f64()),
            digest: digest_halves(reply.digest),
            observations: reply.observations,
            error: reply.error.clone(),
        }
    }
}

impl From<&Sensed> for wire::Sensed {
    fn from(sensed: &Sensed) -> Self {
        let Columns { cells, values, variances } = sensed.readings.as_slice().into();
        Self {
            version: wire::VERSION,
            robot: sensed.robot.number(),
            time_ns: sensed.time_ns,
            cell: sensed.from.number(),
            cells,
            values,
            variances,
        }
    }
}

impl Check {
    pub(super) fn step(self, wire: &wire::Step) -> Result<Step, ConvertError> {
        self.version(wire.version)?;
        let event = match wire.kind {
            START => StepEvent::Event(Event::Start),
            SENSED => StepEvent::Event(Event::Sensed {
                cell: self.cell(self.at("cell"), wire.cell)?,
                readings: self.readings(&wire.cells, &wire.values, &wire.variances)?,
            }),
            DELIVER => StepEvent::Event(Event::Received {
                from: self.participant(
                    ["sender_kind", "sender_robot"],
                    wire.sender_kind,
                    wire.sender_robot,
                )?,
                message: wire.message,
            }),
            WAKE => StepEvent::Event(Event::Woke),
            LOST => StepEvent::Event(Event::Lost(robot(self.at("sender_robot"), wire.sender_robot)?)),
            REPORT => StepEvent::Report,
            FINISH => StepEvent::Finish,
            found => {
                let allowed = "0 start, 1 sensed, 2 deliver, 3 wake, 4 lost, 5 report, 6 finish";
                return Err(ConvertError::Alternative { at: self.at("kind"), found, allowed });
            }
        };
        Ok(Step { time_ns: wire.time_ns, event })
    }

    pub(super) fn step_reply(self, wire: wire::StepReply) -> Result<StepReply, ConvertError> {
        self.version(wire.version)?;
        let route = self.path("route", &wire.route)?;
        let seconds = self.seconds("decision_seconds", wire.decision_seconds)?;
        let effects = Effects {
            published: self.messages(&wire)?,
            route: wire.has_route.then_some(route),
            wake_at: if wire.wake_at_ns == 0 { NEVER } else { MissionTime(wire.wake_at_ns) },
            activity: self.activity(wire.activity)?,
            decision: (seconds > 0.0).then(|| Duration::from_secs_f64(seconds).max(SHORTEST)),
            ..Effects::default()
        };
        Ok(StepReply {
            effects,
            digest: digest(wire.digest),
            observations: wire.observations,
            error: wire.error,
        })
    }

    fn messages(self, wire: &wire::StepReply) -> Result<Vec<(Audience, MessageRef)>, ConvertError> {
        let expected = wire.messages.len();
        self.same_length("kinds", wire.kinds.len(), "messages", expected)?;
        self.same_length("to_kinds", wire.to_kinds.len(), "messages", expected)?;
        self.same_length("to_robots", wire.to_robots.len(), "messages", expected)?;
        self.same_length("sizes", wire.sizes.len(), "messages", expected)?;
        self.same_length("priorities", wire.priorities.len(), "messages", expected)?;
        self.same_length("about_robots", wire.about_robots.len(), "messages", expected)?;
        let message = |index: usize| {
            let to = self.audience(index, wire.to_kinds[index], wire.to_robots[index])?;
            let load = Load {
                kind: self.kind(index, wire.kinds[index])?,
                priority: self.priority(index, wire.priorities[index])?,
                about: wire.about_robots[index],
                bytes: wire.sizes[index],
            };
            Ok((to, MessageRef { number: wire.messages[index], load }))
        };
        (0..expected).map(message).collect()
    }

    fn kind(self, index: usize, found: u8) -> Result<MessageKind, ConvertError> {
        let kind = MessageKind::ALL.into_iter().find(|&kind| kind_number(kind) == found);
        kind.ok_or(ConvertError::Alternative {
            at: self.at_entry("kinds", index),
            found,
            allowed: "0 observation, 1 intent, 2 heartbeat, 3 sync request, 4 sync reply, 5 mission status, 6 verdicts, 7 orders, 8 zones, 9 marks",
        })
    }

    fn priority(self, index: usize, found: u8) -> Result<Priority, ConvertError> {
        let priority = Priority::ALL.into_iter().find(|&priority| priority_number(priority) == found);
        priority.ok_or(ConvertError::Alternative {
            at: self.at_entry("priorities", index),
            found,
            allowed: "0 find, 1 plan, 2 no find, 3 other",
        })
    }

    fn audience(self, index: usize, found: u8, number: u16) -> Result<Audience, ConvertError> {
        match found {
            0 => Ok(Audience::All),
            1 => {
                let robot = robot(self.at_entry("to_robots", index), number)?;
                Ok(Audience::One(Participant::Robot(robot)))
            }
            2 => Ok(Audience::One(Participant::Coordinator)),
            _ => Err(ConvertError::Alternative {
                at: self.at_entry("to_kinds", index),
                found,
                allowed: "0 all, 1 robot, 2 coordinator",
            }),
        }
    }

    pub(super) fn sensed(self, wire: &wire::Sensed) -> Result<Sensed, ConvertError> {
        self.version(wire.version)?;
        Ok(Sensed {
            robot: robot(self.at("robot"), wire.robot)?,
            time_ns: wire.time_ns,
            from: self.cell(self.at("cell"), wire.cell)?,
            readings: self.readings(&wire.cells, &wire.values, &wire.variances)?,
        })
    }
}

const fn kind_number(kind: MessageKind) -> u8 {
    match kind {
        MessageKind::Observation => 0,
        MessageKind::Intent => 1,
        MessageKind::Heartbeat => 2,
        MessageKind::SyncRequest => 3,
        MessageKind::SyncReply => 4,
        MessageKind::MissionStatus => 5,
        MessageKind::Verdicts => 6,
        MessageKind::Orders => 7,
        MessageKind::Zones => 8,
        MessageKind::Marks => 9,
    }
}

const fn priority_number(priority: Priority) -> u8 {
    match priority {
        Priority::Find => 0,
        Priority::Intent => 1,
        Priority::Observation => 2,
        Priority::Other => 3,
    }
}

const fn audience_numbers(to: Audience) -> (u8, u16) {
    match to {
        Audience::All => (0, 0),
        Audience::One(Participant::Robot(robot)) => (1, robot.number()),
        Audience::One(Participant::Coordinator) => (2, 0),
    }
}
