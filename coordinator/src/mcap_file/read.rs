//! Reads the whole records of an MCAP file that may end anywhere.
//!
//! A length is never trusted: neither more than the file has left nor more than [`MAX_RECORD_BYTES`] is ever read. A
//! chunk counts only as a whole, when its checksum is right.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use mcap::records::{Header, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, McapResult, parse_record};
use serde::Serialize;

use super::RecordingError;

/// The longest record or unpacked chunk: four times the belief of the largest map.
const MAX_RECORD_BYTES: usize = 256 << 20;
/// What a record begins with: its kind, 1 byte, and its length, 8.
const PREFIX_BYTES: usize = 9;

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Ending {
    /// It was finished.
    Complete,
    /// Whoever wrote it was stopped, or the end is lost.
    CutOff,
    /// A record cannot be right.
    Damaged {
        /// Why.
        reason: String,
    },
}

/// A record as it stands in the file.
struct Frame {
    opcode: u8,
    /// With its prefix.
    bytes: Vec<u8>,
}

impl Frame {
    fn body(&self) -> &[u8] {
        &self.bytes[PREFIX_BYTES..]
    }
}

/// Iterates over the records of the data section, those within chunks one by one, until the first that is not whole.
/// Indexes are skipped.
pub(crate) struct McapReader<R> {
    path: PathBuf,
    source: R,
    length: u64,
    /// Where the last whole record ends.
    offset: u64,
    header: Header,
    unpacked: VecDeque<Record<'static>>,
    /// Messages so far.
    messages: u64,
    is_in_summary: bool,
    ending: Option<Ending>,
}

impl McapReader<BufReader<File>> {
    /// Opens a file; what is written to it later is not seen.
    pub(crate) fn open(path: &Path) -> Result<Self, RecordingError> {
        let failed = |source| RecordingError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        super::foreign::check(path, &file)?;
        Self::new(path, BufReader::new(file), length)
    }
}

impl<R: Read> McapReader<R> {
    /// Reads a source of so many bytes.
    pub(crate) fn new(path: &Path, source: R, length: u64) -> Result<Self, RecordingError> {
        let mut reader = Self {
            path: path.to_owned(),
            source,
            length,
            offset: 0,
            header: Header { profile: String::new(), library: String::new() },
            unpacked: VecDeque::new(),
            messages: 0,
            is_in_summary: false,
            ending: None,
        };
        reader.read_start()?;
        Ok(reader)
    }

    /// What the file says of itself.
    pub(crate) const fn header(&self) -> &Header {
        &self.header
    }

    /// Bytes of the file.
    pub(crate) const fn length(&self) -> u64 {
        self.length
    }

    /// Bytes up to the end of the last whole record.
    pub(crate) const fn readable(&self) -> u64 {
        self.offset
    }

    /// How the file ends, once all is read.
    pub(crate) fn ending(&self) -> Ending {
        self.ending.clone().unwrap_or(Ending::CutOff)
    }

    fn read_start(&mut self) -> Result<(), RecordingError> {
        let not = |path: &Path, found: &str| RecordingError::NotARecording {
            path: path.to_owned(),
            found: found.to_owned(),
        };
        if self.length == 0 {
            return Err(not(&self.path, "the file is empty"));
        }
        let magic = self.take(MAGIC.len())?;
        if magic.as_deref() != Some(MAGIC) {
            return Err(not(&self.path, "it does not begin like an MCAP file"));
        }
        self.offset = MAGIC.len() as u64;
        let record = self.frame()?.and_then(|frame| {
            self.offset += frame.bytes.len() as u64;
            parse_record(frame.opcode, frame.body()).ok().map(Record::into_owned)
        });
        match record {
            Some(Record::Header(header)) => self.header = header,
            _ => return Err(not(&self.path, "it ends, or is damaged, before it says anything")),
        }
        Ok(())
    }

    /// So many bytes; `None` if the file ends before.
    fn take(&mut self, count: usize) -> Result<Option<Vec<u8>>, RecordingError> {
        if count as u64 > self.length - self.offset {
            return Ok(None);
        }
        let mut bytes = vec![0; count];
        self.source.read_exact(&mut bytes).map_err(|source| self.failed(source))?;
        Ok(Some(bytes))
    }

    fn failed(&self, source: io::Error) -> RecordingError {
        RecordingError::Read { path: self.path.clone(), source }
    }

    /// The next record; `None` where the file ends, is cut off, or claims a length that cannot be.
    fn frame(&mut self) -> Result<Option<Frame>, RecordingError> {
        let Some(mut bytes) = self.take(PREFIX_BYTES)? else { return Ok(None) };
        let Some((&opcode, length)) = bytes.split_first() else { return Ok(None) };
        let length = length.try_into().map_or(u64::MAX, u64::from_le_bytes);
        let left = self.length - self.offset - PREFIX_BYTES as u64;
        let Some(length) = usize::try_from(length).ok().filter(|&length| length as u64 <= left) else {
            return Ok(None);
        };
        if length > MAX_RECORD_BYTES {
            let reason = format!("a record of {length} bytes; allowed are at most {MAX_RECORD_BYTES}");
            self.ending = Some(Ending::Damaged { reason });
            return Ok(None);
        }
        bytes.resize(PREFIX_BYTES + length, 0);
        self.source.read_exact(&mut bytes[PREFIX_BYTES..]).map_err(|source| self.failed(source))?;
        Ok(Some(Frame { opcode, bytes }))
    }

    /// Reads one record of the file into `unpacked`, or finds the file's end.
    fn advance(&mut self) -> Result<(), RecordingError> {
        let Some(frame) = self.frame()? else {
            self.ending.get_or_insert(Ending::CutOff);
            return Ok(());
        };
        if let Err(reason) =
            unpack(&frame).map_err(|error| error.to_string()).and_then(|found| self.accept(found))
        {
            self.ending = Some(Ending::Damaged { reason });
            return Ok(());
        }
        self.offset += frame.bytes.len() as u64;
        self.is_in_summary |= frame.opcode == op::DATA_END;
        if frame.opcode == op::FOOTER {
            let is_whole = self.take(MAGIC.len())?.as_deref() == Some(MAGIC);
            if is_whole {
                self.offset += MAGIC.len() as u64;
            }
            self.ending = Some(if is_whole { Ending::Complete } else { Ending::CutOff });
        }
        Ok(())
    }

    /// Takes in the records of the data section, and checks those of the summary against them.
    fn accept(&mut self, records: Vec<Record<'static>>) -> Result<(), String> {
        for record in records {
            match &record {
                Record::Message { .. } => self.messages += 1,
                Record::Statistics(told) if told.message_count != self.messages => {
                    let (told, found) = (told.message_count, self.messages);
                    return Err(format!("its index tells of {told} messages, {found} are there"));
                }
                _ => {}
            }
            if !self.is_in_summary {
                self.unpacked.push_back(record);
            }
        }
        Ok(())
    }
}

impl<R: Read> Iterator for McapReader<R> {
    type Item = Result<Record<'static>, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.unpacked.is_empty() && self.ending.is_none() {
            if let Err(error) = self.advance() {
                self.ending = Some(Ending::CutOff);
                return Some(Err(error));
            }
        }
        self.unpacked.pop_front().map(Ok)
    }
}

/// The records in a record: all of a chunk's, or the one that it is.
fn unpack(frame: &Frame) -> McapResult<Vec<Record<'static>>> {
    match frame.opcode {
        op::CHUNK => unpack_chunk(frame),
        op::ATTACHMENT if !attachment_fits(frame.body()) => Err(McapError::UnexpectedEof),
        opcode => Ok(vec![parse_record(opcode, frame.body())?.into_owned()]),
    }
}

fn unpack_chunk(frame: &Frame) -> McapResult<Vec<Record<'static>>> {
    let Record::Chunk { header, data } = parse_record(frame.opcode, frame.body())? else {
        return Ok(Vec::new());
    };
    // Without compression and checksum the crate trusts the lengths of the records within.
    if header.compression.is_empty() && header.uncompressed_crc == 0 {
        return unpack_plain(&data);
    }
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_RECORD_BYTES),
    );
    let mut rest = frame.bytes.as_slice();
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (given, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(given.len()).copy_from_slice(given);
                reader.notify_read(given.len());
                rest = later;
            }
            LinearReadEvent::Record { data, opcode } => {
                records.push(parse_record(opcode, data)?.into_owned());
            }
        }
    }
    Ok(records)
}

/// The records of a chunk that is neither compressed nor checked, as `ros2 bag record` writes them with its preset
/// `fastwrite`.
fn unpack_plain(mut data: &[u8]) -> McapResult<Vec<Record<'static>>> {
    let mut records = Vec::new();
    while let Some((&opcode, rest)) = data.split_first() {
        let (length, rest) = rest.split_first_chunk().ok_or(McapError::UnexpectedEof)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let (body, rest) = rest.split_at_checked(length).ok_or(McapError::UnexpectedEof)?;
        records.push(parse_record(opcode, body)?.into_owned());
        data = rest;
    }
    Ok(records)
}

/// Whether an attachment has room for what its lengths claim, as far as the crate trusts them: two times and two
/// texts, the length of the data, and a checksum at the end.
fn attachment_fits(body: &[u8]) -> bool {
    let text_end = |start: usize| {
        let end = start.checked_add(4)?;
        let length = body.get(start..end)?.try_into().map(u32::from_le_bytes).ok()?;
        end.checked_add(usize::try_from(length).ok()?)
    };
    let data_length_start = text_end(16).and_then(text_end);
    data_length_start.is_some_and(|start| start.saturating_add(8 + 4) <= body.len())
}

#[cfg(test)]
mod tests {
    use mcap::WriteOptions;

    use super::*;

    /// As `ros2 bag record` writes it with its preset `fastwrite`: one chunk, neither compressed nor checked.
    fn plain() -> Vec<u8> {
        let mut bytes = Vec::new();
        let options = WriteOptions::new().compression(None).calculate_chunk_crcs(false).profile("ros2");
        let mut writer = options.create(io::Cursor::new(&mut bytes)).unwrap();
        let schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data").unwrap();
        let channel_id =
            writer.add_channel(schema, "/chatter", "cdr", &std::collections::BTreeMap::new()).unwrap();
        for sequence in 0..3 {
            let header = mcap::records::MessageHeader { channel_id, sequence, log_time: 7, publish_time: 7 };
            writer.write_to_known_channel(&header, b"hello").unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        bytes
    }

    /// Messages read, and how it ended.
    fn read(bytes: &[u8]) -> Option<(usize, Ending)> {
        let mut reader = McapReader::new(Path::new("chatter.mcap"), bytes, bytes.len() as u64).ok()?;
        let messages = (&mut reader).filter(|record| matches!(record, Ok(Record::Message { .. }))).count();
        Some((messages, reader.ending()))
    }

    #[test]
    fn chunks_that_nobody_checked_are_read_as_far_as_they_can_be() {
        let bytes = plain();
        assert_eq!(read(&bytes), Some((3, Ending::Complete)));
        let mut damaged = 0;
        for (place, value) in (0..bytes.len()).flat_map(|place| [0, 0x7f, 0xff].map(|value| (place, value))) {
            let mut spoiled = bytes.clone();
            spoiled[place] = value;
            damaged += u32::from(matches!(read(&spoiled), Some((_, Ending::Damaged { .. }))));
        }
        assert!(damaged > 50, "{damaged}");
        for length in 0..bytes.len() {
            assert_ne!(read(&bytes[..length]).map(|(_, ending)| ending), Some(Ending::Complete));
        }
    }
}
