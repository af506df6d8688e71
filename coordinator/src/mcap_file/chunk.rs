//! Chunks: compressed groups of records.
//!
//! The claimed size of a chunk is a limit; memory is allocated only as it is filled.

use std::io::{self, Read};

use mcap::records::ChunkHeader;

/// The longest record or uncompressed chunk: four times the belief of the largest map.
pub(super) const MAX_RECORD_BYTES: u64 = 256 << 20;

/// Why a chunk cannot be decompressed.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum ChunkError {
    /// Unsupported compression; the file may be intact.
    #[error("compressed with {0}, which is not understood (zstd, lz4 and none are)")]
    Compression(String),
    /// The data are damaged.
    #[error("{0}")]
    Damaged(String),
}

/// Decompresses the records of a chunk, of the claimed length and checksum.
pub(super) fn unpack(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, ChunkError> {
    let claimed = header.uncompressed_size;
    if claimed > MAX_RECORD_BYTES {
        let reason = format!("a chunk of {claimed} bytes; allowed are at most {MAX_RECORD_BYTES}");
        return Err(ChunkError::Damaged(reason));
    }
    let unpacked = decompress(&header.compression, data, claimed)?
        .map_err(|error| ChunkError::Damaged(format!("a chunk cannot be unpacked: {error}")))?;
    if unpacked.len() as u64 != claimed {
        return Err(ChunkError::Damaged(format!("a chunk is not the {claimed} bytes that it claims")));
    }
    // 0 means that there is no checksum.
    let (sum, reported) = (crc32fast::hash(&unpacked), header.uncompressed_crc);
    if reported != 0 && sum != reported {
        return Err(ChunkError::Damaged(format!("a chunk's checksum is {sum:08x}, not {reported:08x}")));
    }
    Ok(unpacked)
}

/// Compresses with zstd.
pub(crate) fn pack(bytes: &[u8]) -> io::Result<Vec<u8>> {
    zstd::encode_all(bytes, zstd::DEFAULT_COMPRESSION_LEVEL)
}

/// Decompresses what [`pack`] made, up to the size of the longest record.
pub(crate) fn unpack_all(packed: &[u8]) -> io::Result<Vec<u8>> {
    read(zstd::Decoder::with_buffer(packed)?, MAX_RECORD_BYTES)
}

/// Decompresses at most one byte more than claimed.
fn decompress(compression: &str, data: &[u8], claimed: u64) -> Result<io::Result<Vec<u8>>, ChunkError> {
    Ok(match compression {
        "" => read(data, claimed),
        "zstd" => zstd::Decoder::with_buffer(data).and_then(|decoder| read(decoder, claimed)),
        "lz4" => read(lz4_flex::frame::FrameDecoder::new(data), claimed),
        other => return Err(ChunkError::Compression(other.escape_debug().to_string())),
    })
}

fn read(source: impl Read, claimed: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(claimed + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn header(compression: &str, uncompressed_size: u64, uncompressed_crc: u32) -> ChunkHeader {
        ChunkHeader {
            message_start_time: 0,
            message_end_time: 0,
            uncompressed_size,
            uncompressed_crc,
            compression: compression.into(),
            compressed_size: 0,
        }
    }

    #[test]
    fn a_chunk_of_any_compression_is_unpacked() {
        let text = b"who goes there, ".repeat(1000);
        let zstd = zstd::encode_all(text.as_slice(), 0).unwrap();
        let mut lz4 = lz4_flex::frame::FrameEncoder::new(Vec::new());
        lz4.write_all(&text).unwrap();
        let lz4 = lz4.finish().unwrap();
        let (length, sum) = (text.len() as u64, crc32fast::hash(&text));
        for (compression, data) in [("", &text), ("zstd", &zstd), ("lz4", &lz4)] {
            let check = |length, sum| unpack(&header(compression, length, sum), data);
            assert_eq!(check(length, sum), Ok(text.clone()), "{compression}");
            assert_eq!(check(length, 0), Ok(text.clone()), "{compression}");
            for (length, sum, reason) in [
                (length, sum ^ 1, "checksum"),
                (length - 1, sum, "claims"),
                (length + 1, sum, "claims"),
                (MAX_RECORD_BYTES + 1, sum, "allowed are at most"),
            ] {
                let error = check(length, sum).unwrap_err().to_string();
                assert!(error.contains(reason), "{compression}: {error}");
            }
        }
        let error = unpack(&header("brotli", length, sum), &text).unwrap_err();
        assert_eq!(error, ChunkError::Compression("brotli".into()));
    }

    /// A chunk that decompresses to 4 GiB is decompressed only up to its claimed length.
    #[test]
    fn a_chunk_that_unpacks_to_more_than_it_claims_stops_there() {
        let mut source = io::repeat(0).take(4 << 30);
        let bomb = {
            // One block of zeros, as often as the frame is long, would do; a smaller one shows the same.
            zstd::encode_all(source.by_ref().take(64 << 20), 0).unwrap()
        };
        assert!(bomb.len() < 10_000);
        let error = unpack(&header("zstd", 1000, 0), &bomb).unwrap_err();
        assert_eq!(error.to_string(), "a chunk is not the 1000 bytes that it claims");
    }
}
