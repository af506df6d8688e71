//! A participant driven by the simulator, event by event, in simulated time.
//!
//! Messages go from peer to peer as in the field. The simulator only determines when each arrives, by its number, so
//! that a run over the network is the same run as in one process.

use std::collections::BTreeMap;
use std::time::Duration;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Mission, Topic};
use dragnet_proto::message::Message;
use dragnet_proto::radio::Load;
use dragnet_proto::state_machine::{Effects, Event, StateMachine};
use dragnet_proto::step::{MessageRef, Step, StepEvent, StepReply};
use dragnet_scenario::participant::Participant;
use dragnet_scenario::time::MissionTime;
use dragnet_search::evidence::Digest;
use zenoh::Session;
use zenoh::handlers::FifoChannelHandler;
use zenoh::query::{Query, Queryable};

use crate::RuntimeError;
use crate::link::{Incoming, Link};
use crate::log_limit::{Kind, Teller};

/// Time limit for a participant, or for a message in transit: wall-clock time.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A participant that is driven by the simulator.
pub struct LockstepNode<'a> {
    link: Link,
    codec: Codec,
    steps: Queryable<FifoChannelHandler<Query>>,
    machine: &'a mut dyn StateMachine,
    team: Vec<Participant>,
    /// Messages that have arrived before their simulated time.
    messages: BTreeMap<(Participant, u64), Message>,
    /// Number of published messages.
    published: u64,
    teller: Teller,
}

impl<'a> LockstepNode<'a> {
    /// Connects a state machine to a session. `team` is all participants.
    ///
    /// # Errors
    /// If Zenoh fails.
    pub async fn new(
        session: Session,
        mission: Mission,
        me: Participant,
        codec: Codec,
        team: Vec<Participant>,
        machine: &'a mut dyn StateMachine,
    ) -> Result<Self, RuntimeError> {
        let key = mission.key(Topic::SimStep(me)).to_string();
        let steps =
            session.declare_queryable(key).await.map_err(RuntimeError::zenoh("offer to be driven"))?;
        let mut link = Link::join(session, mission, me, codec.clone()).await?;
        link.announce().await?;
        let (messages, teller) = (BTreeMap::new(), Teller::default());
        Ok(Self { link, codec, steps, machine, team, messages, published: 0, teller })
    }

    /// Handles the simulator's events until the mission is over.
    ///
    /// # Errors
    /// If the state machine or the network fails. The simulator has been informed in that case.
    pub async fn serve(mut self) -> Result<(), RuntimeError> {
        loop {
            let query = tokio::select! {
                query = self.steps.recv_async() => query.map_err(RuntimeError::zenoh("receive from the simulator"))?,
                () = self.teller.settle() => continue,
            };
            let bytes = query.payload().map(|payload| payload.to_bytes().into_owned()).unwrap_or_default();
            let outcome = match self.codec.decode_step(&bytes) {
                Ok(Step { event: StepEvent::Finish, .. }) => {
                    return answer(&query, &self.report(Digest(0))).await;
                }
                Ok(step) => self.step(step).await,
                Err(error) => {
                    Err(RuntimeError::Participant { participant: self.link.me(), reason: error.to_string() })
                }
            };
            match outcome {
                Ok(reply) => answer(&query, &reply).await?,
                Err(error) => {
                    let reply = StepReply { error: error.to_string(), ..self.report(Digest(0)) };
                    answer(&query, &reply).await?;
                    return Err(error);
                }
            }
        }
    }

    async fn step(&mut self, step: Step) -> Result<StepReply, RuntimeError> {
        let StepEvent::Event(event) = step.event else {
            return Ok(self.report(self.machine.digest()));
        };
        if event == Event::Start {
            self.await_team().await?;
        }
        let event = match event.into_message() {
            Ok((from, number)) => Event::Received { from, message: self.message(from, number).await? },
            Err(event) => event,
        };
        let effects = self.machine.handle(MissionTime(step.time_ns), event)?;
        self.carry_out(effects).await
    }

    /// A participant that is there has subscribed before; so every publication is received.
    async fn await_team(&mut self) -> Result<(), RuntimeError> {
        let mut others = Vec::new();
        self.link.wait_for(&self.team, PATIENCE, |received| others.push(received)).await?;
        others.into_iter().try_for_each(|received| self.keep(received))
    }

    /// Waits for a published message. A copy is kept, since it may be delivered twice.
    async fn message(&mut self, sender: Participant, number: u64) -> Result<Message, RuntimeError> {
        loop {
            if let Some(message) = self.messages.get(&(sender, number)) {
                return Ok(message.clone());
            }
            let absent = || RuntimeError::Absent {
                participant: format!("message {number} of {sender}"),
                waited: PATIENCE,
            };
            let received = tokio::time::timeout(PATIENCE, self.link.receive()).await.map_err(|_| absent())?;
            self.keep(received.ok_or_else(absent)?)?;
        }
    }

    fn keep(&mut self, received: Incoming) -> Result<(), RuntimeError> {
        match received {
            Incoming::Message { from, number, message, .. } => {
                self.messages.insert((from, number), message);
                Ok(())
            }
            Incoming::Rejected { from, key, reason } => {
                let text = format_args!("rejected a message under {key}: {reason}");
                self.teller.warn(Kind::NoMessage, from, text);
                Ok(())
            }
            Incoming::Came(..) | Incoming::OtherScenario(..) => Ok(()),
            Incoming::Left(participant, _) => {
                let reason = "it left before the mission was over".to_owned();
                if self.team.contains(&participant) {
                    Err(RuntimeError::Participant { participant, reason })
                } else {
                    Ok(())
                }
            }
        }
    }

    async fn carry_out(&mut self, effects: Effects<Message>) -> Result<StepReply, RuntimeError> {
        let mut published = Vec::with_capacity(effects.published.len());
        for (to, message) in &effects.published {
            let number = self.published;
            self.published += 1;
            let bytes = self.link.publish(number, *to, message).await?;
            published.push((*to, MessageRef { number, load: Load::new(message, bytes) }));
        }
        let Effects { route, wake_at, activity, decision, .. } = effects;
        let effects = Effects { published, route, wake_at, activity, decision, ..Effects::default() };
        Ok(StepReply { effects, ..self.report(Digest(0)) })
    }

    fn report(&self, digest: Digest) -> StepReply {
        let (effects, observations) = (Effects::default(), self.machine.observations());
        StepReply { effects, digest, observations, error: String::new() }
    }
}

async fn answer(query: &Query, reply: &StepReply) -> Result<(), RuntimeError> {
    query
        .reply(query.key_expr().clone(), convert::encode_step_reply(reply))
        .express(true)
        .await
        .map_err(RuntimeError::zenoh("answer the simulator"))
}
