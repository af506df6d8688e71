//! A participant's link to the network: publishes and receives messages.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::{Duration, Instant};

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Key, Mission, Selection, Topic};
use dragnet_proto::message::{Audience, Message};
use dragnet_proto::scenario_digest::{Difference, ScenarioDigest};
use dragnet_proto::sender::{Claim, Envelope};
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Grid;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::sample::{Sample, SampleKind};

use crate::RuntimeError;
use crate::tokens::{Change, Tokens};
use crate::waiting::{self, Arrival, Inlet, Outlet, Raw};

pub use crate::waiting::Sender;

/// The link of a participant, or of a listener ([`ReceiveOnly`]), to the network.
pub struct Link<Me = Participant> {
    session: Session,
    mission: Mission,
    me: Me,
    codec: Codec,
    waiting: Outlet,
    present: BTreeSet<Participant>,
    /// The liveliness tokens of the other processes of each participant, including this one.
    tokens: Tokens,
    claim: Claim,
    started: Instant,
    /// The liveliness token of this participant.
    token: Option<LivelinessToken>,
    /// The scenario of this process, if it tells it and compares others with it.
    scenario: Option<ScenarioDigest>,
    /// The liveliness token that tells it.
    scenario_token: Option<LivelinessToken>,
    /// The scenarios that others told last.
    scenarios: BTreeMap<Participant, ScenarioDigest>,
}

/// The owner of a link that only listens: it receives the messages that are published to all, and publishes nothing.
#[derive(Clone, Copy, Debug)]
pub struct ReceiveOnly;

impl From<ReceiveOnly> for Option<Participant> {
    fn from(_: ReceiveOnly) -> Self {
        None
    }
}

/// An incoming message or event.
#[derive(Debug)]
pub enum Incoming {
    /// A message, checked.
    Message {
        /// The sender.
        from: Participant,
        /// Its process.
        identity: u64,
        /// Its number among the sender's messages.
        number: u64,
        /// The content.
        message: Message,
    },
    /// An invalid message under a key of the mission, or a message whose sender is not that of the key.
    Rejected {
        /// The sender, by the key.
        from: Sender,
        /// The key.
        key: String,
        /// The reason.
        reason: String,
    },
    /// A participant's process has joined, or is from now on the one that goes on.
    Came(Participant, u64),
    /// The last process of a participant has left.
    Left(Participant, u64),
    /// A participant tells another scenario than that of this process: how it differs.
    OtherScenario(Participant, Difference),
}

impl<Me: Copy + Into<Option<Participant>>> Link<Me> {
    /// Subscribes to all messages for a participant, without announcing the participant: see [`Link::announce`].
    ///
    /// # Errors
    /// If Zenoh fails.
    pub async fn join(
        session: Session,
        mission: Mission,
        me: Me,
        codec: Codec,
    ) -> Result<Self, RuntimeError> {
        let participant = me.into();
        let (inlet, waiting) = waiting::waiting(waiting::MOST_BYTES);
        let identity = RandomState::new().build_hasher().finish();
        let to_all = [
            Selection::Observations,
            Selection::Intents,
            Selection::Heartbeats,
            Selection::Verdicts,
            Selection::Orders,
            Selection::Zones,
            Selection::Marks,
        ];
        let to_me = participant.map(|participant| {
            [Selection::SyncRequestsTo(participant), Selection::SyncRepliesTo(participant)]
        });
        let coordinator = mission.key(Topic::Status).to_string();
        let expressions = to_all
            .into_iter()
            .chain(to_me.into_iter().flatten())
            .map(|selection| mission.expression(selection));
        for expression in expressions.chain([coordinator]) {
            let (inlet, what) = (inlet.clone(), format!("subscribe to {expression}"));
            let codec = codec.clone();
            session
                .declare_subscriber(expression)
                .callback(move |sample| put_message(&inlet, &sample, participant, &codec))
                .background()
                .await
                .map_err(RuntimeError::zenoh(what))?;
        }
        let (scenarios, team) = (inlet.clone(), codec.clone());
        session
            .liveliness()
            .declare_subscriber(mission.expression(Selection::Scenarios))
            .history(true)
            .callback(move |sample| put_scenario(&scenarios, &sample, &team))
            .background()
            .await
            .map_err(RuntimeError::zenoh("watch the scenarios of others"))?;
        let of_presence = codec.clone();
        session
            .liveliness()
            .declare_subscriber(mission.expression(Selection::Alive))
            .history(true)
            .callback(move |sample| put_presence(&inlet, &sample, identity, &of_presence))
            .background()
            .await
            .map_err(RuntimeError::zenoh("watch liveliness tokens"))?;
        Ok(Self {
            session,
            mission,
            me,
            codec,
            waiting,
            present: BTreeSet::new(),
            tokens: Tokens::default(),
            claim: Claim { seniority: 0, identity },
            started: Instant::now(),
            token: None,
            scenario: None,
            scenario_token: None,
            scenarios: BTreeMap::new(),
        })
    }

    /// From now on the scenarios that others tell are compared with this one, and the next announcement tells it.
    pub const fn set_scenario(&mut self, digest: ScenarioDigest) {
        self.scenario = Some(digest);
    }

    fn participant(&self) -> Option<Participant> {
        self.me.into()
    }

    /// The next incoming message or event; `None` once the session is closed.
    pub async fn receive(&mut self) -> Option<Incoming> {
        loop {
            match self.waiting.take().await? {
                Arrival::Message { from, raw } => match read(raw, from, &self.codec) {
                    Read::Message(incoming) => return Some(incoming),
                    Read::Scenario(participant, digest) => {
                        if let Some(difference) = self.compared(participant, digest) {
                            return Some(Incoming::OtherScenario(participant, difference));
                        }
                    }
                },
                Arrival::Presence { participant, claim, is_here } => {
                    let change = if is_here { Tokens::come } else { Tokens::leave };
                    let change = change(&mut self.tokens, participant, claim);
                    if let Some(change) = change {
                        return Some(self.changed(participant, change));
                    }
                }
            }
        }
    }

    /// How the scenario of a participant differs, if that is news.
    fn compared(&mut self, participant: Participant, digest: ScenarioDigest) -> Option<Difference> {
        let is_known = self.scenarios.insert(participant, digest) == Some(digest);
        self.scenario.filter(|_| !is_known)?.difference(digest)
    }

    fn changed(&mut self, participant: Participant, change: Change) -> Incoming {
        match change {
            Change::Came(identity) => {
                if self.participant() != Some(participant) {
                    self.present.insert(participant);
                }
                Incoming::Came(participant, identity)
            }
            Change::Left(identity) => {
                self.present.remove(&participant);
                Incoming::Left(participant, identity)
            }
        }
    }

    /// Senders of messages that were dropped because too many were waiting, since the last call, and their numbers.
    /// They are repaired later like any lost message.
    pub(crate) fn dropped(&self) -> BTreeMap<Sender, u64> {
        self.waiting.dropped()
    }

    /// The sender for counting: all participants outside the team count as one.
    pub(crate) fn sender(&self, participant: Participant) -> Sender {
        sender(Some(participant), &self.codec)
    }

    /// The other participants that are present.
    #[must_use]
    pub const fn present(&self) -> &BTreeSet<Participant> {
        &self.present
    }

    /// The claims of the other processes of a participant that are there.
    pub fn claims(&self, participant: Participant) -> impl Iterator<Item = Claim> {
        self.tokens.claims(participant)
    }

    /// The identity of the process of another participant that goes on, as one of several.
    #[must_use]
    pub fn foremost(&self, participant: Participant) -> Option<u64> {
        self.tokens.foremost(participant)
    }

    /// Participants that have several processes, including this one; for example if two robots are configured with one
    /// number. The token of a dead process remains for a while beside that of the process that replaces it.
    #[must_use]
    pub fn doubled(&self) -> BTreeSet<Participant> {
        let own = self.participant().filter(|_| self.token.is_some()).map(|me| (me, self.claim));
        self.tokens.doubled(own)
    }

    /// The claim of this process.
    #[must_use]
    pub const fn claim(&self) -> Claim {
        self.claim
    }

    /// Time since this process joined the network.
    #[must_use]
    pub fn age(&self) -> Duration {
        self.started.elapsed()
    }

    /// The session.
    #[must_use]
    pub const fn session(&self) -> &Session {
        &self.session
    }

    /// The mission.
    #[must_use]
    pub const fn mission(&self) -> &Mission {
        &self.mission
    }

    /// The grid of the mission's map.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.codec.grid()
    }

    /// How its messages are encoded.
    #[must_use]
    pub const fn codec(&self) -> &Codec {
        &self.codec
    }

    /// Whether another participant is present.
    #[must_use]
    pub fn is_present(&self, participant: Participant) -> bool {
        self.present.contains(&participant)
    }

    /// Waits until all of these participants are present. Other incoming messages and events are passed to `others`.
    ///
    /// # Errors
    /// If one does not join in time.
    pub async fn wait_for(
        &mut self,
        expected: &[Participant],
        patience: Duration,
        mut others: impl FnMut(Incoming),
    ) -> Result<(), RuntimeError> {
        let deadline = tokio::time::Instant::now() + patience;
        loop {
            let absent = expected.iter().find(|&&participant| {
                self.participant() != Some(participant) && !self.present.contains(&participant)
            });
            let Some(&absent) = absent else { return Ok(()) };
            match tokio::time::timeout_at(deadline, self.receive()).await {
                Ok(Some(Incoming::Came(..) | Incoming::Left(..))) => {}
                Ok(Some(received)) => others(received),
                Ok(None) | Err(_) => {
                    return Err(RuntimeError::Absent { participant: absent.to_string(), waited: patience });
                }
            }
        }
    }
}

impl Link {
    /// The owner of this link.
    #[must_use]
    pub const fn me(&self) -> Participant {
        self.me
    }

    /// Announces this participant to the others by its liveliness token, and tells its scenario if that is set.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn announce(&mut self) -> Result<(), RuntimeError> {
        if let Some(digest) = self.scenario {
            let key = self.mission.key(Topic::Scenario { participant: self.me, digest }).to_string();
            let token = self.session.liveliness().declare_token(key).await;
            self.scenario_token = Some(token.map_err(RuntimeError::zenoh("tell the scenario"))?);
        }
        self.declare(self.claim).await
    }

    /// The same with a claim that has risen; it does nothing if that is not so.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn rise(&mut self, claim: Claim) -> Result<(), RuntimeError> {
        if claim == self.claim { Ok(()) } else { self.declare(claim).await }
    }

    async fn declare(&mut self, claim: Claim) -> Result<(), RuntimeError> {
        let key = self.mission.key(Topic::Alive { participant: self.me, claim }).to_string();
        let token = self.session.liveliness().declare_token(key).await;
        let token = token.map_err(RuntimeError::zenoh("say who is there"))?;
        self.claim = claim;
        // Only now: a process that has no token counts as gone.
        if let Some(before) = self.token.replace(token) {
            before.undeclare().await.map_err(RuntimeError::zenoh("withdraw its last token"))?;
        }
        Ok(())
    }

    /// Publishes a message with this sequence number; returns its size, bytes.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn publish(
        &self,
        number: u64,
        audience: Audience,
        message: &Message,
    ) -> Result<usize, RuntimeError> {
        let Some(topic) = Topic::of(message.kind(), self.me, audience) else {
            let reason = format!("a {:?} has no place to go to {audience:?}", message.kind());
            return Err(RuntimeError::Participant { participant: self.me, reason });
        };
        let payload = self.codec.encode(message);
        let bytes = payload.len();
        self.session
            .put(self.mission.key(topic).to_string(), payload)
            .attachment(ZBytes::from(Envelope { number, identity: self.claim.identity }.encode()))
            .congestion_control(CongestionControl::Block)
            .express(true)
            .await
            .map(|()| bytes)
            .map_err(RuntimeError::zenoh("publish"))
    }

    /// From the announcement on it goes on instead of all other processes of its number.
    pub const fn take_over(&mut self) {
        self.claim.seniority = Claim::TAKES_OVER;
    }
}

/// Queues a message, unless it is of this participant: its own, or that of another process of its number. Decoding is
/// left to the receiver, so that dropped messages cost nothing.
fn put_message(inlet: &Inlet, sample: &Sample, me: Option<Participant>, codec: &Codec) {
    let key = sample.key_expr().as_str();
    let from = key.parse().ok().and_then(|key: Key| key.topic.speech()).map(|(_, from)| from);
    if from.is_none() || from != me {
        inlet.message(sender(from, codec), raw(sample));
    }
}

/// Queues a process's arrival or departure. A token of a participant outside the team is treated like a message, and
/// rejected.
fn put_presence(inlet: &Inlet, sample: &Sample, own: u64, codec: &Codec) {
    let key: Option<Key> = sample.key_expr().as_str().parse().ok();
    match key.map(|key| key.topic) {
        Some(Topic::Alive { claim, .. }) if claim.identity == own => {}
        Some(Topic::Alive { participant, claim }) if codec.knows(participant) => {
            inlet.presence(participant, claim, sample.kind() == SampleKind::Put);
        }
        _ => inlet.message(Sender::Stranger, raw(sample)),
    }
}

/// Queues what a participant of the team says about its scenario.
fn put_scenario(inlet: &Inlet, sample: &Sample, codec: &Codec) {
    let key: Option<Key> = sample.key_expr().as_str().parse().ok();
    if let Some(Topic::Scenario { participant, .. }) = key.map(|key| key.topic)
        && codec.knows(participant)
        && sample.kind() == SampleKind::Put
    {
        inlet.message(Sender::Known(participant), raw(sample));
    }
}

fn sender(from: Option<Participant>, codec: &Codec) -> Sender {
    from.filter(|&from| codec.knows(from)).map_or(Sender::Stranger, Sender::Known)
}

/// A copy: Zenoh's buffer may be much larger than the message.
fn raw(sample: &Sample) -> Raw {
    let envelope = sample.attachment().and_then(|bytes| Envelope::decode(&bytes.to_bytes()));
    let key = sample.key_expr().as_str().to_owned();
    Raw { key, payload: sample.payload().to_bytes().into_owned(), envelope }
}

/// What a sender has said.
enum Read {
    /// A message, or why it is rejected.
    Message(Incoming),
    /// The scenario of a participant.
    Scenario(Participant, ScenarioDigest),
}

/// Decodes a message or a scenario.
fn read(raw: Raw, from: Sender, codec: &Codec) -> Read {
    let refused = |key: String, reason: String| Read::Message(Incoming::Rejected { from, key, reason });
    let key: Key = match raw.key.parse() {
        Ok(key) => key,
        Err(error) => return refused(raw.key, error.to_string()),
    };
    if let Topic::Scenario { participant, digest } = key.topic {
        return Read::Scenario(participant, digest);
    }
    let Some((kind, from)) = key.topic.speech() else {
        let reason = match key.topic {
            Topic::Alive { participant, .. } => format!("{participant} is not in the team"),
            _ => "no message belongs here".to_owned(),
        };
        return refused(raw.key, reason);
    };
    let Some(Envelope { number, identity }) = raw.envelope else {
        return refused(raw.key, "without number and identity as attachment, 16 bytes".to_owned());
    };
    let message = codec.decode(kind, &raw.payload);
    match message.and_then(|message| convert::check_sender(&message, from).map(|()| message)) {
        Ok(message) => Read::Message(Incoming::Message { from, identity, number, message }),
        Err(error) => refused(raw.key, error.to_string()),
    }
}

#[cfg(test)]
mod tests;
