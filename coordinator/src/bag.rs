//! ROS 2 bags as recorded by `ros2 bag record --storage mcap`.

use std::collections::BTreeMap;
use std::fs::{DirEntry, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::Record;

use crate::mcap_file::read::McapReader;
use crate::mcap_file::{Ending, RecordingError, foreign};

/// Iterates over the messages of a recording in file order, until the first incomplete record. Each file of a split bag
/// is a recording.
pub struct Bag {
    reader: McapReader<BufReader<File>>,
    /// Names of message definitions, by schema id.
    schemas: BTreeMap<u16, String>,
    topics: BTreeMap<u16, Arc<BagTopic>>,
}

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagTopic {
    /// Its name, with a leading slash.
    pub name: String,
    /// The type of its messages, such as `nav_msgs/msg/Odometry`.
    pub message: String,
    /// Their encoding: `cdr` for ROS 2.
    pub encoding: String,
}

/// A message of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagMessage {
    /// Its topic.
    pub topic: Arc<BagTopic>,
    /// When it was recorded, Unix nanoseconds.
    pub received_unix_ns: u64,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Bag {
    /// Opens a recording, or the one in a bag's folder.
    ///
    /// # Errors
    /// If it cannot be read, is not an MCAP file, or is a folder without exactly one.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let reader = if path.is_dir() { McapReader::open(&only(path)?) } else { McapReader::open(path) };
        Ok(Self { reader: reader?, schemas: BTreeMap::new(), topics: BTreeMap::new() })
    }

    /// How the recording ends, once all of it is read.
    #[must_use]
    pub fn ending(&self) -> Ending {
        self.reader.ending()
    }
}

impl Iterator for Bag {
    type Item = Result<BagMessage, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.reader.next()? {
                Ok(Record::Schema { header, .. }) => {
                    self.schemas.insert(header.id, header.name);
                }
                Ok(Record::Channel(channel)) => {
                    let message = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let (name, encoding) = (channel.topic, channel.message_encoding);
                    self.topics.insert(channel.id, Arc::new(BagTopic { name, message, encoding }));
                }
                Ok(Record::Message { header, data }) => {
                    // A message without a known topic is skipped.
                    let Some(topic) = self.topics.get(&header.channel_id) else { continue };
                    let (topic, bytes) = (Arc::clone(topic), data.into_owned());
                    return Some(Ok(BagMessage { topic, received_unix_ns: header.log_time, bytes }));
                }
                Ok(_) => {}
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// The recording in a bag's folder.
fn only(folder: &Path) -> Result<PathBuf, RecordingError> {
    let failed = |source| RecordingError::Read { path: folder.to_owned(), source };
    let entries = folder.read_dir().map_err(failed)?.collect::<Result<Vec<_>, _>>().map_err(failed)?;
    let of_kind = |kind: &str| -> Vec<PathBuf> {
        let paths = entries.iter().map(DirEntry::path);
        paths.filter(|path| path.extension().is_some_and(|extension| extension == kind)).collect()
    };
    match of_kind("mcap").as_slice() {
        [recording] => Ok(recording.clone()),
        [] if !of_kind("db3").is_empty() => Err(foreign::sqlite(folder)),
        others => {
            let found = format!("a folder with {} recordings (.mcap); of many name one", others.len());
            Err(RecordingError::NotARecording { path: folder.to_owned(), found })
        }
    }
}
