//! What one client gets next.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::feed::{Feed, Sent};
use super::protocol::{Level, Outgoing, Request, Subscription};

/// Size of the messages that a client gets at once, bytes, but for the last of them; meanwhile it is not read.
const BATCH_BYTES: usize = 1 << 20;
/// Maximum number of messages that a client gets at once.
const BATCH: usize = 256;

/// The state of one client.
pub(super) struct Client {
    /// Number of topics that it knows.
    advertised: usize,
    /// Its subscriptions, by the number of the topic.
    subscriptions: BTreeMap<u32, Subscribed>,
    /// Its numbers for them.
    ids: BTreeSet<u32>,
    /// States that it gets before anything else, with the number of its subscription.
    states: VecDeque<(u32, Sent)>,
    /// Number of the next message of the mission that it has not passed.
    next: u64,
    /// The time that it knows, Unix time, nanoseconds.
    time_ns: u64,
    knows_end: bool,
}

struct Subscribed {
    /// The client's number for it.
    id: u32,
    /// Number of the first message that belongs to it; before that it got the states.
    from: u64,
}

impl Client {
    /// A new client, and the first messages to it.
    pub(super) fn new(session: &str, feed: &Feed) -> (Self, Vec<Outgoing>) {
        // One is always sent, even if it is empty.
        let (topics, advertised) = feed.advertise(0);
        let client = Self {
            advertised,
            subscriptions: BTreeMap::new(),
            ids: BTreeSet::new(),
            states: VecDeque::new(),
            next: feed.next(),
            time_ns: feed.time_ns(),
            knows_end: false,
        };
        let hello = Outgoing::Hello { session: session.to_owned() };
        (client, vec![hello, Outgoing::Time(feed.time_ns()), topics])
    }

    /// The next messages to the client; none if it has everything.
    pub(super) fn next(&mut self, feed: &Feed) -> Vec<Outgoing> {
        if self.advertised < feed.topic_count() {
            let (topics, advertised) = feed.advertise(self.advertised);
            self.advertised = advertised;
            return vec![topics];
        }
        let mut batch = Batch::default();
        while !batch.is_full()
            && let Some((id, sent)) = self.states.pop_front()
        {
            batch.add(id, &sent, &mut self.time_ns);
        }
        match feed.since(self.next) {
            Some(messages) => self.go_on(messages, &mut batch),
            None => return self.skip(feed, batch),
        }
        if batch.messages.is_empty() && feed.is_over() && !std::mem::replace(&mut self.knows_end, true) {
            return vec![Outgoing::Status(Level::Info, "the mission is over".to_owned())];
        }
        batch.messages
    }

    /// Passes messages of the mission until there is enough.
    fn go_on<'a>(&mut self, messages: impl Iterator<Item = &'a Sent>, batch: &mut Batch) {
        for sent in messages {
            if batch.is_full() {
                return;
            }
            self.next = sent.number + 1;
            if let Some(subscribed) = self.subscriptions.get(&sent.channel)
                && sent.number >= subscribed.from
            {
                batch.add(subscribed.id, sent, &mut self.time_ns);
            }
        }
    }

    /// Gives up the messages that it has not got: it goes on with the newest states.
    fn skip(&mut self, feed: &Feed, batch: Batch) -> Vec<Outgoing> {
        let missed = feed.next() - self.next;
        self.next = feed.next();
        self.states.clear();
        for (&channel, subscribed) in &mut self.subscriptions {
            subscribed.from = feed.next();
            self.states.extend(feed.states_of(channel).map(|sent| (subscribed.id, sent.clone())));
        }
        let mut messages = batch.messages;
        let what = format!(
            "this connection is too slow: of {missed} messages it gets only the newest of each state"
        );
        messages.push(Outgoing::Status(Level::Warning, what));
        messages
    }

    /// Handles a request of the client; returns the answer.
    pub(super) fn take(&mut self, request: Request, feed: &Feed) -> Vec<Outgoing> {
        match request {
            Request::Subscribe { subscriptions } => {
                let failed = |asked: Subscription| self.subscribe(asked, feed).err();
                let failures: Vec<String> = subscriptions.into_iter().filter_map(failed).collect();
                // A client that asks for many wrong things gets one answer.
                failures.into_iter().take(1).map(|why| Outgoing::Status(Level::Error, why)).collect()
            }
            Request::Unsubscribe { subscription_ids } => {
                let ended: BTreeSet<u32> = subscription_ids.into_iter().collect();
                self.subscriptions.retain(|_, subscribed| !ended.contains(&subscribed.id));
                self.ids.retain(|id| !ended.contains(id));
                self.states.retain(|(id, _)| !ended.contains(id));
                Vec::new()
            }
        }
    }

    /// The client gets the newest states of the topic, and from now on all of its messages.
    fn subscribe(&mut self, asked: Subscription, feed: &Feed) -> Result<(), String> {
        let Subscription { id, channel_id } = asked;
        if !feed.has_channel(channel_id) {
            return Err(format!("there is no channel {channel_id}"));
        }
        if self.subscriptions.contains_key(&channel_id) {
            return Err(format!("channel {channel_id} is subscribed to already"));
        }
        if !self.ids.insert(id) {
            return Err(format!("subscription {id} is in use"));
        }
        self.subscriptions.insert(channel_id, Subscribed { id, from: feed.next() });
        self.states.extend(feed.states_of(channel_id).map(|sent| (id, sent.clone())));
        Ok(())
    }
}

/// Messages that are sent at once.
#[derive(Default)]
struct Batch {
    messages: Vec<Outgoing>,
    bytes: usize,
}

impl Batch {
    fn is_full(&self) -> bool {
        self.bytes >= BATCH_BYTES || self.messages.len() >= BATCH
    }

    /// Adds a message, and before it the time if that is later than the client's.
    fn add(&mut self, subscription: u32, sent: &Sent, time_ns: &mut u64) {
        if sent.time_ns > *time_ns {
            *time_ns = sent.time_ns;
            self.messages.push(Outgoing::Time(sent.time_ns));
        }
        self.bytes += sent.data.len();
        self.messages.push(Outgoing::Data(subscription, sent.clone()));
    }
}
