//! Messages from bytes, and bytes from messages.

use std::collections::VecDeque;
use std::io::{self, Read};

use mavlink::error::MessageReadError;
use mavlink::{MavHeader, MavlinkReader, write_v2_msg};

use crate::MavMessage;

/// Reads messages from the bytes of a stream, or of datagrams one after the other. Bytes that are no message (noise,
/// another dialect, a wrong checksum) are skipped.
pub struct Decoder {
    reader: MavlinkReader<Pending>,
}

/// What bytes contain.
#[derive(Debug, PartialEq)]
pub enum Frame {
    /// A message, and who sent it.
    Message(MavHeader, Box<MavMessage>),
    /// A message whose checksum is right and whose content is not; the reason.
    Unreadable(String),
}

/// Bytes that have arrived and are not read yet.
#[derive(Default)]
struct Pending(VecDeque<u8>);

impl Read for Pending {
    /// At the end there is an error, not the end of the stream: the reader keeps what it has of the next message.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer)? {
            0 => Err(io::ErrorKind::WouldBlock.into()),
            count => Ok(count),
        }
    }
}

impl Default for Decoder {
    fn default() -> Self {
        Self { reader: MavlinkReader::new(Pending::default()) }
    }
}

impl Decoder {
    /// Adds bytes, and returns the messages that they complete, in order.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Frame> {
        self.reader.get_mut().0.extend(bytes);
        let mut frames = Vec::new();
        loop {
            match self.reader.read_any_message() {
                Ok((header, message)) => frames.push(Frame::Message(header, Box::new(message))),
                Err(MessageReadError::Parse(error)) => frames.push(Frame::Unreadable(error.to_string())),
                Err(MessageReadError::Io(_)) => return frames,
            }
        }
    }
}

/// Writes messages of MAVLink 2, each with the next number.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    header: MavHeader,
}

impl Encoder {
    /// An encoder of the messages of this component.
    #[must_use]
    pub fn new(system_id: u8, component_id: u8) -> Self {
        Self { header: MavHeader { system_id: u32::from(system_id), component_id, sequence: 0 } }
    }

    /// The bytes of the next message.
    pub fn encode(&mut self, message: &MavMessage) -> Vec<u8> {
        let mut bytes = Vec::new();
        // A vector takes all bytes, so that this never fails.
        let written = write_v2_msg(&mut bytes, self.header, message);
        debug_assert!(written.is_ok());
        self.header.sequence = self.header.sequence.wrapping_add(1);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::common::{ATTITUDE_DATA, SYSTEM_TIME_DATA};

    fn messages() -> [MavMessage; 2] {
        [
            MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: 1, yaw: 0.5, ..ATTITUDE_DATA::default() }),
            MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec: 2, time_boot_ms: 3 }),
        ]
    }

    fn bytes() -> Vec<u8> {
        let mut encoder = Encoder::new(1, 191);
        messages().iter().flat_map(|message| encoder.encode(message)).collect()
    }

    fn decoded(frames: Vec<Frame>) -> Vec<(u32, u8, u8, MavMessage)> {
        let decoded = frames.into_iter().map(|frame| match frame {
            Frame::Message(header, message) => {
                (header.system_id, header.component_id, header.sequence, *message)
            }
            Frame::Unreadable(reason) => panic!("{reason}"),
        });
        decoded.collect()
    }

    #[test]
    fn messages_survive_noise_and_any_division_of_their_bytes() {
        let [attitude, time] = messages();
        let expected = [(1, 191, 0, attitude), (1, 191, 1, time)];
        for size in [1, 2, 7, 300] {
            let mut decoder = Decoder::default();
            let noise = [0xFD, 9, 0, 0, 7];
            let all = [noise.as_slice(), &bytes(), &noise].concat();
            let frames = all.chunks(size).flat_map(|part| decoder.push(part)).collect();
            assert_eq!(decoded(frames), expected, "{size}");
        }
    }

    #[test]
    fn a_wrong_byte_makes_no_message() {
        let first = Encoder::new(1, 191).encode(&messages()[0]).len();
        for place in 0..first {
            let mut spoiled = bytes();
            spoiled[place] ^= 0x10;
            let seen = Decoder::default().push(&spoiled);
            assert!(!seen.iter().any(|frame| matches!(frame, Frame::Message(_, message)
                if matches!(**message, MavMessage::ATTITUDE(_)))));
        }
    }

    proptest! {
        #[test]
        fn no_bytes_panic(bytes: Vec<u8>) {
            Decoder::default().push(&bytes);
        }
    }
}
