//! What a search sent, by kind of message.

use std::collections::BTreeMap;

use dragnet_proto::message::MessageKind;
use dragnet_sim::traffic::Traffic;
use serde::Serialize;

/// The messages of one kind, or of all. A message counts once, however many receive it.
#[derive(Serialize)]
pub(super) struct Sent {
    messages: u64,
    bytes: u64,
    /// Mean over the robots and the mission time; absent if that is 0.
    bytes_per_second_and_robot: Option<f64>,
}

/// The messages of each kind, and `all` of them, by name.
pub(super) fn by_kind(traffic: &Traffic, seconds: f64, robots: usize) -> BTreeMap<&'static str, Sent> {
    let sent = |messages, bytes| {
        let robot_seconds = seconds * robots as f64;
        let rate = (robot_seconds > 0.0).then(|| bytes as f64 / robot_seconds);
        Sent { messages, bytes, bytes_per_second_and_robot: rate }
    };
    let kinds = traffic.sent.iter().map(|(&kind, amount)| (name(kind), sent(amount.messages, amount.bytes)));
    let messages = traffic.sent.values().map(|amount| amount.messages).sum();
    kinds.chain([("all", sent(messages, traffic.bytes()))]).collect()
}

const fn name(kind: MessageKind) -> &'static str {
    match kind {
        MessageKind::Observation => "observation",
        MessageKind::Intent => "intent",
        MessageKind::Heartbeat => "heartbeat",
        MessageKind::SyncRequest => "sync_request",
        MessageKind::SyncReply => "sync_reply",
        MessageKind::MissionStatus => "mission_status",
        MessageKind::Verdicts => "verdicts",
        MessageKind::Orders => "orders",
        MessageKind::Zones => "zones",
        MessageKind::Marks => "marks",
    }
}
