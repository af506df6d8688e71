//! A participant's place on the network: what it says, and what it hears.

use std::collections::BTreeSet;
use std::time::Duration;

use dragnet_proto::convert::{self, Codec};
use dragnet_proto::key::{Key, Mission, Selection, Topic};
use dragnet_proto::message::{Audience, Message, Participant};
use dragnet_search::cell::Grid;
use tokio::sync::mpsc;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::liveliness::LivelinessToken;
use zenoh::qos::CongestionControl;
use zenoh::sample::{Sample, SampleKind};

use crate::LinkError;

/// So many messages may wait to be heard; further ones are dropped, and repaired later like any that is lost.
const WAITING: usize = 65_536;

/// A participant on the network.
pub struct Link {
    session: Session,
    mission: Mission,
    me: Participant,
    codec: Codec,
    heard: mpsc::Receiver<Heard>,
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
        let (sender, heard) = mpsc::channel(WAITING);
        let to_all = [Selection::Observations, Selection::Intents, Selection::Heartbeats];
        let to_me = [Selection::LogRequestsTo(me), Selection::LogRepliesTo(me)];
        let coordinator = [Topic::Status, Topic::ByHand].map(|topic| mission.key(topic).to_string());
        let expressions = to_all.iter().chain(&to_me).map(|&selection| mission.expression(selection));
        for expression in expressions.chain(coordinator) {
            let (sender, what) = (sender.clone(), format!("subscribe to {expression}"));
            session
                .declare_subscriber(expression)
                .callback(move |sample| {
                    if let Some(heard) = understand(&sample, me, codec) {
                        offer(&sender, heard);
                    }
                })
                .background()
                .await
                .map_err(LinkError::zenoh(what))?;
        }
        session
            .liveliness()
            .declare_subscriber(mission.expression(Selection::Alive))
            .history(true)
            .callback(move |sample| {
                if let Some(heard) = presence(&sample, me) {
                    offer(&sender, heard);
                }
            })
            .background()
            .await
            .map_err(LinkError::zenoh("watch who is there"))?;
        Ok(Self { session, mission, me, codec, heard, present: BTreeSet::new(), token: None })
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
        let heard = self.heard.recv().await?;
        match heard {
            Heard::Came(who) => {
                self.present.insert(who);
            }
            Heard::Left(who) => {
                self.present.remove(&who);
            }
            Heard::Message { .. } | Heard::Refused { .. } => {}
        }
        Some(heard)
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

    /// Waits until all of these are there. Whatever else is heard meanwhile is returned.
    ///
    /// # Errors
    /// If one does not come in time.
    pub async fn wait_for(
        &mut self,
        expected: &[Participant],
        patience: Duration,
    ) -> Result<Vec<Heard>, LinkError> {
        let deadline = tokio::time::Instant::now() + patience;
        let mut others = Vec::new();
        loop {
            let absent = expected.iter().find(|who| **who != self.me && !self.present.contains(who));
            let Some(&absent) = absent else { return Ok(others) };
            match tokio::time::timeout_at(deadline, self.hear()).await {
                Ok(Some(Heard::Came(_) | Heard::Left(_))) => {}
                Ok(Some(heard)) => others.push(heard),
                Ok(None) | Err(_) => {
                    return Err(LinkError::Absent { who: absent.to_string(), waited: patience });
                }
            }
        }
    }
}

fn offer(sender: &mpsc::Sender<Heard>, heard: Heard) {
    if let Err(mpsc::error::TrySendError::Full(_)) = sender.try_send(heard) {
        tracing::warn!("more than {WAITING} messages wait; one is dropped, and asked for later");
    }
}

/// What a sample says; nothing if it is this participant's own.
fn understand(sample: &Sample, me: Participant, codec: Codec) -> Option<Heard> {
    let refused = |reason: String| Some(Heard::Refused { key: sample.key_expr().to_string(), reason });
    let key: Key = match sample.key_expr().as_str().parse() {
        Ok(key) => key,
        Err(error) => return refused(format!("{error}")),
    };
    let Some((kind, from)) = key.topic.speech() else { return refused("no message belongs here".to_owned()) };
    if from == me {
        return None;
    }
    let number = sample.attachment().and_then(|bytes| {
        let bytes: [u8; 8] = bytes.to_bytes().as_ref().try_into().ok()?;
        Some(u64::from_le_bytes(bytes))
    });
    let Some(number) = number else {
        return refused("without the message's number as attachment".to_owned());
    };
    let message = codec.decode(kind, &sample.payload().to_bytes());
    match message.and_then(|message| convert::check_sender(&message, from).map(|()| message)) {
        Ok(message) => Some(Heard::Message { from, number, message }),
        Err(error) => refused(error.to_string()),
    }
}

/// Who has come or left; nothing if it is this participant itself.
fn presence(sample: &Sample, me: Participant) -> Option<Heard> {
    let key: Key = sample.key_expr().as_str().parse().ok()?;
    let Topic::Alive(who) = key.topic else { return None };
    (who != me).then(|| match sample.kind() {
        SampleKind::Put => Heard::Came(who),
        SampleKind::Delete => Heard::Left(who),
    })
}
