//! A radio with a limited rate: which of the waiting messages is sent next, and how long that takes.
//!
//! It knows neither contents nor time: the simulator offers messages, asks for the next one when the radio is free, and carries it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use dragnet_scenario::Scenario;
use dragnet_scenario::time::MissionTime;
use dragnet_search::sensor::Sensor;

use crate::message::{Audience, Message, MessageKind, SyncReply};

/// The maximum number of messages that wait. Whatever is dropped is repaired later, like a lost message.
pub const MAX_WAITING: usize = 256;
/// A reading with more evidence for an object than this makes a cell of 1 % prior probability more likely than not to hold
/// one, nats.
const FIND_NATS: f64 = 4.6;

/// Time that one reply may occupy a radio, seconds: a find that comes up meanwhile waits for it.
const REPLY_SECONDS: f64 = 2.5;
/// Size of a packed observation without its readings, bytes, and of one of its readings.
const OBSERVATION_BYTES: f64 = 30.0;
const READING_BYTES: f64 = 1.0;

/// The maximum number of observations in one reply over a radio of this rate, bytes per second, at least 1;
/// [`SyncReply::MAX_OBSERVATIONS`] without a limit. All participants of a mission compute the same.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and MAX_OBSERVATIONS")]
fn max_observations(bytes_per_second: Option<f64>, sensor: &Sensor) -> usize {
    let Some(rate) = bytes_per_second else { return SyncReply::MAX_OBSERVATIONS };
    let bytes = OBSERVATION_BYTES + READING_BYTES * sensor.footprint().len() as f64;
    (rate * REPLY_SECONDS / bytes).clamp(1.0, SyncReply::MAX_OBSERVATIONS as f64) as usize
}

/// The maximum number of observations in one reply of a scenario's team: that of its widest sensor.
#[must_use]
pub fn max_observations_of(scenario: &Scenario) -> usize {
    max_observations(scenario.network().bytes_per_second, scenario.widest_sensor())
}

/// The order in which waiting messages are sent; messages of one priority are sent in the order in which they were offered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Priority {
    /// Observations with a reading that speaks for an object.
    Find,
    /// Plans: a teammate that does not know them may search the same cells.
    Intent,
    /// Other observations.
    Observation,
    /// Heartbeats, status, requests and replies.
    Other,
}

impl Priority {
    /// All priorities, the first one first.
    pub const ALL: [Self; 4] = [Self::Find, Self::Intent, Self::Observation, Self::Other];
}

/// What a radio knows of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Load {
    /// Its kind.
    pub kind: MessageKind,
    /// Its priority.
    pub priority: Priority,
    /// Number of the source whose observations a request or a reply is about; 0 for other messages.
    pub about: u16,
    /// Its size, bytes.
    pub bytes: u32,
}

impl Load {
    /// The load of a message that is encoded in this number of bytes.
    #[must_use]
    pub fn new(message: &Message, bytes: usize) -> Self {
        Self {
            kind: message.kind(),
            priority: priority(message),
            about: about(message),
            bytes: u32::try_from(bytes).unwrap_or(u32::MAX),
        }
    }

    /// Whether it makes an older message to the same receivers useless.
    fn replaces(self, older: Self) -> bool {
        self.kind != MessageKind::Observation && (self.kind, self.about) == (older.kind, older.about)
    }
}

fn priority(message: &Message) -> Priority {
    match message {
        Message::Observation(observation) => {
            let mut readings = observation.readings.iter();
            let is_find = readings.any(|it| it.evidence().log_likelihood_ratio_nats() > FIND_NATS);
            if is_find { Priority::Find } else { Priority::Observation }
        }
        Message::Intent(_) => Priority::Intent,
        _ => Priority::Other,
    }
}

fn about(message: &Message) -> u16 {
    match message {
        Message::SyncRequest(request) => request.of.source.number(),
        Message::SyncReply(reply) => {
            reply.observations.first().map_or(0, |observation| observation.origin.source.number())
        }
        _ => 0,
    }
}

/// A participant's radio. It sends one message at a time.
#[derive(Clone, Debug)]
pub struct Radio<M> {
    bytes_per_second: f64,
    /// By priority, and then by number.
    waiting: BTreeMap<(Priority, u64), Waiting<M>>,
    offered: u64,
    /// When it began to send, and when it is done.
    busy: Range<MissionTime>,
    unsent: u64,
}

#[derive(Clone, Debug)]
struct Waiting<M> {
    audience: Audience,
    load: Load,
    message: M,
}

/// A message that is being sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Sending<M> {
    /// Its receivers.
    pub audience: Audience,
    /// Its load.
    pub load: Load,
    /// The message.
    pub message: M,
    /// When its last byte is sent.
    pub until: MissionTime,
}

impl<M> Radio<M> {
    /// A free radio that sends this many bytes a second, above 0.
    #[must_use]
    pub const fn new(bytes_per_second: f64) -> Self {
        Self {
            bytes_per_second,
            waiting: BTreeMap::new(),
            offered: 0,
            busy: MissionTime::START..MissionTime::START,
            unsent: 0,
        }
    }

    /// Queues a message. It takes the place of an older one that it replaces: a plan, a heartbeat, a request or a reply about
    /// the same source. If too many wait, the last one of the lowest priority is dropped.
    pub fn offer(&mut self, audience: Audience, load: Load, message: M) {
        let mut waiting = self.waiting.values_mut();
        if let Some(older) = waiting.find(|older| older.audience == audience && load.replaces(older.load)) {
            *older = Waiting { audience, load, message };
            self.unsent += 1;
            return;
        }
        self.waiting.insert((load.priority, self.offered), Waiting { audience, load, message });
        self.offered += 1;
        if self.waiting.len() > MAX_WAITING {
            self.waiting.pop_last();
            self.unsent += 1;
        }
    }

    /// When to ask for the next message; `None` if none is waiting.
    #[must_use]
    pub fn due(&self) -> Option<MissionTime> {
        (!self.waiting.is_empty()).then_some(self.busy.end)
    }

    /// Begins to send the next message, if the radio is free and one is waiting. A clock that is set back to before it began
    /// does not keep it busy.
    pub fn next(&mut self, now: MissionTime) -> Option<Sending<M>> {
        if self.busy.contains(&now) {
            return None;
        }
        let (_, Waiting { audience, load, message }) = self.waiting.pop_first()?;
        let until = now + Duration::from_secs_f64(f64::from(load.bytes) / self.bytes_per_second);
        self.busy = now..until;
        Some(Sending { audience, load, message, until })
    }

    /// Drops all that is waiting.
    pub fn clear(&mut self) {
        self.unsent += self.waiting.len() as u64;
        self.waiting.clear();
    }

    /// Number of messages that were replaced or dropped before they were sent.
    #[must_use]
    pub const fn unsent(&self) -> u64 {
        self.unsent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn load(kind: MessageKind, priority: Priority, about: u16) -> Load {
        Load { kind, priority, about, bytes: 250 }
    }

    fn radio() -> Radio<u64> {
        Radio::new(125.0)
    }

    fn next(radio: &mut Radio<u64>, now: MissionTime) -> Option<u64> {
        radio.next(now).map(|sending| sending.message)
    }

    #[test]
    fn a_message_occupies_the_radio_for_its_bytes() {
        let mut radio = radio();
        let observation = load(MessageKind::Observation, Priority::Observation, 0);
        (0..2).for_each(|number| radio.offer(Audience::All, observation, number));
        let sending = radio.next(MissionTime::START).unwrap();
        assert_eq!((sending.message, sending.until), (0, MissionTime::START + 2 * SECOND));
        assert_eq!(next(&mut radio, MissionTime::START + SECOND), None);
        assert_eq!(radio.due(), Some(sending.until));
        assert_eq!(next(&mut radio, sending.until), Some(1));
        assert_eq!((next(&mut radio, sending.until + 2 * SECOND), radio.due()), (None, None));
    }

    #[test]
    fn finds_are_sent_first_then_plans_then_observations_then_the_rest() {
        let mut radio = radio();
        let kinds =
            [MessageKind::Heartbeat, MessageKind::Observation, MessageKind::Intent, MessageKind::Observation];
        for (number, (kind, &priority)) in (0..).zip(kinds.into_iter().zip(Priority::ALL.iter().rev())) {
            radio.offer(Audience::All, load(kind, priority, 0), number);
        }
        let times = (0..4).map(|place| MissionTime::START + place * 2 * SECOND);
        let order: Vec<u64> = times.filter_map(|now| next(&mut radio, now)).collect();
        assert_eq!(order, [3, 2, 1, 0]);
    }

    #[test]
    fn a_newer_message_takes_the_place_of_the_one_that_it_replaces() {
        let mut radio = radio();
        let heartbeat = load(MessageKind::Heartbeat, Priority::Other, 0);
        let request = |about| load(MessageKind::SyncRequest, Priority::Other, about);
        for (number, load) in (0..).zip([heartbeat, request(1), request(2), request(1), heartbeat]) {
            radio.offer(Audience::All, load, number);
        }
        assert_eq!(radio.unsent(), 2);
        let times = (0..4).map(|place| MissionTime::START + place * 2 * SECOND);
        assert_eq!(times.filter_map(|now| next(&mut radio, now)).collect::<Vec<_>>(), [4, 3, 2]);
    }

    #[test]
    fn if_too_many_wait_the_last_of_the_lowest_priority_is_dropped() {
        let mut radio = radio();
        let observation = load(MessageKind::Observation, Priority::Observation, 0);
        for number in 0..MAX_WAITING as u64 + 10 {
            radio.offer(Audience::All, observation, number);
        }
        radio.offer(Audience::All, load(MessageKind::Observation, Priority::Find, 0), 9999);
        assert_eq!((radio.waiting.len(), radio.unsent()), (MAX_WAITING, 11));
        assert_eq!(next(&mut radio, MissionTime::START), Some(9999));
        radio.clear();
        assert_eq!(radio.unsent(), 10 + MAX_WAITING as u64);
    }
}
