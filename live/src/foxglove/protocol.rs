//! Messages of Foxglove's WebSocket protocol, as far as a server that only sends needs them.

use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::ws::Message;
use dragnet_coordinator::record::encoder::{MESSAGE_ENCODING, SCHEMA_ENCODING};
use serde::Deserialize;
use serde_json::{Value, json};

use super::feed::Sent;

/// First byte of a binary message that holds a message of a topic,
const MESSAGE_DATA: u8 = 1;
/// and of one that holds the time.
const TIME: u8 = 2;
/// The server publishes the time: that of the mission, which differs from a computer's date in a simulation.
const CAPABILITIES: [&str; 1] = ["time"];

/// A message to a client.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outgoing {
    /// Who serves. The session is the same as long as the server runs: a client that has lost its connection sees whether it
    /// has found the same mission again.
    Hello {
        /// A name of the session.
        session: String,
    },
    /// Topics that the client does not know yet, numbered from the first on.
    Advertise {
        /// Number of the first.
        first: u32,
        /// The topics.
        topics: Vec<Arc<Advertised>>,
    },
    /// Something for people to read.
    Status(Level, String),
    /// A message of a topic, under the number of the client's subscription.
    Data(u32, Sent),
    /// The mission's time, Unix time, nanoseconds.
    Time(u64),
}

/// A topic as it is advertised.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Advertised {
    pub(super) topic: String,
    pub(super) schema_name: &'static str,
    pub(super) schema: Arc<str>,
}

/// How serious a status is, in the protocol's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    Info = 0,
    Warning = 1,
    Error = 2,
}

/// A request of a client.
#[derive(Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub(super) enum Request {
    /// Send the messages of these topics.
    Subscribe { subscriptions: Vec<Subscription> },
    /// End these subscriptions.
    Unsubscribe { subscription_ids: Vec<u32> },
}

/// A topic that a client wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Subscription {
    /// The client's number for it, under which it gets the messages.
    pub(super) id: u32,
    /// The number under which the topic was advertised.
    pub(super) channel_id: u32,
}

impl Request {
    /// Reads a client's message; `None` if it is no request, or one that is not served.
    pub(super) fn read(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }
}

impl Outgoing {
    /// The answer to a message that is no request, or to a request that is not served.
    pub(super) fn refusal() -> Self {
        let what = "this server only sends; a client may subscribe and unsubscribe, and nothing else";
        Self::Status(Level::Error, what.to_owned())
    }
}

fn advertise(first: u32, topics: &[Arc<Advertised>]) -> Value {
    let channel = |(id, topic): (u32, &Arc<Advertised>)| {
        json!({
            "id": id, "topic": topic.topic, "encoding": MESSAGE_ENCODING, "schemaName": topic.schema_name,
            "schema": &*topic.schema, "schemaEncoding": SCHEMA_ENCODING,
        })
    };
    let channels: Vec<Value> = (first..).zip(topics).map(channel).collect();
    json!({ "op": "advertise", "channels": channels })
}

impl From<Outgoing> for Message {
    fn from(outgoing: Outgoing) -> Self {
        match outgoing {
            Outgoing::Hello { session } => text(&json!({
                "op": "serverInfo", "name": "dragnet", "capabilities": CAPABILITIES, "sessionId": session,
            })),
            Outgoing::Advertise { first, topics } => text(&advertise(first, &topics)),
            Outgoing::Status(level, message) => {
                text(&json!({ "op": "status", "level": level as u8, "message": message }))
            }
            Outgoing::Data(subscription, Sent { time_ns, data, .. }) => {
                let mut bytes = Vec::with_capacity(13 + data.len());
                bytes.push(MESSAGE_DATA);
                bytes.extend(subscription.to_le_bytes());
                bytes.extend(time_ns.to_le_bytes());
                bytes.extend(&data[..]);
                Self::Binary(bytes.into())
            }
            Outgoing::Time(time_ns) => {
                let bytes: Vec<u8> = [TIME].into_iter().chain(time_ns.to_le_bytes()).collect();
                Self::Binary(Bytes::from(bytes))
            }
        }
    }
}

fn text(object: &Value) -> Message {
    Message::Text(object.to_string().into())
}
