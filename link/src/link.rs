//! A participant's place on the network: what it says, and what it hears.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Key, Mission, Selection, Topic};
use dragnet_proto::message::{Audience, Message, Participant};
use dragnet_search::cell::Grid;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::sample::{Sample, SampleKind};

use crate::LinkError;
use crate::waiting::{self, Arrival, Inlet, Outlet, Raw};

pub use crate::waiting::Sender;

/// A participant on the network.
pub struct Link {
    session: Session,
    mission: Mission,
    me: Participant,
    codec: Codec,
    waiting: Outlet,
    present: BTreeSet<Participant>,
    /// Says that this participant is there, as long as it is.
    token: Option<LivelinessToken>,
}

/// What a participant hears.
#[derive(Debug)]
pub enum Heard {
    /// A message, checked.
    Message {
        /// Who sent it.
        from: Participant,
        /// Its number among the sender's messages.
        number: u64,
        /// What it says.
        message: Message,
    },
    /// Something under a key of the mission that is no message, or not by whom the key says.
    Refused {
        /// Who sent it, as far as the key tells.
        from: Sender,
        /// The key.
        key: String,
        /// What is wrong.
        reason: String,
    },
    /// Somebody has come.
    Came(Participant),
    /// Somebody has left.
    Left(Participant),
}

impl Link {
    /// Listens to all that concerns a participant. Nobody knows of it before [`Link::announce`].
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn join(
        session: Session,
        mission: Mission,
        me: Participant,
        codec: Codec,
    ) -> Result<Self, LinkError> {
        let (inlet, waiting) = waiting::waiting(waiting::MOST_BYTES);
        let to_all = [Selection::Observations, Selection::Intents, Selection::Heartbeats];
        let to_me = [Selection::LogRequestsTo(me), Selection::LogRepliesTo(me)];
        let coordinator = [Topic::Status, Topic::ByHand].map(|topic| mission.key(topic).to_string());
        let expressions = to_all.iter().chain(&to_me).map(|&selection| mission.expression(selection));
        for expression in expressions.chain(coordinator) {
            let (inlet, what) = (inlet.clone(), format!("subscribe to {expression}"));
            session
                .declare_subscriber(expression)
                .callback(move |sample| put_message(&inlet, &sample, me, codec))
                .background()
                .await
                .map_err(LinkError::zenoh(what))?;
        }
        session
            .liveliness()
            .declare_subscriber(mission.expression(Selection::Alive))
            .history(true)
            .callback(move |sample| put_presence(&inlet, &sample, me, codec))
            .background()
            .await
            .map_err(LinkError::zenoh("watch who is there"))?;
        Ok(Self { session, mission, me, codec, waiting, present: BTreeSet::new(), token: None })
    }

    /// Lets the others know that this participant is there, and hears.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn announce(&mut self) -> Result<(), LinkError> {
        let key = self.mission.key(Topic::Alive(self.me)).to_string();
        let token = self.session.liveliness().declare_token(key).await;
        self.token = Some(token.map_err(LinkError::zenoh("say who is there"))?);
        Ok(())
    }

    /// Says something, as the message of this number.
    ///
    /// # Errors
    /// If Zenoh refuses.
    pub async fn publish(&self, number: u64, audience: Audience, message: &Message) -> Result<(), LinkError> {
        let Some(topic) = Topic::of(message.kind(), self.me, audience) else {
            let reason = format!("a {:?} has no place to go to {audience:?}", message.kind());
            return Err(LinkError::Participant { who: self.me, reason });
        };
        self.session
            .put(self.mission.key(topic).to_string(), convert::encode(message))
            .attachment(ZBytes::from(number.to_le_bytes()))
            .congestion_control(CongestionControl::Block)
            .express(true)
            .await
            .map_err(LinkError::zenoh("publish"))
    }

    /// The next thing heard; `None` once the session is closed.
    pub async fn hear(&mut self) -> Option<Heard> {
        Some(match self.waiting.take().await? {
            Arrival::Message { from, raw } => read(raw, from, self.codec),
            Arrival::Presence { who, is_here: true } => {
                self.present.insert(who);
                Heard::Came(who)
            }
            Arrival::Presence { who, is_here: false } => {
                self.present.remove(&who);
                Heard::Left(who)
            }
        })
    }

    /// Whose messages had to be dropped, more of them than can wait, since this was last asked; and how many. They are
    /// repaired later like any that is lost.
    pub(crate) fn dropped(&self) -> BTreeMap<Sender, u64> {
        self.waiting.dropped()
    }

    /// Who somebody is to whoever counts what comes: all who are not of the team are one.
    pub(crate) fn sender(&self, who: Participant) -> Sender {
        sender(Some(who), self.codec)
    }

    /// Others that are there.
    #[must_use]
    pub const fn present(&self) -> &BTreeSet<Participant> {
        &self.present
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

    /// The cells that messages speak of.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.codec.grid()
    }

    /// Who this is.
    #[must_use]
    pub const fn me(&self) -> Participant {
        self.me
    }

    /// Waits until all of these are there. Whatever else is heard meanwhile is handed over.
    ///
    /// # Errors
    /// If one does not come in time.
    pub async fn wait_for(
        &mut self,
        expected: &[Participant],
        patience: Duration,
        mut others: impl FnMut(Heard),
    ) -> Result<(), LinkError> {
        let deadline = tokio::time::Instant::now() + patience;
        loop {
            let absent = expected.iter().find(|who| **who != self.me && !self.present.contains(who));
            let Some(&absent) = absent else { return Ok(()) };
            match tokio::time::timeout_at(deadline, self.hear()).await {
                Ok(Some(Heard::Came(_) | Heard::Left(_))) => {}
                Ok(Some(heard)) => others(heard),
                Ok(None) | Err(_) => {
                    return Err(LinkError::Absent { who: absent.to_string(), waited: patience });
                }
            }
        }
    }
}

/// Leaves a message to be read, unless it is this participant's own. Reading is left to whoever takes it, so that what has
/// to be dropped has cost nothing.
fn put_message(inlet: &Inlet, sample: &Sample, me: Participant, codec: Codec) {
    let key = sample.key_expr().as_str();
    let from = key.parse().ok().and_then(|key: Key| key.topic.speech()).map(|(_, from)| from);
    if from != Some(me) {
        inlet.message(sender(from, codec), raw(sample));
    }
}

/// Leaves word that somebody has come or left. Who is not of the team has no place there: that is read like a message,
/// and refused.
fn put_presence(inlet: &Inlet, sample: &Sample, me: Participant, codec: Codec) {
    let key: Option<Key> = sample.key_expr().as_str().parse().ok();
    match key.map(|key| key.topic) {
        Some(Topic::Alive(who)) if who == me => {}
        Some(Topic::Alive(who)) if codec.knows(who) => inlet.presence(who, sample.kind() == SampleKind::Put),
        _ => inlet.message(Sender::Stranger, raw(sample)),
    }
}

fn sender(from: Option<Participant>, codec: Codec) -> Sender {
    from.filter(|&from| codec.knows(from)).map_or(Sender::Stranger, Sender::Known)
}

/// A copy: what Zenoh has may be a small part of a large buffer.
fn raw(sample: &Sample) -> Raw {
    let number = sample.attachment().and_then(|bytes| {
        let bytes: [u8; 8] = bytes.to_bytes().as_ref().try_into().ok()?;
        Some(u64::from_le_bytes(bytes))
    });
    let key = sample.key_expr().as_str().to_owned();
    Raw { key, payload: sample.payload().to_bytes().into_owned(), number }
}

/// What was sent, or why it is refused.
fn read(raw: Raw, from: Sender, codec: Codec) -> Heard {
    let refused = |key: String, reason: String| Heard::Refused { from, key, reason };
    let key: Key = match raw.key.parse() {
        Ok(key) => key,
        Err(error) => return refused(raw.key, error.to_string()),
    };
    let Some((kind, from)) = key.topic.speech() else {
        let reason = match key.topic {
            Topic::Alive(who) => format!("{who} is not of the team"),
            _ => "no message belongs here".to_owned(),
        };
        return refused(raw.key, reason);
    };
    let Some(number) = raw.number else {
        return refused(raw.key, "without the message's number as attachment".to_owned());
    };
    let message = codec.decode(kind, &raw.payload);
    match message.and_then(|message| convert::check_sender(&message, from).map(|()| message)) {
        Ok(message) => Heard::Message { from, number, message },
        Err(error) => refused(raw.key, error.to_string()),
    }
}
