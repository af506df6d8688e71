//! Received messages that wait to be processed: bounded in bytes, and fair among senders.
//!
//! Each sender has its own queue. The sender with the least processed bytes is next, so that senders of many messages
//! wait longer than those of few; and if there is no space, the sender with the most pending bytes loses its oldest
//! message. So a participant that floods another delays and drops only its own messages.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use dragnet_proto::sender::{Claim, Envelope};
use dragnet_scenario::participant::Participant;
use tokio::sync::mpsc;

/// Maximum number of pending bytes, of all senders together.
pub(crate) const MOST_BYTES: usize = 64 * 1024 * 1024;
/// Maximum number of pending presence changes of one sender.
const MOST_PRESENCE: usize = 64;
/// Overhead of a message, bytes.
const OVERHEAD: usize = 256;

/// The owner of a queue. All outside the team share one: there may be any number of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sender {
    /// A participant of the team, unless another impersonates it.
    Known(Participant),
    /// Any other.
    Stranger,
}

impl fmt::Display for Sender {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(participant) => participant.fmt(formatter),
            Self::Stranger => formatter.write_str("a participant outside the team"),
        }
    }
}

/// Undecoded bytes with their key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Raw {
    pub(crate) key: String,
    pub(crate) payload: Vec<u8>,
    /// Their envelope, if valid.
    pub(crate) envelope: Option<Envelope>,
}

/// A pending message or change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// A message, not decoded yet.
    Message { from: Sender, raw: Raw },
    /// A liveliness token of a participant has come or gone.
    Presence { participant: Participant, claim: Claim, is_here: bool },
}

/// The sending half. When the last one is dropped, nothing arrives any more.
#[derive(Clone)]
pub(crate) struct Inlet {
    queues: Arc<Mutex<Queues>>,
    news: mpsc::Sender<()>,
}

/// The receiving half.
pub(crate) struct Outlet {
    queues: Arc<Mutex<Queues>>,
    news: mpsc::Receiver<()>,
}

/// An empty queue.
pub(crate) fn waiting(max_bytes: usize) -> (Inlet, Outlet) {
    let queues = Arc::new(Mutex::new(Queues { max_bytes, ..Queues::default() }));
    // One signal is enough for any number of arrivals.
    let (sender, receiver) = mpsc::channel(1);
    (Inlet { queues: Arc::clone(&queues), news: sender }, Outlet { queues, news: receiver })
}

impl Inlet {
    /// Adds a message.
    pub(crate) fn message(&self, from: Sender, raw: Raw) {
        lock(&self.queues).put_message(from, raw);
        self.tell();
    }

    /// Adds the arrival or departure of a liveliness token of the team.
    pub(crate) fn presence(&self, participant: Participant, claim: Claim, is_here: bool) {
        lock(&self.queues).put_presence(participant, claim, is_here);
        self.tell();
    }

    fn tell(&self) {
        // If a signal is pending already, its receiver finds this too.
        let _ = self.news.try_send(());
    }
}

impl Outlet {
    /// The next arrival; `None` once nothing arrives any more.
    pub(crate) async fn take(&mut self) -> Option<Arrival> {
        loop {
            let next = lock(&self.queues).take();
            if next.is_some() {
                return next;
            }
            if self.news.recv().await.is_none() {
                return lock(&self.queues).take();
            }
        }
    }

    /// Senders whose messages were dropped since the last call, and their numbers.
    pub(crate) fn dropped(&self) -> BTreeMap<Sender, u64> {
        std::mem::take(&mut lock(&self.queues).dropped)
    }
}

fn lock(queues: &Mutex<Queues>) -> MutexGuard<'_, Queues> {
    queues.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The queues of all senders.
#[derive(Debug, Default)]
struct Queues {
    max_bytes: usize,
    /// Pending bytes of all.
    bytes: usize,
    senders: BTreeMap<Sender, Queue>,
    /// Processed bytes of the last served sender before that: silent senders do not save up turns.
    served: u64,
    dropped: BTreeMap<Sender, u64>,
}

/// Pending arrivals of one sender, each with its position in the order of arrival.
#[derive(Debug, Default)]
struct Queue {
    messages: VecDeque<(u64, Raw)>,
    /// The last two presence changes of each of its tokens: earlier ones make no difference.
    presence: VecDeque<(u64, Participant, Claim, bool)>,
    arrivals: u64,
    bytes: usize,
    /// Processed bytes, as if it had always had pending messages.
    served: u64,
}

impl Queues {
    fn put_message(&mut self, from: Sender, raw: Raw) {
        let bytes = room(&raw);
        let queue = self.queue(from);
        let place = queue.arrive();
        queue.messages.push_back((place, raw));
        queue.bytes += bytes;
        self.bytes += bytes;
        while self.bytes > self.max_bytes && self.drop_one() {}
    }

    fn put_presence(&mut self, participant: Participant, claim: Claim, is_here: bool) {
        let queue = self.queue(Sender::Known(participant));
        let place = queue.arrive();
        let mut same = (0..).zip(&queue.presence).filter(|(_, (_, _, it, _))| *it == claim).map(|(at, _)| at);
        if let (Some(first), Some(_)) = (same.next(), same.next()) {
            queue.presence.remove(first);
        }
        if queue.presence.len() == MOST_PRESENCE {
            queue.forget_presence();
        }
        queue.presence.push_back((place, participant, claim, is_here));
    }

    fn queue(&mut self, from: Sender) -> &mut Queue {
        let queue = self.senders.entry(from).or_default();
        if queue.is_empty() {
            queue.served = queue.served.max(self.served);
        }
        queue
    }

    /// Drops the oldest message of the sender with the most pending bytes; returns whether there was one.
    fn drop_one(&mut self) -> bool {
        let longest = self.senders.iter_mut().max_by_key(|(_, queue)| queue.bytes);
        let Some((&sender, queue)) = longest else { return false };
        let Some((_, raw)) = queue.messages.pop_front() else { return false };
        queue.bytes -= room(&raw);
        self.bytes -= room(&raw);
        *self.dropped.entry(sender).or_default() += 1;
        true
    }

    fn take(&mut self) -> Option<Arrival> {
        let waiting = self.senders.iter_mut().filter(|(_, queue)| !queue.is_empty());
        let (&from, queue) = waiting.min_by_key(|(_, queue)| queue.served)?;
        self.served = queue.served;
        let (arrival, bytes) = queue.take(from)?;
        queue.served += bytes.max(OVERHEAD) as u64;
        queue.bytes -= bytes;
        self.bytes -= bytes;
        Some(arrival)
    }
}

impl Queue {
    fn is_empty(&self) -> bool {
        self.messages.is_empty() && self.presence.is_empty()
    }

    fn arrive(&mut self) -> u64 {
        self.arrivals += 1;
        self.arrivals
    }

    /// Makes space: first a token that has come and gone again is forgotten, so that no known one stays for ever; then
    /// the oldest arrival.
    fn forget_presence(&mut self) {
        let presence = &self.presence;
        let leaves = |claim| presence.iter().any(|&(_, _, it, is_here)| it == claim && !is_here);
        let mut come = presence.iter().filter(|(.., is_here)| *is_here).map(|&(_, _, claim, _)| claim);
        let oldest = come.clone().next();
        match come.find(|&claim| leaves(claim)).or(oldest) {
            Some(claim) => self.presence.retain(|(_, _, it, _)| *it != claim),
            None => drop(self.presence.pop_front()),
        }
    }

    /// The first arrival, and its bytes.
    fn take(&mut self, from: Sender) -> Option<(Arrival, usize)> {
        let message = self.messages.front().map(|&(place, _)| place);
        let presence = self.presence.front().map(|&(place, ..)| place);
        let is_message = message.is_some_and(|message| presence.is_none_or(|presence| message < presence));
        if is_message {
            let (_, raw) = self.messages.pop_front()?;
            let bytes = room(&raw);
            Some((Arrival::Message { from, raw }, bytes))
        } else {
            let (_, participant, claim, is_here) = self.presence.pop_front()?;
            Some((Arrival::Presence { participant, claim, is_here }, 0))
        }
    }
}

fn room(raw: &Raw) -> usize {
    raw.key.len() + raw.payload.len() + OVERHEAD
}

#[cfg(test)]
mod tests;
