//! A participant's link to the network: publishes and receives messages.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::{Duration, Instant};

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Key, Mission, Selection, Topic};
use dragnet_proto::message::{Audience, Message};
use dragnet_proto::sender::{Envelope, Process};
use dragnet_scenario::participant::Participant;
use dragnet_search::cell::Grid;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::sample::{Sample, SampleKind};

use crate::RuntimeError;
use crate::waiting::{self, Arrival, Inlet, Outlet, Raw};

pub use crate::waiting::Sender;

/// Maximum number of known processes of one participant.
const MOST_PROCESSES: usize = 16;

/// The link of a participant, or of a listener ([`ReceiveOnly`]), to the network.
pub struct Link<Me = Participant> {
    session: Session,
    mission: Mission,
    me: Me,
    codec: Codec,
    waiting: Outlet,
    present: BTreeSet<Participant>,
    /// The other processes of each participant, including this one, in the order of their arrival.
    processes: BTreeMap<Participant, Vec<u64>>,
    identity: u64,
    started: Instant,
    /// Whether this process takes precedence over all others with its number.
    takes_over: bool,
    /// The liveliness token of this participant.
    token: Option<LivelinessToken>,
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
    /// A message of another process of this participant.
    Rival(Process),
    /// A participant's process has joined.
    Came(Participant, u64),
    /// The last process of a participant has left.
    Left(Participant, u64),
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
        let to_all = [Selection::Observations, Selection::Intents, Selection::Heartbeats];
        let to_me = participant.map(|participant| {
            [Selection::SyncRequestsTo(participant), Selection::SyncRepliesTo(participant)]
        });
        let coordinator = [Topic::Status, Topic::ByHand].map(|topic| mission.key(topic).to_string());
        let expressions = to_all
            .into_iter()
            .chain(to_me.into_iter().flatten())
            .map(|selection| mission.expression(selection));
        for expression in expressions.chain(coordinator) {
            let (inlet, what) = (inlet.clone(), format!("subscribe to {expression}"));
            session
                .declare_subscriber(expression)
                .callback(move |sample| put_message(&inlet, &sample, participant, identity, codec))
                .background()
                .await
                .map_err(RuntimeError::zenoh(what))?;
        }
        session
            .liveliness()
            .declare_subscriber(mission.expression(Selection::Alive))
            .history(true)
            .callback(move |sample| put_presence(&inlet, &sample, identity, codec))
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
            processes: BTreeMap::new(),
            identity,
            started: Instant::now(),
            takes_over: false,
            token: None,
        })
    }

    fn participant(&self) -> Option<Participant> {
        self.me.into()
    }

    /// The next incoming message or event; `None` once the session is closed.
    pub async fn receive(&mut self) -> Option<Incoming> {
        loop {
            match self.waiting.take().await? {
                Arrival::Message { from, raw } => {
                    return Some(read(raw, from, self.participant(), self.codec));
                }
                Arrival::Presence { participant, identity, is_here: true } => {
                    if self.come(participant, identity) {
                        return Some(Incoming::Came(participant, identity));
                    }
                }
                Arrival::Presence { participant, identity, is_here: false } => {
                    return Some(match self.leave(participant, identity) {
                        // The participant is still there: its remaining process counts as joined, for those that knew
                        // the other one.
                        Some(left) => Incoming::Came(participant, left),
                        None => Incoming::Left(participant, identity),
                    });
                }
            }
        }
    }

    /// A process has joined; returns whether it is known from now on. More processes of one participant are not
    /// credible.
    fn come(&mut self, participant: Participant, identity: u64) -> bool {
        let processes = self.processes.entry(participant).or_default();
        if !processes.contains(&identity) {
            if processes.len() >= MOST_PROCESSES {
                return false;
            }
            processes.push(identity);
        }
        if self.participant() != Some(participant) {
            self.present.insert(participant);
        }
        true
    }

    /// A process has left; returns the first remaining one of its participant.
    fn leave(&mut self, participant: Participant, identity: u64) -> Option<u64> {
        let processes = self.processes.get_mut(&participant)?;
        processes.retain(|&process| process != identity);
        let left = processes.first().copied();
        if left.is_none() {
            self.processes.remove(&participant);
            self.present.remove(&participant);
        }
        left
    }

    /// Senders of messages that were dropped because too many were waiting, since the last call, and their numbers.
    /// They are repaired later like any lost message.
    pub(crate) fn dropped(&self) -> BTreeMap<Sender, u64> {
        self.waiting.dropped()
    }

    /// The sender for counting: all participants outside the team count as one.
    pub(crate) fn sender(&self, participant: Participant) -> Sender {
        sender(Some(participant), self.codec)
    }

    /// The other participants that are present.
    #[must_use]
    pub const fn present(&self) -> &BTreeSet<Participant> {
        &self.present
    }

    /// The other processes of a participant that are present, in the order of their arrival.
    #[must_use]
    pub fn processes(&self, participant: Participant) -> &[u64] {
        self.processes.get(&participant).map_or(&[], Vec::as_slice)
    }

    /// Participants that have several processes, including this one; for example if two robots are configured with one
    /// number. The token of a dead process remains for a while beside that of the process that replaces it.
    #[must_use]
    pub fn doubled(&self) -> BTreeSet<Participant> {
        let own = |participant| usize::from(self.participant() == Some(participant) && self.token.is_some());
        let several =
            self.processes.iter().filter(|(participant, others)| others.len() + own(**participant) > 1);
        several.map(|(&participant, _)| participant).collect()
    }

    /// This process.
    #[must_use]
    pub fn process(&self) -> Process {
        let age_ms = u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX);
        Process { identity: self.identity, age_ms: if self.takes_over { u64::MAX } else { age_ms } }
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

    /// Announces this participant to the others by its liveliness token.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn announce(&mut self) -> Result<(), RuntimeError> {
        let key =
            self.mission.key(Topic::Alive { participant: self.me, identity: self.identity }).to_string();
        let token = self.session.liveliness().declare_token(key).await;
        self.token = Some(token.map_err(RuntimeError::zenoh("say who is there"))?);
        Ok(())
    }

    /// Publishes a message with this sequence number.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn publish(
        &self,
        number: u64,
        audience: Audience,
        message: &Message,
    ) -> Result<(), RuntimeError> {
        let Some(topic) = Topic::of(message.kind(), self.me, audience) else {
            let reason = format!("a {:?} has no place to go to {audience:?}", message.kind());
            return Err(RuntimeError::Participant { participant: self.me, reason });
        };
        self.session
            .put(self.mission.key(topic).to_string(), convert::encode(message))
            .attachment(ZBytes::from(Envelope { number, process: self.process() }.encode()))
            .congestion_control(CongestionControl::Block)
            .express(true)
            .await
            .map_err(RuntimeError::zenoh("publish"))
    }

    /// Gives this process precedence over all others with its number.
    pub const fn take_over(&mut self) {
        self.takes_over = true;
    }
}

/// Queues a message, unless it is this process's own. Decoding is left to the receiver, so that dropped messages cost
/// nothing.
fn put_message(inlet: &Inlet, sample: &Sample, me: Option<Participant>, own: u64, codec: Codec) {
    let key = sample.key_expr().as_str();
    let from = key.parse().ok().and_then(|key: Key| key.topic.speech()).map(|(_, from)| from);
    let raw = raw(sample);
    let is_own = from.is_some() && from == me && raw.envelope.is_none_or(|it| it.process.identity == own);
    if !is_own {
        inlet.message(sender(from, codec), raw);
    }
}

/// Queues a process's arrival or departure. A token of a participant outside the team is treated like a message, and
/// rejected.
fn put_presence(inlet: &Inlet, sample: &Sample, own: u64, codec: Codec) {
    let key: Option<Key> = sample.key_expr().as_str().parse().ok();
    match key.map(|key| key.topic) {
        Some(Topic::Alive { identity, .. }) if identity == own => {}
        Some(Topic::Alive { participant, identity }) if codec.knows(participant) => {
            inlet.presence(participant, identity, sample.kind() == SampleKind::Put);
        }
        _ => inlet.message(Sender::Stranger, raw(sample)),
    }
}

fn sender(from: Option<Participant>, codec: Codec) -> Sender {
    from.filter(|&from| codec.knows(from)).map_or(Sender::Stranger, Sender::Known)
}

/// A copy: Zenoh's buffer may be much larger than the message.
fn raw(sample: &Sample) -> Raw {
    let envelope = sample.attachment().and_then(|bytes| Envelope::decode(&bytes.to_bytes()));
    let key = sample.key_expr().as_str().to_owned();
    Raw { key, payload: sample.payload().to_bytes().into_owned(), envelope }
}

/// Decodes a message, or returns why it is rejected.
fn read(raw: Raw, from: Sender, me: Option<Participant>, codec: Codec) -> Incoming {
    let refused = |key: String, reason: String| Incoming::Rejected { from, key, reason };
    let key: Key = match raw.key.parse() {
        Ok(key) => key,
        Err(error) => return refused(raw.key, error.to_string()),
    };
    let Some((kind, from)) = key.topic.speech() else {
        let reason = match key.topic {
            Topic::Alive { participant, .. } => format!("{participant} is not in the team"),
            _ => "no message belongs here".to_owned(),
        };
        return refused(raw.key, reason);
    };
    let Some(Envelope { number, process }) = raw.envelope else {
        return refused(raw.key, "without number, identity and age as attachment, 24 bytes".to_owned());
    };
    if me == Some(from) {
        return Incoming::Rival(process);
    }
    let message = codec.decode(kind, &raw.payload);
    match message.and_then(|message| convert::check_sender(&message, from).map(|()| message)) {
        Ok(message) => Incoming::Message { from, identity: process.identity, number, message },
        Err(error) => refused(raw.key, error.to_string()),
    }
}
