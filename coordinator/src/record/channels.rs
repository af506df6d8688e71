//! Messages of a recording, each on the channel of its topic.

use std::collections::BTreeMap;
use std::io::Write;

use dragnet_ros2::schema::RosMessage;
use mcap::records::MessageHeader;

use super::topic::Topic;
use crate::mcap_file::RecordingError;
use crate::mcap_file::write::McapWriter;

/// A message as it is recorded.
pub(crate) struct Encoded {
    topic: Topic,
    /// Name of its definition.
    name: &'static str,
    /// Text of its definition, which is long.
    schema: fn() -> String,
    data: Vec<u8>,
}

impl Encoded {
    pub(crate) fn new<T: RosMessage>(topic: Topic, message: &T) -> Self {
        Self { topic, name: T::NAME, schema: T::schema, data: message.to_cdr() }
    }
}

/// When a message was received, and when its sender published it: Unix time, nanoseconds.
#[derive(Clone, Copy)]
pub(crate) struct UnixTimes {
    pub(crate) logged: u64,
    pub(crate) published: u64,
}

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
        times: UnixTimes,
        message: &Encoded,
    ) -> Result<(), RecordingError> {
        let Encoded { topic, name, schema, data } = message;
        let channel = match self.0.get(topic) {
            Some(&known) => known,
            None => Channel {
                id: file.add_topic(&topic.to_string(), (name, &schema()), &topic.metadata())?,
                messages: 0,
            },
        };
        self.0.insert(*topic, Channel { messages: channel.messages.wrapping_add(1), ..channel });
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.messages,
            log_time: times.logged,
            publish_time: times.published,
        };
        file.message(&header, data)
    }
}
