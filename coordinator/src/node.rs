//! The coordinator as a state machine: the mission, and its recording.

use std::collections::BTreeMap;

use dragnet_proto::message::Message;
use dragnet_proto::state_machine::{Effects, Event, Left, ParticipantError, Standstill, StateMachine};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Cell;
use dragnet_search::evidence::Digest;
use dragnet_search::object_position::ObjectPosition;
use dragnet_search::observation::RobotId;

use crate::RecordingError;
use crate::finds::FindCounts;
use crate::liveness::named;
use crate::mission::{Mission, Outcome, Record};
use crate::record::{ENDED, FINDS, REST_OF_WORLD, Recorder, SOUGHT, SUCCESS};
use crate::recording::{Notify, Recording};

/// A mission and its recording.
///
/// A recording that fails does not stop the mission: see [`crate::recording`]. If not everything could be recorded,
/// [`CoordinatorNode::finish`] returns an error.
pub struct CoordinatorNode {
    mission: Mission,
    recording: Option<Recording>,
    listeners: Vec<Listener>,
    /// The time of the latest event.
    latest: MissionTime,
}

/// A function that is called with each new record and its mission time.
pub type Listener = Box<dyn FnMut(MissionTime, &Record) + Send>;

impl CoordinatorNode {
    /// A mission, recorded if there is a recorder.
    #[must_use]
    pub fn new(mission: Mission, recorder: Option<Recorder>) -> Self {
        Self {
            mission,
            recording: recorder.map(Recording::new),
            listeners: Vec::new(),
            latest: MissionTime::START,
        }
    }

    /// Adds a listener, if there is one, which is called with each record from now on.
    #[must_use]
    pub fn with_listener(mut self, listener: Option<Listener>) -> Self {
        self.listeners.extend(listener);
        self
    }

    /// Adds a listener for notices about the recording.
    #[must_use]
    pub fn notifying(mut self, notify: Notify) -> Self {
        if let Some(recording) = &mut self.recording {
            recording.notify(notify);
        }
        self
    }

    /// The mission.
    #[must_use]
    pub const fn mission(&self) -> &Mission {
        &self.mission
    }

    /// Why the recording currently fails, if it does.
    #[must_use]
    pub fn failure(&self) -> Option<&RecordingError> {
        self.recording.as_ref()?.failure()
    }

    /// Ends the mission and its recording. To be called after the last message: a team that has finished searching
    /// still exchanges messages until all have the same observations.
    ///
    /// # Errors
    /// If not everything could be recorded.
    pub fn finish(
        mut self,
        now: MissionTime,
        mut summary: BTreeMap<String, String>,
    ) -> Result<Mission, RecordingError> {
        let now = now.max(self.latest);
        let last = self.mission.finish(now);
        self.record(now, &last.records);
        summary.extend(self.rejected());
        summary.extend(self.decided());
        summary.extend(self.sought());
        summary.extend(self.ended().map(|ended| (ENDED.to_owned(), ended)));
        if let Some(recording) = self.recording {
            recording.finish(now, &self.mission, summary)?;
        }
        Ok(self.mission)
    }

    /// What the operator has decided about finds, for the end of the recording.
    fn decided(&self) -> Option<(String, String)> {
        let counts = FindCounts::of(&self.mission.finds());
        counts.has_verdicts().then(|| (FINDS.to_owned(), counts.to_string()))
    }

    /// Who has ended the mission, if the operator has: `by the operator, without robots 1, 3`.
    #[must_use]
    pub fn ended(&self) -> Option<String> {
        let awaited = self.mission.awaited().filter(|_| self.mission.is_over())?;
        let without =
            if awaited.is_empty() { String::new() } else { format!(", without {}", named(&awaited)) };
        Some(format!("by the operator{without}"))
    }

    /// Where the subjects are, for the end of the recording.
    fn sought(&self) -> impl Iterator<Item = (String, String)> {
        let facts = self.mission.standing().map(|it| {
            let numbers = [(SUCCESS, it.found.to_string()), (REST_OF_WORLD, it.rest_of_world.to_string())];
            numbers.into_iter().chain([(SOUGHT, it.to_string())])
        });
        facts.into_iter().flatten().map(|(name, value)| (name.to_owned(), value))
    }

    /// Rejections and their numbers, for the end of the recording: one entry for each sender and reason.
    fn rejected(&self) -> impl Iterator<Item = (String, String)> + '_ {
        let rejected = self.mission.replica().rejected();
        rejected.iter().map(|(what, count)| (format!("{what}"), format!("{count} times")))
    }

    /// Writes the records of an outcome; returns its effects.
    fn recorded(&mut self, now: MissionTime, Outcome { effects, records }: Outcome) -> Effects<Message> {
        self.record(now, &records);
        effects
    }

    /// Writes the records.
    fn record(&mut self, now: MissionTime, records: &[Record]) {
        self.latest = self.latest.max(now);
        for record in records {
            for listener in &mut self.listeners {
                listener(now, record);
            }
            if let Some(recording) = &mut self.recording {
                recording.record(now, record);
            }
        }
        if let Some(recording) = &mut self.recording {
            recording.tick(now, &self.mission);
        }
    }
}

impl StateMachine for CoordinatorNode {
    /// It releases nothing, so that it repeats by itself all that is asked for.
    fn handle(
        &mut self,
        now: MissionTime,
        event: Event<Message>,
    ) -> Result<Effects<Message>, ParticipantError> {
        let outcome = self.mission.react(now, event);
        Ok(self.recorded(now, outcome))
    }

    fn receive(
        &mut self,
        now: MissionTime,
        from: Participant,
        message: &Message,
    ) -> Result<Effects<Message>, ParticipantError> {
        let outcome = self.mission.receive(now, from, message);
        Ok(self.recorded(now, outcome))
    }

    fn position(&self, cell: Cell) -> Option<&ObjectPosition> {
        self.mission.replica().knowledge().positions().of(cell)
    }

    fn is_over(&self) -> bool {
        self.mission.is_over()
    }

    fn awaited(&self) -> Option<Vec<RobotId>> {
        self.mission.awaited()
    }

    fn cell_of(&self, robot: RobotId) -> Option<Cell> {
        self.mission.tracks().find(|&(it, _)| it == robot)?.1.pose.map(|(cell, _)| cell)
    }

    fn standstills(&self) -> Vec<Standstill> {
        self.mission.standstills().collect()
    }

    fn left(&self) -> Option<Left> {
        Some(self.mission.left())
    }

    fn digest(&self) -> Digest {
        self.mission.belief().digest()
    }

    fn observations(&self) -> u64 {
        self.mission.replica().log().len()
    }
}
