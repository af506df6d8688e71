//! Messages from bytes, and bytes from messages.

use std::ops::Range;

use mavlink_core::{MAV_STX, MAV_STX_V2, MavHeader, MavlinkVersion, Message, calculate_crc, write_v2_msg};

use crate::MavMessage;

const CHECKSUM_BYTES: usize = 2;
const SIGNATURE_BYTES: usize = 13;
/// A message with other flags than this one is to be dropped, and the flag says that a signature follows it.
const IS_SIGNED: u8 = 1;

/// Reads messages from the bytes of a stream, or of datagrams one after the other. Bytes that are no message (noise, a
/// wrong checksum) are skipped, and so are messages that the [dialect](crate::common) does not have.
#[derive(Debug, Default)]
pub struct Decoder {
    /// Bytes that have arrived and are not read yet.
    pending: Vec<u8>,
}

/// What bytes contain.
#[derive(Debug, PartialEq)]
pub enum Frame {
    /// A message, and who sent it.
    Message(MavHeader, Box<MavMessage>),
    /// A message whose checksum is right and whose content is not; the reason.
    Unreadable(String),
}

impl Decoder {
    /// Adds bytes, and returns the messages that they complete, in order.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Frame> {
        self.pending.extend_from_slice(bytes);
        let (mut frames, mut read) = (Vec::new(), 0);
        let read = loop {
            let Some(start) = self.pending[read..].iter().position(|&byte| is_start(byte)) else {
                break self.pending.len();
            };
            read += start;
            let rest = &self.pending[read..];
            let Some(envelope) = Envelope::of(rest) else { break read };
            if envelope.has_known_flags && envelope.bytes > rest.len() {
                break read;
            }
            read += match envelope.content(rest) {
                Content::Message(frame) => {
                    frames.push(frame);
                    envelope.bytes
                }
                Content::Unknown => envelope.bytes,
                Content::Noise => 1,
            };
        };
        self.pending.drain(..read);
        frames
    }
}

/// Whether messages begin with this byte, of MAVLink 1 or 2.
const fn is_start(byte: u8) -> bool {
    matches!(byte, MAV_STX | MAV_STX_V2)
}

/// What the first bytes of a message say of it.
struct Envelope {
    version: MavlinkVersion,
    header: MavHeader,
    message_id: u32,
    has_known_flags: bool,
    /// Where the payload is in the bytes of the message.
    payload: Range<usize>,
    /// Length of the whole message.
    bytes: usize,
}

/// What is in an envelope.
enum Content {
    Message(Frame),
    /// A message of another dialect, it seems: its checksum cannot be checked.
    Unknown,
    Noise,
}

impl Envelope {
    /// The envelope at the beginning of `bytes`, if they hold it whole.
    fn of(bytes: &[u8]) -> Option<Self> {
        let number = |low: u8, middle: u8, high: u8| u32::from_le_bytes([low, middle, high, 0]);
        let (version, header_bytes, flags, [sequence, system_id, component_id], message_id) = match *bytes {
            [MAV_STX, _, sequence, system, component, id, ..] => {
                (MavlinkVersion::V1, 6, 0, [sequence, system, component], u32::from(id))
            }
            [MAV_STX_V2, _, flags, _, sequence, system, component, low, middle, high, ..] => {
                (MavlinkVersion::V2, 10, flags, [sequence, system, component], number(low, middle, high))
            }
            _ => return None,
        };
        let payload = header_bytes..header_bytes + usize::from(bytes[1]);
        let signature_bytes = if flags & IS_SIGNED == 0 { 0 } else { SIGNATURE_BYTES };
        Some(Self {
            version,
            header: MavHeader { system_id: u32::from(system_id), component_id, sequence },
            message_id,
            has_known_flags: flags & !IS_SIGNED == 0,
            bytes: payload.end + CHECKSUM_BYTES + signature_bytes,
            payload,
        })
    }

    /// What is in it. The bytes begin with the whole message, unless its flags are unknown.
    fn content(&self, bytes: &[u8]) -> Content {
        if !self.has_known_flags {
            return Content::Noise;
        }
        if MavMessage::default_message_from_id(self.message_id).is_none() {
            // What follows tells a message from noise here. A search for other messages in the bytes of one would wait
            // for the rest of what seems to begin there, and so delay the messages after it.
            let ends = bytes.get(self.bytes).is_none_or(|&byte| is_start(byte));
            return if ends { Content::Unknown } else { Content::Noise };
        }
        let checksum = &bytes[self.payload.end..][..CHECKSUM_BYTES];
        let extra = MavMessage::extra_crc(self.message_id);
        if calculate_crc(&bytes[1..self.payload.end], extra).to_le_bytes() != checksum {
            return Content::Noise;
        }
        Content::Message(
            match MavMessage::parse(self.version, self.message_id, &bytes[self.payload.clone()]) {
                Ok(message) => Frame::Message(self.header, Box::new(message)),
                Err(error) => Frame::Unreadable(error.to_string()),
            },
        )
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
    fn a_message_that_the_dialect_does_not_have_delays_none() {
        // RAW_IMU of system 1, as pymavlink sends it, in whose payload messages seem to begin.
        let foreign = b"\xFD\x19\0\0\0\x01\x01\x1B\0\0\x01\xFE\xFD\0\0\0\0\0\xFD\0\xFD\xFF\xFE\0\xFD\0\xFE\x07\xFE\xFF\x01\0\x02\0\x03\xC3\x10";
        let mut decoder = Decoder::default();
        for _ in 0..3 {
            assert_eq!(decoder.push(foreign), []);
            assert_eq!(decoded(decoder.push(&bytes())).len(), 2);
            assert_eq!(decoded(decoder.push(&[foreign, bytes().as_slice()].concat())).len(), 2);
        }
    }

    #[test]
    fn a_message_with_flags_that_are_unknown_is_dropped_and_a_signed_one_is_read() {
        let [mut unknown, mut signed] = messages().map(|message| Encoder::new(1, 191).encode(&message));
        unknown[2] = 2;
        signed[2] = IS_SIGNED;
        let checksum = signed.len() - CHECKSUM_BYTES;
        let crc = calculate_crc(&signed[1..checksum], MavMessage::extra_crc(2));
        signed[checksum..].copy_from_slice(&crc.to_le_bytes());
        signed.extend([7; SIGNATURE_BYTES]);
        let frames = Decoder::default().push(&[unknown, signed, bytes()].concat());
        let ids: Vec<u32> = decoded(frames).iter().map(|(.., message)| message.message_id()).collect();
        assert_eq!(ids, [2, 30, 2]);
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
