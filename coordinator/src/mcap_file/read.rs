//! Reads the intact records of an MCAP file that may be truncated or damaged anywhere.
//!
//! A length is never trusted: neither more than the rest of the file nor more than [`MAX_RECORD_BYTES`] is ever read. A
//! chunk counts only as a whole, if its checksum is right. Damaged parts are skipped, and reading continues with the
//! next record: behind the damaged one, or if its length cannot be trusted either, where one is found
//! ([`super::resume`]).

use std::collections::{BTreeSet, VecDeque};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use dragnet_files::open_plain;
use mcap::records::{Header, Record, op};
use mcap::{MAGIC, parse_record};

use super::chunk::{self, ChunkError, MAX_RECORD_BYTES};
use super::layout::{self, PREFIX_BYTES, Prefix};
use super::resume::start_in;
use super::{Ending, RecordingError};

/// Factor of the file's size that may be read for invalid records before the rest is given up: the work stays linear in
/// the size, for any content.
const MAX_VAIN_READS: u64 = 4;

/// Bytes that may be read in vain.
const fn patience(length: u64) -> u64 {
    length.saturating_mul(MAX_VAIN_READS)
}

/// Iterates over the intact records of the data section, those within chunks one by one. Indexes are skipped.
pub(crate) struct McapReader<R> {
    path: PathBuf,
    source: R,
    /// Position of the source.
    position: u64,
    file_bytes: u64,
    /// Where the recording ends at the latest: at the file's end, or where another recording begins.
    pub(super) length: u64,
    /// Position up to which the file has been read.
    pub(super) offset: u64,
    header: Header,
    /// Definitions that are repeated at the file's end.
    repeated: VecDeque<Record<'static>>,
    unpacked: Unpacked,
    /// Ids of the defined topics.
    pub(super) channels: BTreeSet<u16>,
    /// Messages so far.
    messages: u64,
    has_chunk: bool,
    /// The unsupported compression of a chunk.
    foreign: Option<ChunkError>,
    is_in_summary: bool,
    /// Bytes that may be read in vain.
    pub(super) patience: u64,
    damage: Damage,
    ending: Option<Ending>,
}

/// The records of a chunk, and the current position in them.
#[derive(Default)]
struct Unpacked {
    bytes: Vec<u8>,
    next: usize,
}

/// The skipped parts.
#[derive(Default)]
struct Damage {
    first: Option<String>,
    places: u64,
    bytes: u64,
    /// Messages that the index counts.
    messages: Option<u64>,
    /// Messages of topics that no definition is read of.
    without_topic: u64,
}

/// The content of a record of the file.
enum Content {
    /// A chunk's records, each with its prefix.
    Chunk(Vec<u8>),
    /// A single record.
    Record(Record<'static>),
}

impl McapReader<BufReader<File>> {
    /// Opens a file; later additions are not read.
    pub(crate) fn open(path: &Path) -> Result<Self, RecordingError> {
        let failed = |source| RecordingError::Read { path: path.to_owned(), source };
        let file = open_plain(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        super::foreign::check(path, &file)?;
        Self::new(path, BufReader::new(file), length)
    }
}

impl<R: Read + Seek> McapReader<R> {
    /// Reads a source of this length from its start.
    pub(crate) fn new(path: &Path, source: R, length: u64) -> Result<Self, RecordingError> {
        let mut reader = Self {
            path: path.to_owned(),
            source,
            position: 0,
            file_bytes: length,
            length,
            offset: 0,
            header: Header { profile: String::new(), library: String::new() },
            repeated: VecDeque::new(),
            unpacked: Unpacked::default(),
            channels: BTreeSet::new(),
            messages: 0,
            has_chunk: false,
            foreign: None,
            is_in_summary: false,
            patience: patience(length),
            damage: Damage::default(),
            ending: None,
        };
        reader.read_start()?;
        Ok(reader)
    }

    /// The file's header.
    pub(crate) const fn header(&self) -> &Header {
        &self.header
    }

    /// Bytes of the file.
    pub(crate) const fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// Bytes that could be read.
    pub(crate) const fn readable(&self) -> u64 {
        self.offset.saturating_sub(self.damage.bytes)
    }

    /// How the file ends, once it is read.
    pub(crate) fn ending(&self) -> Ending {
        let Damage { first, places, bytes, messages, without_topic } = &self.damage;
        match first {
            Some(reason) => Ending::Damaged {
                reason: reason.clone(),
                places: *places,
                lost_bytes: *bytes,
                lost_messages: *messages,
                messages_without_topic: *without_topic,
                is_cut_off: matches!(self.ending, None | Some(Ending::CutOff)),
            },
            None => self.ending.clone().unwrap_or(Ending::CutOff),
        }
    }

    fn read_start(&mut self) -> Result<(), RecordingError> {
        let not = |path: &Path, found: &str| RecordingError::NotARecording {
            path: path.to_owned(),
            found: found.to_owned(),
        };
        if self.length == 0 {
            return Err(not(&self.path, "the file is empty"));
        }
        let start = MAGIC.len() as u64;
        let is_begun = self.is_magic_at(0)?;
        if is_begun && let Some((header, end)) = self.header_at(start)? {
            (self.header, self.offset) = (header, end);
            return Ok(());
        }
        // A file with the right ending has a damaged beginning.
        let is_one = is_begun || self.is_magic_at(self.length.saturating_sub(start))?;
        if is_one && let Some(next) = self.find_record(start)? {
            return self.lose(next, "the header is damaged");
        }
        let found = if is_begun {
            "it ends, or is damaged, before its first record"
        } else {
            "it does not begin like an MCAP file"
        };
        Err(not(&self.path, found))
    }

    /// The header at this position, and its end.
    fn header_at(&mut self, start: u64) -> Result<Option<(Header, u64)>, RecordingError> {
        let end = self.prefix_at(start)?.and_then(|prefix| prefix.end(start));
        let Some(end) = end.filter(|end| *end <= self.length && end - start <= MAX_RECORD_BYTES) else {
            return Ok(None);
        };
        let frame = self.read_at(start, end - start)?;
        let (opcode, body) = (frame[0], &frame[PREFIX_BYTES..]);
        if opcode == op::HEADER
            && layout::fits(opcode, body)
            && let Ok(Record::Header(header)) = parse_record(opcode, body)
        {
            return Ok(Some((header, end)));
        }
        Ok(None)
    }

    /// Reads bytes at a position, all of which the file has.
    pub(super) fn read_at(&mut self, offset: u64, count: u64) -> Result<Vec<u8>, RecordingError> {
        let path = &self.path;
        let failed = |source: io::Error| RecordingError::Read { path: path.clone(), source };
        if self.position != offset {
            self.source.seek(SeekFrom::Start(offset)).map_err(failed)?;
            self.position = offset;
        }
        let mut bytes = Vec::new();
        self.source.by_ref().take(count).read_to_end(&mut bytes).map_err(failed)?;
        self.position += bytes.len() as u64;
        if bytes.len() as u64 == count {
            return Ok(bytes);
        }
        // The file has become shorter since it was opened.
        Err(failed(io::ErrorKind::UnexpectedEof.into()))
    }

    /// The prefix of a record at this position; `None` if the file is too short.
    pub(super) fn prefix_at(&mut self, offset: u64) -> Result<Option<Prefix>, RecordingError> {
        if self.length.saturating_sub(offset) < PREFIX_BYTES as u64 {
            return Ok(None);
        }
        let bytes = self.read_at(offset, PREFIX_BYTES as u64)?;
        Ok(bytes.first_chunk().map(|bytes| Prefix::read(*bytes)))
    }

    pub(super) fn is_magic_at(&mut self, offset: u64) -> Result<bool, RecordingError> {
        let count = MAGIC.len() as u64;
        Ok(self.length.saturating_sub(offset) >= count && self.read_at(offset, count)? == MAGIC)
    }

    /// Reads one record of the file, or finds the file's end.
    fn advance(&mut self) -> Result<(), RecordingError> {
        let Some(prefix) = self.prefix_at(self.offset)? else {
            self.ending = Some(Ending::CutOff);
            return Ok(());
        };
        let Some(end) = prefix.end(self.offset).filter(|end| *end <= self.length) else {
            return self.resume_after_length(prefix.body_bytes);
        };
        let (is_filled, content, other) = if prefix.body_bytes > MAX_RECORD_BYTES {
            let bytes = prefix.body_bytes;
            let reason = format!("a record of {bytes} bytes; allowed are at most {MAX_RECORD_BYTES}");
            (false, Err(reason), self.find_start(self.offset, end)?)
        } else {
            let frame = self.read_at(self.offset, end - self.offset)?;
            let body = &frame[PREFIX_BYTES..];
            // A message may have any length.
            let is_filled = prefix.opcode != op::MESSAGE && layout::fills(prefix.opcode, body);
            let content = self.content(prefix.opcode, body);
            // The sum of a chunk is right: it is whole, whatever its bytes look like.
            let other = if matches!(content, Ok(Content::Chunk(_))) { None } else { start_in(&frame) };
            (is_filled, content, other.map(|place| self.offset + place as u64))
        };
        if let Some(other) = other {
            return self.end_before(other);
        }
        match content {
            Ok(content) if is_filled || self.is_followed(end)? => {
                self.offset = end;
                self.accept(content)
            }
            Err(reason) if self.is_followed(end)? => self.lose(end, &reason),
            // Its end cannot be trusted.
            content => {
                self.patience = self.patience.saturating_sub(end - self.offset);
                self.resume(content.err().as_deref().unwrap_or("a record is followed by none"))
            }
        }
    }

    /// If a record claims more than the rest of the file, the file was truncated or the length is damaged.
    fn resume_after_length(&mut self, claimed: u64) -> Result<(), RecordingError> {
        if !self.skip(&format!("a record claims {claimed} bytes, more than the file has"))? {
            self.ending = Some(Ending::CutOff);
        }
        Ok(())
    }

    /// Continues at the next record that is found; if there is none, the rest is lost.
    fn resume(&mut self, reason: &str) -> Result<(), RecordingError> {
        if self.skip(reason)? { Ok(()) } else { self.lose(self.length, reason) }
    }

    /// Loses what is before the next record, or before another recording that begins earlier; returns whether there is
    /// either.
    fn skip(&mut self, reason: &str) -> Result<bool, RecordingError> {
        let next = self.find_record(self.offset + 1)?;
        match (self.find_start(self.offset, next.unwrap_or(self.length))?, next) {
            (Some(other), _) => self.end_before(other)?,
            (None, Some(next)) => self.lose(next, reason)?,
            (None, None) => return Ok(false),
        }
        Ok(true)
    }

    /// Ends where another recording begins: two files were joined, and the first was cut off. The records of the second
    /// mean nothing in this one.
    fn end_before(&mut self, other: u64) -> Result<(), RecordingError> {
        self.length = other;
        self.ending = Some(Ending::CutOff);
        let from = other + 1;
        self.lose(
            other,
            &format!(
                "another recording begins at byte {other} and is not read; `tail -c +{from} FILE > OTHER` makes a file \
                 of it"
            ),
        )
    }

    /// Skips everything up to a position.
    fn lose(&mut self, next: u64, reason: &str) -> Result<(), RecordingError> {
        self.damage.bytes += next - self.offset;
        let at = self.offset;
        self.offset = next;
        self.note(format!("at byte {at}: {reason}"))
    }

    fn note(&mut self, reason: String) -> Result<(), RecordingError> {
        self.damage.places += 1;
        if self.damage.first.is_none() {
            self.damage.first = Some(reason);
            // The lost part may have defined the topics of the following messages.
            self.repeated = self.definitions()?;
        }
        Ok(())
    }

    fn content(&mut self, opcode: u8, body: &[u8]) -> Result<Content, String> {
        if !layout::fits(opcode, body) {
            return Err(format!("a record of kind {opcode} has no room for what it claims"));
        }
        // A single bit; behind a chunk an index is expected, and messages are within chunks.
        if opcode == op::MESSAGE && self.has_chunk && layout::fills(op::MESSAGE_INDEX, body) {
            return Err("a message that is an index".to_owned());
        }
        match parse_record(opcode, body).map_err(|error| error.to_string())? {
            Record::Chunk { header, data } => match chunk::unpack(&header, &data) {
                Ok(bytes) => Ok(Content::Chunk(bytes)),
                Err(error) => {
                    let reason = error.to_string();
                    if matches!(error, ChunkError::Compression(_)) {
                        self.foreign.get_or_insert(error);
                    }
                    Err(reason)
                }
            },
            record => Ok(Content::Record(record.into_owned())),
        }
    }

    fn accept(&mut self, content: Content) -> Result<(), RecordingError> {
        match content {
            Content::Chunk(bytes) => {
                self.has_chunk = true;
                self.unpacked = Unpacked { bytes, next: 0 };
            }
            Content::Record(Record::DataEnd(_)) => self.is_in_summary = true,
            Content::Record(Record::Footer(_)) => {
                if self.is_magic_at(self.offset)? {
                    self.offset += MAGIC.len() as u64;
                    return self.end();
                }
                self.ending = Some(Ending::CutOff);
            }
            Content::Record(Record::Statistics(reported)) => {
                let (reported, found) = (reported.message_count, self.messages);
                self.damage.messages = reported.checked_sub(found);
                if reported != found && self.damage.first.is_none() {
                    return self.note(format!("its index counts {reported} messages, {found} are there"));
                }
            }
            Content::Record(record) => {
                if !self.is_in_summary {
                    self.repeated.push_back(record);
                }
            }
        }
        Ok(())
    }

    /// Where the recording is finished, the file should end too.
    fn end(&mut self) -> Result<(), RecordingError> {
        let (at_byte, bytes) = (self.offset, self.length.saturating_sub(self.offset));
        self.ending = Some(if bytes == 0 { Ending::Complete } else { Ending::Followed { at_byte, bytes } });
        if bytes > 0 && self.damage.first.is_some() {
            return self.lose(self.length, &format!("{bytes} bytes follow the end"));
        }
        Ok(())
    }

    /// The next record of the current chunk. In a chunk without checksum a record may be damaged.
    fn take_unpacked(&mut self) -> Result<Option<Record<'static>>, RecordingError> {
        let Unpacked { bytes, next } = &self.unpacked;
        let rest = &bytes[*next..];
        if rest.is_empty() {
            return Ok(None);
        }
        let frame = layout::split(rest);
        let record = frame.and_then(|(opcode, body)| parse_record(opcode, body).ok().map(Record::into_owned));
        self.unpacked.next = match frame {
            Some((_, body)) => next + PREFIX_BYTES + body.len(),
            None => bytes.len(),
        };
        if record.is_none() {
            self.note(format!("before byte {}: a record of a chunk is not whole", self.offset))?;
        }
        Ok(record)
    }

    /// The next record, if there is one left.
    fn step(&mut self) -> Result<Option<Record<'static>>, RecordingError> {
        loop {
            if let Some(record) = self.repeated.pop_front() {
                return Ok(Some(record));
            }
            if let Some(record) = self.take_unpacked()? {
                return Ok(Some(record));
            }
            if self.unpacked.next < self.unpacked.bytes.len() || !self.repeated.is_empty() {
                continue;
            }
            if self.ending.is_some() {
                return Ok(None);
            }
            self.advance()?;
            if self.ending.is_some()
                && !self.has_chunk
                && let Some(ChunkError::Compression(compression)) = self.foreign.take()
            {
                return Err(RecordingError::Compression { path: self.path.clone(), compression });
            }
        }
    }
}

impl<R: Read + Seek> Iterator for McapReader<R> {
    type Item = Result<Record<'static>, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        let step = self.step();
        match &step {
            Ok(Some(Record::Message { header, .. })) => {
                self.messages += 1;
                self.damage.without_topic += u64::from(!self.channels.contains(&header.channel_id));
            }
            Ok(Some(Record::Channel(channel))) => {
                self.channels.insert(channel.id);
            }
            Err(_) => self.ending = Some(Ending::CutOff),
            Ok(_) => {}
        }
        step.transpose()
    }
}

#[cfg(test)]
mod tests {
    use mcap::WriteOptions;

    use super::*;

    /// As written by `ros2 bag record` with its preset `fastwrite`: one chunk, neither compressed nor with a checksum.
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

    /// Number of messages read, and the ending.
    fn read(bytes: &[u8]) -> Option<(usize, Ending)> {
        let mut reader =
            McapReader::new(Path::new("chatter.mcap"), io::Cursor::new(bytes), bytes.len() as u64).ok()?;
        let messages = (&mut reader).filter(|record| matches!(record, Ok(Record::Message { .. }))).count();
        Some((messages, reader.ending()))
    }

    #[test]
    fn chunks_without_checksum_are_read_as_far_as_possible() {
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
