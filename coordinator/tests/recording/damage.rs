//! Recordings that are truncated or damaged, anywhere.

use std::fs;
use std::io::Write;
use std::path::Path;

use dragnet_coordinator::inspect::inspect;
use dragnet_coordinator::playback::Playback;
use dragnet_coordinator::recover::recover;
use dragnet_coordinator::{Ending, RecordingError};
use mcap::{MessageStream, Summary};
use tempfile::tempdir;

use crate::episode::{Episode, header, seconds};
use crate::mentions::assert_mentions;

/// A complete recording, and where its parts end by its own index.
struct Whole {
    bytes: Vec<u8>,
    /// End of each chunk, and the messages in it.
    chunks: Vec<(usize, usize)>,
    /// Start of each chunk.
    starts: Vec<usize>,
    attachment_ends: Vec<usize>,
    metadata_ends: Vec<usize>,
}

impl Whole {
    fn record(path: &Path) -> Self {
        Episode::play().record(path);
        let bytes = fs::read(path).unwrap();
        let summary = Summary::read(&bytes).unwrap().unwrap();
        let end = |offset: u64, length: u64| usize::try_from(offset + length).unwrap();
        let starts = summary.chunk_indexes.iter().map(|chunk| end(chunk.chunk_start_offset, 0)).collect();
        let messages = |chunk| summary.stream_chunk(&bytes, chunk).unwrap().count();
        let chunks = summary.chunk_indexes.iter();
        Self {
            chunks: chunks
                .map(|chunk| (end(chunk.chunk_start_offset, chunk.chunk_length), messages(chunk)))
                .collect(),
            starts,
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

    /// Messages of the chunk that a byte belongs to.
    fn chunk_of(&self, byte: usize) -> usize {
        let chunks = self.starts.iter().zip(&self.chunks);
        chunks.filter(|(start, (end, _))| (**start..*end).contains(&byte)).map(|(_, (_, count))| count).sum()
    }

    /// Messages in whole chunks, attachments and metadata up to a cut.
    fn until(&self, cut: usize) -> (usize, usize, usize) {
        let count = |ends: &[usize]| ends.iter().filter(|&&end| end <= cut).count();
        let messages = self.chunks.iter().filter(|(end, _)| *end <= cut).map(|(_, messages)| messages).sum();
        (messages, count(&self.attachment_ends), count(&self.metadata_ends))
    }
}

#[test]
fn intact_parts_before_a_cut_are_recovered() {
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

/// The repaired file holds the first messages of the complete one, under the same names.
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
    assert_eq!((recovered.ending, recovered.attachments, recovered.metadata), (Ending::Complete, 3, 2));
    let (mut original, mut copied) = (inspect(&path).unwrap(), inspect(&copy).unwrap());
    for found in [&mut original, &mut copied] {
        (found.path, found.file_bytes, found.readable_bytes) = Default::default();
    }
    assert_eq!(original, copied);
    let bytes = fs::read(&copy).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let attachment = |index: &_| mcap::read::attachment(&bytes, index).unwrap();
    let scenario = summary.attachment_indexes.iter().map(attachment).find(|it| it.name == "scenario.toml");
    assert_eq!(scenario.unwrap().data, header().scenario.as_bytes());
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
fn a_flipped_bit_panics_nowhere_and_costs_at_most_its_chunk() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (damaged, mended) = (folder.path().join("damaged.mcap"), folder.path().join("mended.mcap"));
    let mut endings = [0; 3];
    let end = whole.bytes.len();
    let anywhere = (0..end).step_by(end / 400).chain(end - 40..end).map(|at| (at, 1 << (at % 8)));
    // Behind a chunk is an index, which one bit turns into a message.
    let indexes = whole.chunks.iter().map(|&(end, _)| (end, 0b10));
    for (at, bit) in anywhere.chain(indexes) {
        let mut bytes = whole.bytes.clone();
        bytes[at] ^= bit;
        fs::write(&damaged, &bytes).unwrap();
        let recovered = recover(&damaged, &mended).unwrap();
        let (all, ..) = whole.until(end);
        let least = all - whole.chunk_of(at);
        assert!(recovered.messages >= least as u64, "flipped at {at}: {recovered}, not {least}");
        let is_all = recovered.messages == all as u64;
        assert!(is_all || recovered.ending != Ending::Complete, "flipped at {at}: {recovered}");
        assert_eq!(inspect(&mended).unwrap().ending, Ending::Complete);
        check_is_part(&mended, &whole);
        endings[match recovered.ending {
            Ending::Complete => 0,
            Ending::CutOff => 1,
            Ending::Damaged { .. } => 2,
            Ending::Followed { .. } => panic!("flipped at {at}: nothing follows"),
        }] += 1;
        fs::remove_file(&mended).unwrap();
    }
    assert!(endings[1] > 0 && endings[2] > 100, "{endings:?}");
}

/// The repaired file holds messages of the complete one, in their order, and nothing else.
fn check_is_part(mended: &Path, whole: &Whole) {
    let mended = fs::read(mended).unwrap();
    let mut originals = MessageStream::new(&whole.bytes).unwrap().map(Result::unwrap);
    for message in MessageStream::new(&mended).unwrap().map(Result::unwrap) {
        assert!(originals.any(|original| original == message), "{message:?} was never said");
    }
}

#[test]
fn intact_parts_behind_damage_are_recovered_and_losses_counted() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (damaged, mended) = (folder.path().join("damaged.mcap"), folder.path().join("mended.mcap"));
    let (all, ..) = whole.until(whole.bytes.len());
    let intact = Playback::read(&folder.path().join("whole.mcap")).unwrap();
    // The first holds the map and the topics; two neighbors; one of the end.
    let final_chunk = whole.chunks.len() - 1;
    for spoiled in [vec![0], vec![3], vec![4, 5], vec![2, final_chunk]] {
        let mut bytes = whole.bytes.clone();
        let mut lost = 0;
        for &number in &spoiled {
            let (end, messages) = whole.chunks[number];
            // Within a chunk's data, its length is unchanged. With a damaged length, the next record is searched.
            bytes[end - 10] ^= 0x10;
            if number % 2 == 0 {
                bytes[whole.starts[number] + 1] ^= 0x04;
            }
            lost += messages;
        }
        fs::write(&damaged, &bytes).unwrap();
        let recovered = recover(&damaged, &mended).unwrap();
        assert_eq!(recovered.messages, (all - lost) as u64, "{spoiled:?}: {recovered}");
        assert_eq!((recovered.messages_without_topic, recovered.attachments, recovered.metadata), (0, 3, 2));
        let Ending::Damaged { places, lost_messages, lost_bytes, .. } = &recovered.ending else {
            panic!("{recovered}")
        };
        assert_eq!((*places, *lost_messages), (spoiled.len() as u64, Some(lost as u64)), "{recovered}");
        assert_eq!(recovered.readable_bytes + lost_bytes, recovered.file_bytes);
        check_is_part(&mended, &whole);
        check_playback(&damaged, &intact, lost);
        fs::remove_file(&mended).unwrap();
    }
}

/// A mission with a gap is played back, also if that is its beginning.
fn check_playback(damaged: &Path, intact: &Playback, lost: usize) {
    let playback = Playback::read(damaged).unwrap();
    let Ending::Damaged { lost_messages, .. } = playback.ending else { panic!("{playback:?}") };
    assert_eq!(lost_messages, Some(lost as u64));
    assert_eq!((playback.start_unix_ns, playback.origin), (intact.start_unix_ns, intact.origin));
    assert_eq!((&playback.terrain, &playback.prior), (&intact.terrain, &intact.prior));
    assert!(playback.records.len() + lost >= intact.records.len() && playback.end() >= seconds(15.0));
}

/// The beginning is lost where all its copies are. What is said of the damage is true to the file's end.
#[test]
fn a_mission_without_its_map_cannot_be_played_back() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let intact = Playback::read(&folder.path().join("whole.mcap")).unwrap();
    let damaged = folder.path().join("damaged.mcap");
    let mut bytes = whole.bytes.clone();
    // A block of a disk.
    bytes[..4096].fill(0);
    fs::write(&damaged, &bytes).unwrap();
    let playback = Playback::read(&damaged).unwrap();
    assert_eq!((&playback.terrain, &playback.prior), (&intact.terrain, &intact.prior));
    assert!(playback.records.len() + 50 > intact.records.len() && playback.end() >= seconds(15.0));
    // The copy at the end is the last that is compressed.
    let zstd = [0x28, 0xb5, 0x2f, 0xfd];
    let copy = (0..bytes.len()).rfind(|&byte| bytes[byte..].starts_with(&zstd));
    bytes[copy.unwrap() + 100] ^= 0x10;
    fs::write(&damaged, &bytes).unwrap();
    let error = Playback::read(&damaged).unwrap_err().to_string();
    assert!(error.contains("is damaged in") && !error.contains("cut off"), "{error}");
}

/// Without the first chunk and the end nothing defines the topics that were there from the start.
#[test]
fn what_cannot_be_read_without_its_definition_is_counted() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let damaged = folder.path().join("damaged.mcap");
    let mut bytes = whole.bytes.clone();
    bytes[whole.chunks[0].0 - 10] ^= 0x10;
    let last = whole.chunks.len() - 1;
    bytes.truncate(whole.chunks[last].0 - 5);
    fs::write(&damaged, &bytes).unwrap();
    let kept: usize = whole.chunks[1..last].iter().map(|(_, messages)| messages).sum();
    let recovered = recover(&damaged, &folder.path().join("mended.mcap")).unwrap();
    let Ending::Damaged { messages_without_topic, is_cut_off, .. } = recovered.ending else {
        panic!("{recovered}")
    };
    assert!(is_cut_off && messages_without_topic > 0, "{recovered}");
    assert_eq!(recovered.messages + messages_without_topic, kept as u64, "{recovered}");
    let text = recovered.to_string();
    assert!(text.contains("define their topics") && text.contains("its end is cut off too"), "{text}");
}

#[test]
fn a_damaged_beginning_loses_the_header() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (damaged, mended) = (folder.path().join("damaged.mcap"), folder.path().join("mended.mcap"));
    let mut bytes = whole.bytes.clone();
    bytes[..30].fill(0);
    fs::write(&damaged, &bytes).unwrap();
    let recovered = recover(&damaged, &mended).unwrap();
    assert_eq!(recovered.messages, whole.until(bytes.len()).0 as u64, "{recovered}");
    assert!(recovered.to_string().contains("the header is damaged"), "{recovered}");
}

#[test]
fn a_file_that_is_not_a_recording_is_rejected_with_its_name() {
    let folder = tempdir().unwrap();
    let check = |name: &str, content: &[u8], expected: &str| {
        let path = folder.path().join(name);
        fs::write(&path, content).unwrap();
        let error = inspect(&path).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
    };
    check("empty.mcap", b"", "the file is empty");
    check("scenario.toml", b"seed = 7\n", "MCAP");
    check("short.mcap", mcap::MAGIC, "before its first record");
    let missing = inspect(&folder.path().join("missing.mcap")).unwrap_err().to_string();
    assert_mentions(&missing, "missing.mcap .. No such file");
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

#[test]
fn data_after_a_recording_are_reported_and_ignored() {
    let folder = tempdir().unwrap();
    let (path, mended) = (folder.path().join("two.mcap"), folder.path().join("mended.mcap"));
    let Whole { bytes, chunks, .. } = Whole::record(&folder.path().join("whole.mcap"));
    let end = bytes.len() as u64;
    for behind in [&b"\n"[..], &bytes] {
        fs::write(&path, [&bytes, behind].concat()).unwrap();
        let followed = Ending::Followed { at_byte: end, bytes: behind.len() as u64 };
        let found = inspect(&path).unwrap();
        assert_eq!((&found.ending, found.readable_bytes), (&followed, end));
        let reported = format!("complete .. {} bytes", behind.len());
        assert_mentions(&found.to_string(), &reported);
        assert_eq!(Playback::read(&path).unwrap().ending, followed);
        let recovered = recover(&path, &mended).unwrap();
        assert_eq!(recovered.ending, followed);
        assert_mentions(&recovered.to_string(), &reported);
        assert_eq!(
            inspect(&mended).unwrap().topics,
            inspect(&folder.path().join("whole.mcap")).unwrap().topics
        );
        fs::remove_file(&mended).unwrap();
    }
    // If more is lost, it counts among that.
    let mut damaged = [&*bytes, &bytes].concat();
    damaged[chunks[1].0 - 1] ^= 1;
    fs::write(&path, &damaged).unwrap();
    let Ending::Damaged { places, lost_bytes, .. } = inspect(&path).unwrap().ending else {
        panic!("a damaged chunk")
    };
    assert!(places == 2 && lost_bytes > end, "{places} places, {lost_bytes} bytes");
}

/// Two missions in one file never become one.
#[test]
fn a_recording_behind_a_cut_one_is_not_read() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (joined, mended) = (folder.path().join("joined.mcap"), folder.path().join("mended.mcap"));
    let (end, ..) = whole.chunks[3];
    let middle = whole.bytes.len() / 2;
    for cut in [end - 1, end, end + 1, middle, whole.bytes.len() - 20] {
        fs::write(&joined, [&whole.bytes[..cut], &whole.bytes].concat()).unwrap();
        let recovered = recover(&joined, &mended).unwrap();
        assert_eq!(recovered.messages, whole.until(cut).0 as u64, "cut at {cut}: {recovered}");
        let said = format!("another recording begins at byte {cut} and is not read .. tail -c +{}", cut + 1);
        assert_mentions(&recovered.to_string(), &said);
        check_mended(&mended, &whole, whole.until(cut).0);
        assert_mentions(&Playback::read(&joined).unwrap().ending.to_string(), &said);
        fs::remove_file(&mended).unwrap();
    }
}

/// A chunk record with this header and these packed bytes.
fn chunk(compression: &str, unpacked_bytes: u64, sum: u32, packed: &[u8]) -> Vec<u8> {
    let mut body = [0; 16].to_vec();
    body.extend(unpacked_bytes.to_le_bytes());
    body.extend(sum.to_le_bytes());
    body.extend(u32::try_from(compression.len()).unwrap().to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((packed.len() as u64).to_le_bytes());
    body.extend(packed);
    [&[mcap::records::op::CHUNK], &(body.len() as u64).to_le_bytes()[..], &body].concat()
}

#[test]
fn a_claimed_chunk_size_allocates_no_memory() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("liar.mcap");
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let packed = zstd::encode_all([7; 1000].as_slice(), 0).unwrap();
    let (start, end) = (whole.starts[2], whole.chunks[1].0);
    let bytes = [&whole.bytes[..end], &chunk("zstd", 4 << 30, 0, &packed), &whole.bytes[start..]].concat();
    fs::write(&path, bytes).unwrap();
    let found = inspect(&path).unwrap();
    let Ending::Damaged { reason, lost_messages, .. } = &found.ending else { panic!("{found}") };
    assert_mentions(reason, "chunk .. 4294967296 bytes .. 268435456");
    assert_eq!(*lost_messages, Some(0), "all that was written is there");
}

/// The same recording with its chunks compressed differently, up to its index.
fn packed_by(whole: &Whole, compression: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut before = 0;
    for (&start, &(end, _)) in whole.starts.iter().zip(&whole.chunks) {
        bytes.extend(&whole.bytes[before..start]);
        let body = &whole.bytes[start + 9..end];
        let Ok(mcap::records::Record::Chunk { header, data }) =
            mcap::parse_record(mcap::records::op::CHUNK, body)
        else {
            panic!("no chunk at {start}")
        };
        let unpacked = zstd::decode_all(&*data).unwrap();
        bytes.extend(chunk(compression, header.uncompressed_size, header.uncompressed_crc, &pack(&unpacked)));
        before = end;
    }
    bytes
}

#[test]
fn chunks_that_others_pack_are_read_or_named() {
    let folder = tempdir().unwrap();
    let whole = Whole::record(&folder.path().join("whole.mcap"));
    let (path, mended) = (folder.path().join("other.mcap"), folder.path().join("mended.mcap"));
    let lz4 = |unpacked: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(unpacked).unwrap();
        encoder.finish().unwrap()
    };
    fs::write(&path, packed_by(&whole, "lz4", lz4)).unwrap();
    let recovered = recover(&path, &mended).unwrap();
    assert_eq!(recovered.messages, whole.until(whole.bytes.len()).0 as u64);
    assert_eq!(recovered.ending, Ending::CutOff);
    check_is_part(&mended, &whole);
    fs::remove_file(&mended).unwrap();
    fs::write(&path, packed_by(&whole, "brotli", lz4)).unwrap();
    let expected = "other.mcap .. brotli .. zstd, lz4 and none";
    for error in [
        inspect(&path).unwrap_err(),
        recover(&path, &mended).unwrap_err(),
        Playback::read(&path).unwrap_err(),
    ] {
        assert_mentions(&error.to_string(), expected);
    }
    assert!(!mended.exists());
}
