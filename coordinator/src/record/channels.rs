//! Messages of a recording, each on the channel of its topic.

use std::collections::BTreeMap;
use std::io::Write;

use mcap::records::MessageHeader;

use super::encoder::{Encoded, UnixTimes};
use super::topic::Topic;
use crate::mcap_file::RecordingError;
use crate::mcap_file::write::McapWriter;

/// The channels of a file in progress.
#[derive(Default)]
pub(crate) struct Channels(BTreeMap<Topic, Channel>);

#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    /// Messages so far.
    messages: u32,
}

impl Channels {
    /// Writes a message; its topic's first one defines the channel.
    pub(crate) fn put<W: Write>(
        &mut self,
        file: &mut McapWriter<W>,
        message: &Encoded,
    ) -> Result<(), RecordingError> {
        let topic = message.topic();
        let channel = match self.0.get(&topic) {
            Some(&known) => known,
            None => Channel {
                id: file.add_topic(
                    &topic.to_string(),
                    (message.schema_name(), &message.schema()),
                    &topic.metadata(),
                )?,
                messages: 0,
            },
        };
        self.0.insert(topic, Channel { messages: channel.messages.wrapping_add(1), ..channel });
        let UnixTimes { logged, published } = message.times();
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.messages,
            log_time: logged,
            publish_time: published,
        };
        file.message(&header, message.data())
    }
}
