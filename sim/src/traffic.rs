//! The messages that a mission sends, by kind.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use dragnet_proto::message::MessageKind;
use dragnet_proto::radio::Load;

/// Messages sent by all participants; a message counts once, however many receive it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Sent, by kind.
    pub sent: BTreeMap<MessageKind, Amount>,
    /// Messages that were replaced or dropped while they waited for a radio.
    pub unsent: u64,
}

/// A number of messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Amount {
    /// Messages.
    pub messages: u64,
    /// Their size, bytes.
    pub bytes: u64,
}

impl AddAssign<&Self> for Traffic {
    fn add_assign(&mut self, other: &Self) {
        for (&kind, amount) in &other.sent {
            let sum = self.sent.entry(kind).or_default();
            sum.messages += amount.messages;
            sum.bytes += amount.bytes;
        }
        self.unsent += other.unsent;
    }
}

impl Traffic {
    /// Counts a message that is sent.
    pub(crate) fn count(&mut self, load: Load) {
        let amount = self.sent.entry(load.kind).or_default();
        amount.messages += 1;
        amount.bytes += u64::from(load.bytes);
    }

    /// Size of all messages, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.sent.values().map(|amount| amount.bytes).sum()
    }
}
