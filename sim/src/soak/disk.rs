//! A robot's disk, as the journal of a real robot uses it.

use std::ops::Range;
use std::sync::Arc;

use dragnet_proto::message::{Message, SyncReply, SyncRequest};
use dragnet_proto::state_machine::Effects;
use dragnet_scenario::time::MissionTime;
use dragnet_search::observation::Observation;

/// What a robot was to keep, in order.
pub(super) struct Disk {
    full: Range<MissionTime>,
    written: Vec<Arc<Observation>>,
    /// What is in the robot's memory alone.
    waiting: Vec<Arc<Observation>>,
}

impl Disk {
    /// One that takes nothing for some time, if it ever does not.
    pub(super) fn new(full: Option<Range<MissionTime>>) -> Self {
        let never = MissionTime::START..MissionTime::START;
        Self { full: full.unwrap_or(never), written: Vec::new(), waiting: Vec::new() }
    }

    /// What is kept is written before anything is said.
    pub(super) fn keep(&mut self, now: MissionTime, effects: &Effects<Message>) {
        self.waiting.extend(effects.kept.iter().cloned());
        if !effects.published.is_empty() && !self.full.contains(&now) {
            self.written.append(&mut self.waiting);
        }
    }

    /// Whether all that was to be kept is written.
    pub(super) fn is_level(&self) -> bool {
        self.waiting.is_empty()
    }

    /// What its robot answers who asks for what it has released.
    pub(super) fn answer(&self, request: SyncRequest) -> Message {
        let asked = |observation: &&Arc<Observation>| {
            observation.origin == request.of && observation.sequence >= request.first
        };
        let found = self.written.iter().filter(asked).take(SyncReply::MAX_OBSERVATIONS);
        Message::SyncReply(SyncReply { observations: found.cloned().collect() })
    }

    /// Its robot starts again: so many observations are lost.
    pub(super) fn restart(&mut self) -> usize {
        std::mem::take(&mut self.waiting).len()
    }

    /// It is another disk.
    pub(super) fn clear(&mut self) {
        self.written.clear();
        self.waiting.clear();
    }

    pub(super) fn written(&self) -> &[Arc<Observation>] {
        &self.written
    }
}
