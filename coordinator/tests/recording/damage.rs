//! Recordings that are cut off or damaged, anywhere.

use std::fs;
use std::path::Path;

use dragnet_coordinator::inspect::inspect;
use dragnet_coordinator::recover::recover;
use dragnet_coordinator::{Ending, RecordingError};
use mcap::{MessageStream, Summary};
use tempfile::tempdir;

use crate::episode::{Episode, header};

/// A whole recording, and where its parts end as its own index says.
struct Whole {
    bytes: Vec<u8>,
    /// End of each chunk, and the messages in it.
    chunks: Vec<(usize, usize)>,
    attachment_ends: Vec<usize>,
    metadata_ends: Vec<usize>,
}

impl Whole {
    fn record(path: &Path) -> Self {
        Episode::play().record(path);
        let bytes = fs::read(path).unwrap();
        let summary = Summary::read(&bytes).unwrap().unwrap();
        let end = |offset: u64, length: u64| usize::try_from(offset + length).unwrap();
        let messages = |chunk| summary.stream_chunk(&bytes, chunk).unwrap().count();
        let chunks = summary.chunk_indexes.iter();
        Self {
            chunks: chunks
                .map(|chunk| (end(chunk.chunk_start_offset, chunk.chunk_length), messages(chunk)))
                .collect(),
            attachment_ends: summary
                .attachment_indexes
                .iter()
                .map(|part| end(part.offset, part.length))
                .collect(),
            metadata_ends: summary
                .metadata_indexes
                .iter()
                .map(|part| end(part.offset, part.length))
                .collect(),
            bytes,
        }
    }

    /// Messages in whole chunks, attachments and metadata up to a cut.
    fn until(&self, cut: usize) -> (usize, usize, usize) {
        let count = |ends: &[usize]| ends.iter().filter(|&&end| end <= cut).count();
        let messages = self.chunks.iter().filter(|(end, _)| *end <= cut).map(|(_, messages)| messages).sum();
        (messages, count(&self.attachment_ends), count(&self.metadata_ends))
    }
}

#[test]
fn whatever_is_whole_before_a_cut_is_recovered() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (cut_off, mended) = (folder.path().join("cut.mcap"), folder.path().join("mended.mcap"));
    let every = whole.bytes.len() / 250;
    let ends = whole.chunks.iter().flat_map(|&(end, _)| [end - 1, end, end + 1]);
    let mut refused = 0;
    for cut in (0..whole.bytes.len()).step_by(every).chain(ends) {
        fs::write(&cut_off, &whole.bytes[..cut]).unwrap();
        let recovered = match recover(&cut_off, &mended) {
            Ok(recovered) => recovered,
            Err(error) => {
                assert!(matches!(error, RecordingError::NotARecording { .. }), "cut at {cut}: {error}");
                assert!(whole.until(cut) == (0, 0, 0) && !mended.exists() && inspect(&cut_off).is_err());
                refused += 1;
                continue;
            }
        };
        let given = (recovered.messages, recovered.attachments, recovered.metadata);
        let (messages, attachments, metadata) = whole.until(cut);
        assert_eq!(given, (messages as u64, attachments as u64, metadata as u64), "cut at {cut}");
        assert_eq!(recovered.ending, Ending::CutOff);
        assert!(recovered.readable_bytes <= cut as u64 && recovered.messages_without_topic == 0);
        check_mended(&mended, &whole, messages);
        let (before, after) = (inspect(&cut_off).unwrap(), inspect(&mended).unwrap());
        assert_eq!((before.ending, after.ending), (Ending::CutOff, Ending::Complete));
        assert_eq!((before.topics, before.declared, before.run), (after.topics, after.declared, after.run));
        fs::remove_file(&mended).unwrap();
    }
    assert!((1..10).contains(&refused), "{refused} cuts before anything was said");
    assert!(whole.chunks.len() > 10);
}

/// The mended file holds the first messages of the whole one, under the same names.
fn check_mended(mended: &Path, whole: &Whole, count: usize) {
    let mended = fs::read(mended).unwrap();
    let given: Vec<_> = MessageStream::new(&mended).unwrap().map(Result::unwrap).collect();
    let expected: Vec<_> =
        MessageStream::new(&whole.bytes).unwrap().take(count).map(Result::unwrap).collect();
    assert!(given == expected, "{} of {count} messages", given.len());
}

#[test]
fn a_complete_recording_is_copied_with_everything_in_it() {
    let folder = tempdir().unwrap();
    let (path, copy) = (folder.path().join("whole.mcap"), folder.path().join("copy.mcap"));
    Whole::record(&path);
    let recovered = recover(&path, &copy).unwrap();
    assert_eq!((recovered.ending, recovered.attachments, recovered.metadata), (Ending::Complete, 1, 2));
    let (mut original, mut copied) = (inspect(&path).unwrap(), inspect(&copy).unwrap());
    for found in [&mut original, &mut copied] {
        (found.path, found.file_bytes, found.readable_bytes) = Default::default();
    }
    assert_eq!(original, copied);
    let bytes = fs::read(&copy).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let attachment = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).unwrap();
    assert_eq!(attachment.data, header().scenario.as_bytes());
}

#[test]
fn nothing_that_exists_is_overwritten() {
    let folder = tempdir().unwrap();
    let (path, other) = (folder.path().join("whole.mcap"), folder.path().join("other.mcap"));
    let whole = Whole::record(&path);
    fs::write(&other, "precious").unwrap();
    for to in [&path, &other] {
        let error = recover(&path, to).unwrap_err();
        assert!(matches!(&error, RecordingError::Exists { path } if path == to), "{error}");
    }
    assert_eq!(fs::read(&path).unwrap(), whole.bytes);
    assert_eq!(fs::read_to_string(&other).unwrap(), "precious");
}

#[test]
fn a_flipped_bit_panics_nowhere_and_costs_nothing_before_it() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (damaged, mended) = (folder.path().join("damaged.mcap"), folder.path().join("mended.mcap"));
    let mut endings = [0; 3];
    for at in (0..whole.bytes.len()).step_by(whole.bytes.len() / 400) {
        let mut bytes = whole.bytes.clone();
        bytes[at] ^= 1 << (at % 8);
        fs::write(&damaged, &bytes).unwrap();
        if let Ok(recovered) = recover(&damaged, &mended) {
            let (messages, ..) = whole.until(at);
            assert!(recovered.messages >= messages as u64, "flipped at {at}: {recovered}");
            let is_all = recovered.messages == whole.until(whole.bytes.len()).0 as u64;
            assert!(is_all || recovered.ending != Ending::Complete, "flipped at {at}: {recovered}");
            assert_eq!(inspect(&mended).unwrap().ending, Ending::Complete);
            endings[match recovered.ending {
                Ending::Complete => 0,
                Ending::CutOff => 1,
                Ending::Damaged { .. } => 2,
            }] += 1;
        }
        let _ = fs::remove_file(&mended);
    }
    assert!(endings[1] > 0 && endings[2] > 100, "{endings:?}");
}

#[test]
fn what_is_no_recording_is_refused_with_its_name() {
    let folder = tempdir().unwrap();
    let check = |name: &str, content: &[u8], expected: &str| {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        let error = inspect(&path).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
    };
    check("empty.mcap", b"", "the file is empty");
    check("scenario.toml", b"seed = 7\n", "it does not begin like an MCAP file");
    check("short.mcap", mcap::MAGIC, "before it says anything");
    let missing = inspect(&folder.path().join("missing.mcap")).unwrap_err().to_string();
    assert!(missing.contains("missing.mcap: cannot read: No such file"), "{missing}");
}

#[test]
fn a_claimed_length_takes_no_memory() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("liar.mcap");
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let end = whole.metadata_ends[0];
    let mut bytes = whole.bytes[..end].to_vec();
    bytes.push(mcap::records::op::CHUNK);
    bytes.extend(u64::MAX.to_le_bytes());
    bytes.extend([0; 100]);
    fs::write(&path, &bytes).unwrap();
    let found = inspect(&path).unwrap();
    assert_eq!((found.ending, found.readable_bytes), (Ending::CutOff, end as u64));
    assert_eq!(found.run, header().run);
}
