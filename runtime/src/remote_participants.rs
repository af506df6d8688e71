//! Participants of a simulation on other sessions; each is a [`crate::lockstep::LockstepNode`].

use std::time::Duration;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Mission, Topic};
use dragnet_proto::state_machine::{Effects, Event};
use dragnet_proto::step::{MessageRef, Step, StepEvent, StepReply};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::cell::Grid;
use dragnet_search::evidence::Digest;
use dragnet_sim::participants::Participants;
use zenoh::{Session, Wait};

use crate::RuntimeError;
use crate::lockstep::PATIENCE;

/// Participants of a team, driven by queries over Zenoh. Calls block.
pub struct RemoteParticipants {
    session: Session,
    mission: Mission,
    codec: Codec,
    /// Called while waiting for an answer; returns an error if no answer can come.
    watch: Box<dyn FnMut() -> Result<(), RuntimeError>>,
}

/// Time between checks whether a silent participant is still there.
const CHECK_PERIOD: Duration = Duration::from_millis(200);
/// Time after which a query without a receiver is sent again: a queryable may take a moment to be known.
const RETRY: Duration = Duration::from_millis(20);

impl RemoteParticipants {
    /// Connects to participants by this session. `watch` is called while waiting for an answer; it returns an error if
    /// no answer can come.
    #[must_use]
    pub fn new(
        session: Session,
        mission: Mission,
        grid: Grid,
        watch: Box<dyn FnMut() -> Result<(), RuntimeError>>,
    ) -> Self {
        Self { session, mission, codec: Codec::new(grid), watch }
    }

    /// Number of observations of a participant at the end.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn observations(&mut self, participant: Participant) -> Result<u64, RuntimeError> {
        Ok(self.ask(participant, MissionTime::START, StepEvent::Report)?.observations)
    }

    /// Informs a participant that the mission is over.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn dismiss(&mut self, participant: Participant) -> Result<(), RuntimeError> {
        self.ask(participant, MissionTime::START, StepEvent::Finish).map(|_| ())
    }

    fn ask(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: StepEvent,
    ) -> Result<StepReply, RuntimeError> {
        let step = convert::encode_step(&Step { time_ns: now.0, event })
            .map_err(|error| RuntimeError::Unsupported(error.to_string()))?;
        let key = self.mission.key(Topic::SimStep(participant)).to_string();
        let mut waited = Duration::ZERO;
        while waited < PATIENCE {
            if let Some(bytes) = self.query(&key, &step)? {
                let failed = |reason| RuntimeError::Participant { participant, reason };
                let reply =
                    self.codec.decode_step_reply(&bytes).map_err(|error| failed(error.to_string()))?;
                return if reply.error.is_empty() { Ok(reply) } else { Err(failed(reply.error)) };
            }
            (self.watch)()?;
            std::thread::sleep(RETRY);
            waited += RETRY;
        }
        Err(RuntimeError::Absent { participant: participant.to_string(), waited })
    }

    /// The answer; `None` if the query reached no participant.
    fn query(&mut self, key: &str, step: &[u8]) -> Result<Option<Vec<u8>>, RuntimeError> {
        let replies = self
            .session
            .get(key)
            .payload(step)
            .express(true)
            .timeout(2 * PATIENCE)
            .wait()
            .map_err(RuntimeError::zenoh("ask a participant"))?;
        loop {
            match replies.recv_timeout(CHECK_PERIOD) {
                Ok(Some(reply)) => {
                    return match reply.into_result() {
                        Ok(sample) => Ok(Some(sample.payload().to_bytes().into_owned())),
                        Err(error) => {
                            let reason = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned();
                            Err(RuntimeError::Zenoh { what: format!("get an answer from {key}"), reason })
                        }
                    };
                }
                Ok(None) => (self.watch)()?,
                Err(_) => return Ok(None),
            }
        }
    }
}

impl Participants for RemoteParticipants {
    type MessageRef = MessageRef;
    type Error = RuntimeError;

    fn step(
        &mut self,
        participant: Participant,
        now: MissionTime,
        event: Event<MessageRef>,
    ) -> Result<Effects<MessageRef>, RuntimeError> {
        let event = match event.into_message() {
            Ok((from, message)) => Event::Received { from, message: message.number },
            Err(event) => event,
        };
        Ok(self.ask(participant, now, StepEvent::Event(event))?.effects)
    }

    fn digest(&mut self, participant: Participant, now: MissionTime) -> Result<Digest, RuntimeError> {
        Ok(self.ask(participant, now, StepEvent::Report)?.digest)
    }
}
