//! A robot's disk, as used by the journal of a real robot.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use dragnet_proto::message::{Message, MessageKind, SyncReply, SyncRequest};
use dragnet_proto::state_machine::Effects;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Observation;

/// A robot's stored observations, in order, and the operator's instructions.
pub(super) struct Disk {
    full: Range<MissionTime>,
    written: Vec<Arc<Observation>>,
    /// The last messages with instructions, by kind.
    instructions: BTreeMap<MessageKind, Message>,
    /// Observations in the robot's memory only.
    waiting: Vec<Arc<Observation>>,
}

impl Disk {
    /// A disk that is full for some time, if given.
    pub(super) fn new(full: Option<Range<MissionTime>>) -> Self {
        let never = MissionTime::START..MissionTime::START;
        Self {
            full: full.unwrap_or(never),
            written: Vec::new(),
            instructions: BTreeMap::new(),
            waiting: Vec::new(),
        }
    }

    /// Observations and instructions are written before anything is published.
    pub(super) fn keep(&mut self, now: MissionTime, effects: &Effects<Message>) {
        self.waiting.extend(effects.kept.iter().cloned());
        if !effects.published.is_empty() && !self.full.contains(&now) {
            self.written.append(&mut self.waiting);
            let messages = effects.published.iter().map(|(_, message)| message);
            let instructions = messages.filter(|message| message.instructions().is_some());
            self.instructions.extend(instructions.map(|message| (message.kind(), message.clone())));
        }
    }

    /// Whether everything is written.
    pub(super) fn is_level(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The robot's answer to a request for released observations.
    pub(super) fn answer(&self, request: SyncRequest) -> Message {
        let asked = |observation: &&Arc<Observation>| {
            observation.origin == request.of && observation.sequence >= request.first
        };
        let found = self.written.iter().filter(asked).take(SyncReply::MAX_OBSERVATIONS);
        Message::SyncReply(SyncReply { observations: found.cloned().collect() })
    }

    /// The robot restarts; returns how many observations are lost.
    pub(super) fn restart(&mut self) -> usize {
        std::mem::take(&mut self.waiting).len()
    }

    /// Replaces the disk by an empty one.
    pub(super) fn clear(&mut self) {
        self.written.clear();
        self.instructions.clear();
        self.waiting.clear();
    }

    pub(super) fn written(&self) -> &[Arc<Observation>] {
        &self.written
    }

    pub(super) fn instructions(&self) -> impl Iterator<Item = &Message> {
        self.instructions.values()
    }
}
