//! Writes an MCAP file so that a crash leaves a file that ends cleanly after its last chunk.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

use dragnet_ros2::{cdr, schema};
use mcap::records::{AttachmentHeader, MessageHeader, SchemaHeader};
use mcap::write::{Metadata, NoSeek};
use mcap::{Attachment, Compression, McapError, McapResult, WriteOptions, Writer};

use super::RecordingError;
use super::patient::{Patient, Watch};

/// Bytes of a chunk before compression.
const CHUNK_BYTES: u64 = 512 * 1024;

/// An MCAP file in progress. Dropping it finishes the file.
pub(crate) struct McapWriter<W: Write> {
    path: PathBuf,
    writer: Writer<NoSeek<BufWriter<W>>>,
}

/// The same for a writer that must not wait for the disk.
pub(crate) struct LiveMcapWriter {
    writer: McapWriter<Patient<File>>,
    disk: Watch<File>,
}

impl LiveMcapWriter {
    /// Creates the file; an existing one is not overwritten.
    pub(crate) fn create(path: &Path, profile: &str, library: &str) -> Result<Self, RecordingError> {
        let file = File::create_new(path).map_err(|source| refusal(path, source))?;
        let (patient, disk) = Patient::new(file);
        Ok(Self { writer: McapWriter::new(path, patient, profile, library)?, disk })
    }

    /// Why the disk is not writable now, if so: data wait in memory.
    pub(crate) fn trouble(&self) -> Option<String> {
        self.disk.failure()
    }

    /// Ends the file with its index.
    pub(crate) fn finish(self) -> Result<(), RecordingError> {
        let path = self.writer.path.clone();
        self.writer.finish()?;
        let Some(reason) = self.disk.settle() else { return Ok(()) };
        let source = McapError::Io(io::Error::other(reason));
        Err(RecordingError::Write { path, what: "all that waited for room".into(), source })
    }
}

impl Deref for LiveMcapWriter {
    type Target = McapWriter<Patient<File>>;

    fn deref(&self) -> &Self::Target {
        &self.writer
    }
}

impl DerefMut for LiveMcapWriter {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.writer
    }
}

impl McapWriter<File> {
    /// Creates the file; an existing one is not overwritten.
    pub(crate) fn create(path: &Path, profile: &str, library: &str) -> Result<Self, RecordingError> {
        let file = File::create_new(path).map_err(|source| refusal(path, source))?;
        Self::new(path, file, profile, library)
    }
}

fn refusal(path: &Path, source: io::Error) -> RecordingError {
    let path = path.to_owned();
    match source.kind() {
        ErrorKind::AlreadyExists => RecordingError::Exists { path },
        _ => RecordingError::Create { path, source },
    }
}

impl<W: Write> McapWriter<W> {
    fn new(path: &Path, file: W, profile: &str, library: &str) -> Result<Self, RecordingError> {
        Self::with_options(path, file, options(profile, library))
    }

    /// Without compression, for what is compressed as a whole.
    pub(crate) fn plain(path: &Path, file: W, profile: &str, library: &str) -> Result<Self, RecordingError> {
        Self::with_options(path, file, options(profile, library).compression(None))
    }

    fn with_options(path: &Path, file: W, options: WriteOptions) -> Result<Self, RecordingError> {
        let writer = options.create(NoSeek::new(BufWriter::new(file)));
        let writer = writer.map_err(|source| RecordingError::Write {
            path: path.to_owned(),
            what: "the header".into(),
            source,
        })?;
        Ok(Self { path: path.to_owned(), writer })
    }

    fn named<T>(&self, result: McapResult<T>, what: impl FnOnce() -> String) -> Result<T, RecordingError> {
        result.map_err(|source| RecordingError::Write { path: self.path.clone(), what: what(), source })
    }

    /// Adds a topic with its message's definition; returns its channel.
    pub(crate) fn add_topic(
        &mut self,
        topic: &str,
        (name, text): (&str, &str),
        metadata: &BTreeMap<String, String>,
    ) -> Result<u16, RecordingError> {
        let channel = self
            .writer
            .add_schema(name, schema::ENCODING, text.as_bytes())
            .and_then(|id| self.writer.add_channel(id, topic, cdr::ENCODING, metadata));
        self.named(channel, || format!("the topic {topic}"))
    }

    /// Adds a message's definition under the id of another file.
    pub(crate) fn copy_schema(&mut self, header: &SchemaHeader, data: &[u8]) -> Result<(), RecordingError> {
        let added = self.writer.add_schema_with_id(header.id, &header.name, &header.encoding, data);
        self.named(added.map(drop), || format!("the definition of {}", header.name))
    }

    /// Adds a topic under the id of another file.
    pub(crate) fn copy_channel(&mut self, channel: &mcap::records::Channel) -> Result<(), RecordingError> {
        let mcap::records::Channel { id, schema_id, topic, message_encoding, metadata } = channel;
        let added = self.writer.add_channel_with_id(*id, *schema_id, topic, message_encoding, metadata);
        self.named(added.map(drop), || format!("the topic {topic}"))
    }

    /// Adds a message of a known channel.
    pub(crate) fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<(), RecordingError> {
        let written = self.writer.write_to_known_channel(header, data);
        self.named(written, || format!("message {} of channel {}", header.sequence, header.channel_id))
    }

    /// Attaches a file.
    pub(crate) fn attach(&mut self, header: &AttachmentHeader, data: &[u8]) -> Result<(), RecordingError> {
        let written = self.writer.attach(&Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name.clone(),
            media_type: header.media_type.clone(),
            data: data.into(),
        });
        self.named(written, || format!("the attachment {}", header.name))
    }

    /// Adds named facts.
    pub(crate) fn metadata(&mut self, metadata: &Metadata) -> Result<(), RecordingError> {
        let written = self.writer.write_metadata(metadata);
        self.named(written, || format!("the metadata {}", metadata.name))
    }

    /// Ends the chunk and passes everything to the operating system, so that a crash of this process loses nothing of
    /// it.
    pub(crate) fn flush(&mut self) -> Result<(), RecordingError> {
        let flushed = self.writer.flush();
        self.named(flushed, || "a chunk".into())
    }

    /// Ends the file with its index.
    pub(crate) fn finish(mut self) -> Result<(), RecordingError> {
        let finished = self.writer.finish();
        self.named(finished.map(drop), || "the index at the end".into())
    }
}

/// One thread compresses, so that the same messages make the same bytes on every machine.
fn options(profile: &str, library: &str) -> WriteOptions {
    WriteOptions::new()
        .profile(profile)
        .library(library)
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::super::read::McapReader;
    use super::*;

    const ROOM_BYTES: usize = 60_000;

    /// A disk with limited space.
    #[derive(Clone, Default)]
    struct Disk(Arc<Mutex<Vec<u8>>>);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut disk = self.0.lock().unwrap();
            let room = ROOM_BYTES - disk.len();
            if room == 0 {
                return Err(ErrorKind::StorageFull.into());
            }
            let bytes = &bytes[..bytes.len().min(room)];
            disk.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Random bytes, which do not compress.
    fn noise(seed: u64) -> Vec<u8> {
        let next = |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
        std::iter::successors(Some(seed), next)
            .skip(1)
            .take(1000)
            .map(|state| state.to_be_bytes()[0])
            .collect()
    }

    #[test]
    fn a_full_disk_is_an_error_that_names_the_file_and_keeps_the_written_part() {
        let disk = Disk::default();
        let path = Path::new("field/today.mcap");
        let mut file = McapWriter::new(path, disk.clone(), "ros2", "test").unwrap();
        let channel_id = file.add_topic("/noise", ("a/msg/Noise", "uint8 noise"), &BTreeMap::new()).unwrap();
        let mut flushed = 0;
        let error = loop {
            let header = MessageHeader { channel_id, sequence: flushed, log_time: 0, publish_time: 0 };
            let result = file.message(&header, &noise(u64::from(flushed))).and_then(|()| file.flush());
            match result {
                Ok(()) => flushed += 1,
                Err(error) => break error,
            }
        };
        let RecordingError::Write { path: named, .. } = &error else { panic!("{error}") };
        assert_eq!(named, path);
        assert!(error.to_string().starts_with("field/today.mcap: cannot write a chunk: "), "{error}");
        drop(file);
        let bytes = disk.0.lock().unwrap().clone();
        let length = bytes.len() as u64;
        let reader = McapReader::new(path, io::Cursor::new(bytes), length).unwrap();
        let kept =
            reader.filter(|record| matches!(record, Ok(mcap::records::Record::Message { .. }))).count();
        assert!(flushed > 40, "{flushed}");
        assert_eq!(kept, usize::try_from(flushed).unwrap());
    }
}
