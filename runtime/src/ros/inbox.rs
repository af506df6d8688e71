//! Received messages that are not processed yet: of each topic the last few, by its quality of service. So a camera
//! that is faster than the detector fills no memory, and images are as recent as possible.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;
use zenoh::bytes::ZBytes;

/// Maximum number of pending errors of a topic.
const REFUSALS: usize = 8;

/// A message that arrived on a topic, given by the index of the subscription.
#[derive(Debug)]
pub(super) struct Arrived {
    pub(super) topic: usize,
    pub(super) what: What,
}

/// The content.
#[derive(Debug)]
pub(super) enum What {
    /// A message's bytes.
    Message(ZBytes),
    /// An invalid message, and the reason.
    Rejected(String),
}

impl What {
    const fn is_message(&self) -> bool {
        matches!(self, Self::Message(_))
    }
}

/// All pending messages, in the order of arrival.
#[derive(Debug)]
pub(super) struct Inbox {
    /// Maximum number of pending messages of each topic, shape `[topics]`.
    depths: Vec<usize>,
    waiting: Mutex<VecDeque<Arrived>>,
    news: Notify,
}

impl Inbox {
    pub(super) const fn new(depths: Vec<usize>) -> Self {
        Self { depths, waiting: Mutex::new(VecDeque::new()), news: Notify::const_new() }
    }

    /// Adds a message; of a full topic the oldest is dropped.
    pub(super) fn put(&self, arrived: Arrived) {
        let mut waiting = self.lock();
        let is_message = arrived.what.is_message();
        let depth = if is_message { self.depths[arrived.topic] } else { REFUSALS };
        let alike = |other: &Arrived| other.topic == arrived.topic && other.what.is_message() == is_message;
        if waiting.iter().filter(|other| alike(other)).count() >= depth
            && let Some(oldest) = waiting.iter().position(alike)
        {
            waiting.remove(oldest);
        }
        waiting.push_back(arrived);
        drop(waiting);
        self.news.notify_one();
    }

    /// The next message. Cancel safe.
    pub(super) async fn take(&self) -> Arrived {
        loop {
            if let Some(arrived) = self.lock().pop_front() {
                return arrived;
            }
            self.news.notified().await;
        }
    }

    /// Nothing panics while it is locked, so the content is consistent.
    fn lock(&self) -> MutexGuard<'_, VecDeque<Arrived>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(topic: usize, byte: u8) -> Arrived {
        Arrived { topic, what: What::Message(ZBytes::from(vec![byte])) }
    }

    #[tokio::test]
    async fn of_each_topic_the_last_ones_wait_in_the_order_of_their_arrival() {
        let inbox = Inbox::new(vec![2, 1]);
        for arrived in [message(0, 1), message(1, 2), message(0, 3), message(1, 4), message(0, 5)] {
            inbox.put(arrived);
        }
        inbox.put(Arrived { topic: 1, what: What::Rejected("no".into()) });
        let mut taken = Vec::new();
        for _ in 0..4 {
            let Arrived { topic, what } = inbox.take().await;
            taken.push((
                topic,
                match what {
                    What::Message(bytes) => bytes.to_bytes()[0],
                    What::Rejected(_) => 0,
                },
            ));
        }
        assert_eq!(taken, [(0, 3), (1, 4), (0, 5), (1, 0)]);
        assert!(inbox.lock().is_empty());
    }

    #[test]
    fn rejections_do_not_pile_up_either() {
        let inbox = Inbox::new(vec![1]);
        for number in 0..100 {
            inbox.put(Arrived { topic: 0, what: What::Rejected(number.to_string()) });
        }
        assert_eq!(inbox.lock().len(), REFUSALS);
    }
}
