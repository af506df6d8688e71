//! A robot's disk, as the journal of a real robot uses it.

use std::ops::Range;
use std::sync::Arc;

use dragnet_proto::message::Message;
use dragnet_proto::participant::Reaction;
use dragnet_proto::time::MissionTime;
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
    pub(super) fn keep(&mut self, now: MissionTime, reaction: &Reaction<Message>) {
        self.waiting.extend(reaction.kept.iter().cloned());
        if !reaction.published.is_empty() && !self.full.contains(&now) {
            self.written.append(&mut self.waiting);
        }
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
