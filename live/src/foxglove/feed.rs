//! The mission so far, as far as clients need it: its topics, the newest message of each state, and the last messages of all.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use axum::body::Bytes;
use dragnet_coordinator::record::encoder::Encoded;
use dragnet_coordinator::record::topic::Topic;
use dragnet_search::observation::RobotId;

use super::protocol::{Advertised, Outgoing};

/// The maximum size of the last messages, bytes; the newest one may be larger.
const MOST_RECENT_BYTES: usize = 32 << 20;
/// Maximum number of topics in one announcement: each brings its definition.
const MOST_ADVERTISED: usize = 100;

/// The mission so far.
#[derive(Default)]
pub(super) struct Feed {
    /// Topics in the order in which they appeared: the index of one is its number.
    topics: Vec<Arc<Advertised>>,
    numbers: BTreeMap<Topic, u32>,
    /// Definitions by name: those of all robots' topics are the same.
    schemas: BTreeMap<&'static str, Arc<str>>,
    /// The newest message of each state, by the number of its topic.
    states: BTreeMap<(u32, Option<RobotId>), Sent>,
    /// The last messages, numbered without a gap.
    recent: VecDeque<Sent>,
    recent_bytes: usize,
    /// Number of the next message.
    next: u64,
    /// The latest time of a message, Unix time, nanoseconds.
    time_ns: u64,
    is_over: bool,
}

/// A message; a copy of it shares the bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sent {
    /// Its number among all messages of the mission, from 0.
    pub(super) number: u64,
    /// The number of its topic.
    pub(super) channel: u32,
    /// When the coordinator received it, Unix time, nanoseconds.
    pub(super) time_ns: u64,
    pub(super) data: Bytes,
}

impl Sent {
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.data.len()
    }
}

impl Feed {
    /// Takes the next message of the mission.
    pub(super) fn put(&mut self, message: Encoded) {
        let channel = self.channel(&message);
        let (time_ns, state_of) = (message.times().logged, message.state_of());
        let sent = Sent { number: self.next, channel, time_ns, data: message.into_data().into() };
        self.next += 1;
        self.time_ns = self.time_ns.max(time_ns);
        if let Some((_, of)) = state_of {
            self.states.insert((channel, of), sent.clone());
        }
        self.recent_bytes += sent.bytes();
        self.recent.push_back(sent);
        while self.recent_bytes > MOST_RECENT_BYTES && self.recent.len() > 1 {
            let oldest = self.recent.pop_front();
            self.recent_bytes -= oldest.as_ref().map_or(0, Sent::bytes);
        }
    }

    /// The number of a message's topic, which is new if this is its first message.
    fn channel(&mut self, message: &Encoded) -> u32 {
        let topic = message.topic();
        if let Some(&number) = self.numbers.get(&topic) {
            return number;
        }
        let schema_name = message.schema_name();
        let schema = self.schemas.entry(schema_name).or_insert_with(|| message.schema().into());
        let schema = Arc::clone(schema);
        // Topics are few: some for each robot.
        let number = u32::try_from(self.topics.len()).unwrap_or(u32::MAX);
        self.topics.push(Arc::new(Advertised { topic: topic.to_string(), schema_name, schema }));
        self.numbers.insert(topic, number);
        number
    }

    /// There will be no further messages.
    pub(super) fn end(&mut self) {
        self.is_over = true;
    }

    pub(super) const fn is_over(&self) -> bool {
        self.is_over
    }

    /// The latest time of a message, Unix time, nanoseconds.
    pub(super) const fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// Number of the next message.
    pub(super) const fn next(&self) -> u64 {
        self.next
    }

    /// Whether there is a topic with this number.
    pub(super) fn has_channel(&self, number: u32) -> bool {
        usize::try_from(number).is_ok_and(|index| index < self.topics.len())
    }

    /// Announces topics to a client that knows the first `known` ones; returns also how many it knows then.
    pub(super) fn advertise(&self, known: usize) -> (Outgoing, usize) {
        let then = self.topics.len().min(known + MOST_ADVERTISED);
        let topics = self.topics.iter().take(then).skip(known).cloned().collect();
        (Outgoing::Advertise { first: u32::try_from(known).unwrap_or(u32::MAX), topics }, then)
    }

    pub(super) fn topic_count(&self) -> usize {
        self.topics.len()
    }

    /// The newest messages of all states of a topic.
    pub(super) fn states_of(&self, channel: u32) -> impl Iterator<Item = &Sent> {
        self.states
            .range((channel, None)..)
            .take_while(move |((of, _), _)| *of == channel)
            .map(|(_, sent)| sent)
    }

    /// The messages from a number on; `None` if the first of them is not kept any more.
    pub(super) fn since(&self, number: u64) -> Option<impl Iterator<Item = &Sent>> {
        let first = self.next - self.recent.len() as u64;
        let skipped = usize::try_from(number.checked_sub(first)?).ok()?;
        Some(self.recent.iter().skip(skipped))
    }
}
