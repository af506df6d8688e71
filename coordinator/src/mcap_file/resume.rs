//! Finds the next record after a damaged length.
//!
//! Records follow each other, each with its length. If a length is damaged, the next record is searched byte by byte: a
//! known kind, a length that fits the file, parts that fill it, and another record behind it. In compressed bytes this
//! does not occur by chance; in uncompressed ones, records within a damaged chunk may be found, which are records as
//! well.

use std::io::{Read, Seek};

use mcap::MAGIC;
use mcap::records::op;

use super::RecordingError;
use super::chunk::MAX_RECORD_BYTES;
use super::layout::{self, PREFIX_BYTES, Prefix};
use super::read::McapReader;

/// Bytes that are searched at once.
const WINDOW_BYTES: u64 = 1 << 16;
/// Bytes that begin a recording: the magic, and the kind of the first record.
const START_BYTES: usize = MAGIC.len() + 1;

impl<R: Read + Seek> McapReader<R> {
    /// The position of the first record from here on, if any.
    pub(super) fn find_record(&mut self, from: u64) -> Result<Option<u64>, RecordingError> {
        let mut start = from;
        while self.length.saturating_sub(start) >= PREFIX_BYTES as u64 {
            let window = self.read_at(start, WINDOW_BYTES.min(self.length - start))?;
            for (place, bytes) in (start..).zip(window.windows(PREFIX_BYTES)) {
                let Some(prefix) = bytes.first_chunk().map(|bytes| Prefix::read(*bytes)) else { continue };
                if is_candidate(prefix, place, self.length) && self.is_record(place, prefix)? {
                    return Ok(Some(place));
                }
                if self.patience == 0 {
                    return Ok(None);
                }
            }
            start += window.len() as u64 - (PREFIX_BYTES as u64 - 1);
        }
        Ok(None)
    }

    /// The position of the first start of a recording within a range, if any.
    pub(super) fn find_start(&mut self, from: u64, to: u64) -> Result<Option<u64>, RecordingError> {
        let mut start = from;
        while to.saturating_sub(start) >= START_BYTES as u64 {
            let window = self.read_at(start, WINDOW_BYTES.min(to - start))?;
            if let Some(place) = start_in(&window) {
                return Ok(Some(start + place as u64));
            }
            start += (window.len() - (START_BYTES - 1)) as u64;
        }
        Ok(None)
    }

    /// Whether another record follows at a position, or the file ends there.
    pub(super) fn is_followed(&mut self, place: u64) -> Result<bool, RecordingError> {
        match self.prefix_at(place)? {
            _ if place == self.length => Ok(true),
            Some(prefix) if is_candidate(prefix, place, self.length) => {
                Ok(self.filled(place, prefix)?.is_some())
            }
            _ => Ok(false),
        }
    }

    fn is_record(&mut self, place: u64, prefix: Prefix) -> Result<bool, RecordingError> {
        let Some(end) = self.filled(place, prefix)? else { return Ok(false) };
        match prefix.opcode {
            op::FOOTER => self.is_magic_at(end),
            // Its own fields are sufficient.
            op::CHUNK => Ok(true),
            _ => self.is_followed(end),
        }
    }

    /// The end of the record at a position, if its parts fill it.
    fn filled(&mut self, place: u64, prefix: Prefix) -> Result<Option<u64>, RecordingError> {
        let Some(end) = prefix.end(place) else { return Ok(None) };
        self.patience = self.patience.saturating_sub(end - place);
        if self.patience == 0 {
            return Ok(None);
        }
        let frame = self.read_at(place, end - place)?;
        let body = &frame[PREFIX_BYTES..];
        let has_subscriber = prefix.opcode != op::MESSAGE
            || body.first_chunk().is_some_and(|id| self.channels.contains(&u16::from_le_bytes(*id)));
        Ok((has_subscriber && layout::fills(prefix.opcode, body)).then_some(end))
    }
}

/// The first place where bytes begin a recording. The magic ends one too; only a header begins one.
pub(super) fn start_in(bytes: &[u8]) -> Option<usize> {
    let is_start = |bytes: &[u8]| bytes.strip_prefix(MAGIC) == Some(&[op::HEADER]);
    bytes.windows(START_BYTES).position(is_start)
}

/// Whether a record of a known kind, other than the first of a file, fits there.
fn is_candidate(prefix: Prefix, place: u64, length: u64) -> bool {
    let is_known = (op::FOOTER..=op::DATA_END).contains(&prefix.opcode);
    let has_room = prefix.end(place).is_some_and(|end| end <= length);
    is_known && has_room && prefix.body_bytes <= MAX_RECORD_BYTES
}
