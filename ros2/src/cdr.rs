//! CDR: the bytes of ROS 2 messages.
//!
//! A message is the header `00 01 00 00` and an XCDR1 little-endian body, in which every number is aligned to its size
//! counted from the body's start. The same bytes go over Zenoh, into MCAP and to ROS 2 nodes.

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The name of these bytes in MCAP and Foxglove.
pub const ENCODING: &str = "cdr";
/// The maximum size of a message that is decoded: one byte per cell of the largest map, or a full sync reply of the
/// widest sensor.
pub const MAX_BYTES: usize = (1 << 24) + HEADER.len() + 1024;

/// Little-endian CDR, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];
/// Bits of the header's last byte that count padding after the body, as Cyclone DDS adds it.
const PADDING_BITS: u8 = 0b11;

/// Why bytes cannot be decoded.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// Longer than any message.
    #[error("{0} bytes; allowed are at most {MAX_BYTES}")]
    TooLong(usize),
    /// Shorter than any message.
    #[error("{0} bytes; a message begins with a header of 4")]
    NoHeader(usize),
    /// Another encoding.
    #[error("header {:02x} {:02x}; allowed is 00 01, little-endian CDR", .0[0], .0[1])]
    Encoding([u8; 2]),
    /// A body that ends early, or holds an invalid value of its type.
    #[error("body of {bytes} bytes: {source}")]
    Body {
        /// Length of the body.
        bytes: usize,
        /// The decoder's error.
        source: cdr_encoding::Error,
    },
    /// More bytes than the message has.
    #[error("{0} bytes after the end of the message")]
    Trailing(usize),
}

/// The bytes of a message.
#[must_use]
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    let mut bytes = HEADER.to_vec();
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut bytes, message).unwrap_or_else(|error| {
        unreachable!("wire structs know their lengths and a Vec takes every byte: {error}")
    });
    bytes
}

/// Decodes a message. Memory is allocated as elements arrive, never by a claimed length.
///
/// # Errors
/// If the bytes have another encoding, are too short or too long, or hold an invalid value.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DecodeError> {
    let body = body(bytes)?;
    let (message, used) = cdr_encoding::from_bytes::<T, LittleEndian>(body)
        .map_err(|source| DecodeError::Body { bytes: body.len(), source })?;
    match body.len() - used {
        0 => Ok(message),
        trailing => Err(DecodeError::Trailing(trailing)),
    }
}

/// The body between the header and the padding.
///
/// # Errors
/// As [`decode`], for the header and the length.
pub fn body(bytes: &[u8]) -> Result<&[u8], DecodeError> {
    if bytes.len() > MAX_BYTES {
        return Err(DecodeError::TooLong(bytes.len()));
    }
    let Some((header, body)) = bytes.split_first_chunk::<4>() else {
        return Err(DecodeError::NoHeader(bytes.len()));
    };
    if header[..2] != HEADER[..2] {
        return Err(DecodeError::Encoding([header[0], header[1]]));
    }
    let padding = usize::from(header[3] & PADDING_BITS);
    Ok(&body[..body.len().saturating_sub(padding)])
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::mentions::assert_mentions;
    use crate::wire::standard::{Header, Point, Pose, PoseStamped, Quaternion, Time};

    fn pose() -> PoseStamped {
        PoseStamped {
            header: Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".into() },
            pose: Pose { position: Point { x: 1.0, y: 2.0, z: 0.0 }, orientation: Quaternion::default() },
        }
    }

    #[test]
    fn a_pose_has_the_bytes_that_ros_gives_it() {
        let mut expected = vec![0, 1, 0, 0]; // header
        expected.extend([1, 0, 0, 0, 2, 0, 0, 0]); // stamp
        expected.extend([4, 0, 0, 0, b'm', b'a', b'p', 0]); // frame: length with its NUL
        for number in [1.0_f64, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0] {
            expected.extend(number.to_le_bytes());
        }
        assert_eq!(encode(&pose()), expected);
        assert_eq!(decode::<PoseStamped>(&expected).unwrap(), pose());
    }

    #[test]
    fn a_float64_after_a_string_is_aligned_to_the_body() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct Named {
            name: String,
            value: f64,
            list: Vec<u32>,
            pair: [u64; 2],
        }
        let named = Named { name: "ab".into(), value: 1.5, list: vec![7], pair: [8, 9] };
        let mut expected = vec![0, 1, 0, 0];
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0]); // 7 bytes, 1 of padding
        expected.extend(1.5_f64.to_le_bytes());
        expected.extend([1, 0, 0, 0, 7, 0, 0, 0]); // length, element
        expected.extend([8, 0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0]); // a fixed array has no length
        assert_eq!(encode(&named), expected);
        assert_eq!(decode::<Named>(&expected).unwrap(), named);
    }

    fn refusal<T: DeserializeOwned + std::fmt::Debug>(bytes: &[u8]) -> String {
        decode::<T>(bytes).unwrap_err().to_string()
    }

    #[test]
    fn an_invalid_message_is_rejected_with_its_content() {
        assert_mentions(&refusal::<u8>(&[0, 1]), "2 bytes .. 4");
        assert_mentions(&refusal::<u8>(&[0, 0, 0, 0, 1]), "header 00 00 .. 00 01");
        assert_mentions(&refusal::<u8>(&[0, 1, 0, 0, 1, 2]), "1 bytes .. after the end");
        assert_mentions(&refusal::<u32>(&[0, 1, 0, 0, 1, 2]), "body .. 2 bytes .. end of input");
        assert!(refusal::<u8>(&vec![0; MAX_BYTES + 1]).contains("allowed are at most"));
    }

    #[test]
    fn a_claimed_length_takes_no_memory() {
        let bytes = [0, 1, 0, 0, 255, 255, 255, 255, 1, 2, 3, 4];
        assert!(refusal::<Vec<u32>>(&bytes).contains("unexpected end of input"));
        assert!(refusal::<Vec<u8>>(&bytes).contains("unexpected end of input"));
        assert!(refusal::<String>(&bytes).contains("unexpected end of input"));
        assert!(refusal::<Vec<PoseStamped>>(&bytes).contains("unexpected end of input"));
    }

    #[test]
    fn padding_that_the_header_declares_is_no_part_of_the_message() {
        assert_eq!(decode::<u8>(&[0, 1, 0, 3, 7, 0, 0, 0]).unwrap(), 7);
        assert!(decode::<u8>(&[0, 1, 0, 3, 7]).is_err());
    }
}
