//! Repairs a truncated or damaged recording: all intact parts are copied to a new, complete file.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::io::{Read, Seek};
use std::path::Path;

use mcap::McapError;
use mcap::records::Record;
use mcap::write::Metadata;
use serde::Serialize;

use crate::mcap_file::read::McapReader;
use crate::mcap_file::write::McapWriter;
use crate::mcap_file::{Ending, RecordingError};

/// The result of a recovery.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovered {
    /// How the damaged recording ends.
    pub ending: Ending,
    /// Its size, bytes.
    pub file_bytes: u64,
    /// Its readable part, bytes.
    pub readable_bytes: u64,
    /// Messages copied.
    pub messages: u64,
    /// Messages skipped because their topic is unknown.
    pub messages_without_topic: u64,
    /// Attached files copied.
    pub attachments: u64,
    /// Metadata copied.
    pub metadata: u64,
}

/// Copies all intact parts of one recording, messages, definitions, attached files and metadata, to a new one.
///
/// # Errors
/// If the recording cannot be read or is not an MCAP file; if the new file exists already, as the recording itself
/// does, or cannot be written: then it is removed.
pub fn recover(from: &Path, to: &Path) -> Result<Recovered, RecordingError> {
    let reader = McapReader::open(from)?;
    let header = reader.header();
    let writer = McapWriter::create(to, &header.profile, &header.library)?;
    let recovered = copy(reader, writer);
    if recovered.is_err() {
        // The failure itself is reported; a failure to remove the remains is not.
        let _ = fs::remove_file(to);
    }
    recovered
}

fn copy<R: Read + Seek>(
    mut reader: McapReader<R>,
    mut writer: McapWriter<fs::File>,
) -> Result<Recovered, RecordingError> {
    let mut recovered = Recovered {
        ending: Ending::CutOff,
        file_bytes: reader.file_bytes(),
        readable_bytes: 0,
        messages: 0,
        messages_without_topic: 0,
        attachments: 0,
        metadata: 0,
    };
    let (mut schemas, mut channels) = (BTreeSet::new(), BTreeSet::new());
    for record in &mut reader {
        match record? {
            Record::Schema { header, data } => {
                let is_new = is_new(writer.copy_schema(&header, &data))?;
                schemas.extend(is_new.then_some(header.id));
            }
            Record::Channel(mut channel) => {
                if !schemas.contains(&channel.schema_id) {
                    // Its definition is lost. 0 means that there is none; its messages are intact.
                    channel.schema_id = 0;
                }
                if is_new(writer.copy_channel(&channel))? {
                    channels.insert(channel.id);
                }
            }
            Record::Message { header, data } if channels.contains(&header.channel_id) => {
                writer.message(&header, &data)?;
                recovered.messages += 1;
            }
            Record::Message { .. } => recovered.messages_without_topic += 1,
            Record::Attachment { header, data, .. } => {
                writer.attach(&header, &data)?;
                recovered.attachments += 1;
            }
            Record::Metadata(Metadata { name, metadata }) => {
                writer.metadata(&Metadata { name, metadata })?;
                recovered.metadata += 1;
            }
            _ => {}
        }
    }
    writer.finish()?;
    recovered.ending = reader.ending();
    recovered.readable_bytes = reader.readable();
    Ok(recovered)
}

/// Whether a definition was added. One that contradicts an earlier one of its id, as a damaged one may, is skipped.
fn is_new(copied: Result<(), RecordingError>) -> Result<bool, RecordingError> {
    match copied {
        Err(RecordingError::Write {
            source:
                McapError::ConflictingSchemas(_) | McapError::ConflictingChannels(_) | McapError::InvalidSchemaId,
            ..
        }) => Ok(false),
        copied => copied.map(|()| true),
    }
}

impl fmt::Display for Recovered {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { messages, attachments, metadata, readable_bytes, file_bytes, .. } = self;
        write!(
            formatter,
            "recovered {messages} messages, {attachments} attachments and {metadata} metadata records from \
             {readable_bytes} of {file_bytes} bytes; "
        )?;
        match &self.ending {
            Ending::Complete => formatter.write_str("the recording was complete")?,
            Ending::CutOff => formatter.write_str("there it is cut off")?,
            ending @ (Ending::Damaged { .. } | Ending::Followed { .. }) => {
                write!(formatter, "it is {ending}")?;
            }
        }
        if self.messages_without_topic > 0 && !matches!(self.ending, Ending::Damaged { .. }) {
            write!(formatter, "; left out {} messages of unknown topics", self.messages_without_topic)?;
        }
        Ok(())
    }
}
