//! The definitions of a file's topics that are repeated at its end.

use std::collections::VecDeque;
use std::io::{Read, Seek};

use mcap::records::{Record, op};
use mcap::{MAGIC, parse_record};

use super::RecordingError;
use super::chunk::MAX_RECORD_BYTES;
use super::layout::{self, PREFIX_BYTES};
use super::read::McapReader;

/// Of the footer: up to the checksum of the summary and of these bytes, and in all.
const CHECKED_BYTES: usize = PREFIX_BYTES + 16;
const FOOTER_BYTES: u64 = (CHECKED_BYTES + 4) as u64;

impl<R: Read + Seek> McapReader<R> {
    /// The definitions at the file's end; empty if the end is damaged.
    pub(super) fn definitions(&mut self) -> Result<VecDeque<Record<'static>>, RecordingError> {
        let summary = self.summary()?;
        let mut rest = summary.as_slice();
        let mut found = VecDeque::new();
        while let Some((opcode, body)) = layout::split(rest) {
            if matches!(opcode, op::SCHEMA | op::CHANNEL)
                && let Ok(record) = parse_record(opcode, body)
            {
                found.push_back(record.into_owned());
            }
            rest = &rest[PREFIX_BYTES + body.len()..];
        }
        Ok(found)
    }

    /// The records between the data and the footer.
    fn summary(&mut self) -> Result<Vec<u8>, RecordingError> {
        let footer_at = self.length.saturating_sub(FOOTER_BYTES + MAGIC.len() as u64);
        if footer_at == 0 || !self.is_magic_at(self.length - MAGIC.len() as u64)? {
            return Ok(Vec::new());
        }
        let bytes = self.read_at(footer_at, FOOTER_BYTES)?;
        let Some((op::FOOTER, body)) = layout::split(&bytes) else { return Ok(Vec::new()) };
        let Ok(Record::Footer(footer)) = parse_record(op::FOOTER, body) else { return Ok(Vec::new()) };
        let start = footer.summary_start;
        if start == 0 || start >= footer_at || footer_at - start > MAX_RECORD_BYTES {
            return Ok(Vec::new());
        }
        let summary = self.read_at(start, footer_at - start)?;
        let mut sum = crc32fast::Hasher::new();
        sum.update(&summary);
        sum.update(&bytes[..CHECKED_BYTES]);
        // 0 means that there is no checksum.
        let is_whole = footer.summary_crc == 0 || sum.finalize() == footer.summary_crc;
        Ok(if is_whole { summary } else { Vec::new() })
    }
}
