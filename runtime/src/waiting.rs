//! What has come and waits to be taken: bounded in bytes, and fair to those whom it came from.
//!
//! Each sender has a queue of its own. The one of whom least was taken is next, by bytes, so that whoever says much waits
//! longer than whoever says little; and if there is no room, the sender with the most bytes waiting loses its oldest
//! message. So who floods a participant delays and drops what it says itself.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use dragnet_proto::sender::Envelope;
use dragnet_scenario::participant::Participant;
use tokio::sync::mpsc;

/// So many bytes may wait, from all senders together.
pub(crate) const MOST_BYTES: usize = 64 * 1024 * 1024;
/// So often may it wait to be heard that processes of one sender came or left.
const MOST_PRESENCE: usize = 64;
/// A message takes so much room besides what it says.
const OVERHEAD: usize = 256;

/// Whose queue something waits in. All who are not of the team share one: there may be any number of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sender {
    /// Of the team, if nobody poses as it.
    Known(Participant),
    /// Anybody else.
    Stranger,
}

impl fmt::Display for Sender {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Known(who) => who.fmt(formatter),
            Self::Stranger => formatter.write_str("somebody who is not of the team"),
        }
    }
}

/// Bytes under a key, as they came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Raw {
    pub(crate) key: String,
    pub(crate) payload: Vec<u8>,
    /// What it came in, if it came in one.
    pub(crate) envelope: Option<Envelope>,
}

/// Something that has come.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// A message, not yet read.
    Message { from: Sender, raw: Raw },
    /// A process of somebody has come, or has left.
    Presence { who: Participant, identity: u64, is_here: bool },
}

/// Where arrivals are put. When the last one is gone, nothing comes any more.
#[derive(Clone)]
pub(crate) struct Inlet {
    queues: Arc<Mutex<Queues>>,
    news: mpsc::Sender<()>,
}

/// From where they are taken.
pub(crate) struct Outlet {
    queues: Arc<Mutex<Queues>>,
    news: mpsc::Receiver<()>,
}

/// An empty place to wait.
pub(crate) fn waiting(max_bytes: usize) -> (Inlet, Outlet) {
    let queues = Arc::new(Mutex::new(Queues { max_bytes, ..Queues::default() }));
    // One sign is enough for any number of arrivals.
    let (sender, receiver) = mpsc::channel(1);
    (Inlet { queues: Arc::clone(&queues), news: sender }, Outlet { queues, news: receiver })
}

impl Inlet {
    /// Puts in a message.
    pub(crate) fn message(&self, from: Sender, raw: Raw) {
        lock(&self.queues).put_message(from, raw);
        self.tell();
    }

    /// Puts in that a process of somebody of the team has come or left.
    pub(crate) fn presence(&self, who: Participant, identity: u64, is_here: bool) {
        lock(&self.queues).put_presence(who, identity, is_here);
        self.tell();
    }

    fn tell(&self) {
        // If a sign waits already, whoever takes it finds this too.
        let _ = self.news.try_send(());
    }
}

impl Outlet {
    /// The next arrival; `None` once nothing comes any more.
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

    /// Senders whose messages had to be dropped since this was last asked, and how many.
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
    /// What waits, of all.
    bytes: usize,
    senders: BTreeMap<Sender, Queue>,
    /// What whoever was last served had been given before, bytes: nobody saves up turns while it says nothing.
    served: u64,
    dropped: BTreeMap<Sender, u64>,
}

/// What waits of one sender, each with its place in the order of arrival.
#[derive(Debug, Default)]
struct Queue {
    messages: VecDeque<(u64, Raw)>,
    /// Whether each of its processes came or left, the last two times: what was before makes no difference.
    presence: VecDeque<(u64, Participant, u64, bool)>,
    arrivals: u64,
    bytes: usize,
    /// What was taken of it, bytes, as if it had always had something to say.
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

    fn put_presence(&mut self, who: Participant, identity: u64, is_here: bool) {
        let queue = self.queue(Sender::Known(who));
        let place = queue.arrive();
        let mut same =
            (0..).zip(&queue.presence).filter(|(_, (_, _, it, _))| *it == identity).map(|(at, _)| at);
        if let (Some(first), Some(_)) = (same.next(), same.next()) {
            queue.presence.remove(first);
        }
        if queue.presence.len() == MOST_PRESENCE {
            queue.forget_presence();
        }
        queue.presence.push_back((place, who, identity, is_here));
    }

    fn queue(&mut self, from: Sender) -> &mut Queue {
        let queue = self.senders.entry(from).or_default();
        if queue.is_empty() {
            queue.served = queue.served.max(self.served);
        }
        queue
    }

    /// Drops the oldest message of whoever has the most bytes waiting; whether there was one.
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

    /// Makes room: first of all whoever has come and left again was never there, so that nobody who is known to be there
    /// stays for ever; then the oldest that has come.
    fn forget_presence(&mut self) {
        let presence = &self.presence;
        let leaves = |identity| presence.iter().any(|&(_, _, it, is_here)| it == identity && !is_here);
        let mut come = presence.iter().filter(|(.., is_here)| *is_here).map(|&(_, _, identity, _)| identity);
        let oldest = come.clone().next();
        match come.find(|&identity| leaves(identity)).or(oldest) {
            Some(identity) => self.presence.retain(|(_, _, it, _)| *it != identity),
            None => drop(self.presence.pop_front()),
        }
    }

    /// The first that came, and the bytes that it took.
    fn take(&mut self, from: Sender) -> Option<(Arrival, usize)> {
        let message = self.messages.front().map(|&(place, _)| place);
        let presence = self.presence.front().map(|&(place, ..)| place);
        let is_message = message.is_some_and(|message| presence.is_none_or(|presence| message < presence));
        if is_message {
            let (_, raw) = self.messages.pop_front()?;
            let bytes = room(&raw);
            Some((Arrival::Message { from, raw }, bytes))
        } else {
            let (_, who, identity, is_here) = self.presence.pop_front()?;
            Some((Arrival::Presence { who, identity, is_here }, 0))
        }
    }
}

fn room(raw: &Raw) -> usize {
    raw.key.len() + raw.payload.len() + OVERHEAD
}

#[cfg(test)]
mod tests;
