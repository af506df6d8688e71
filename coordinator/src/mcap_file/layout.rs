//! The layout of the records of an MCAP file (<https://mcap.dev/spec>): their claimed lengths are checked against the
//! available bytes before use.

use mcap::records::op;

/// The prefix of a record: its kind, 1 byte, and its length, 8.
pub(super) const PREFIX_BYTES: usize = 9;

/// A part of a record's body.
enum Part {
    /// This many bytes.
    Fixed(usize),
    /// A length of 4 bytes, and this many bytes: a text, a list, a map.
    Counted,
    /// A length of 8 bytes, and this many bytes.
    LongCounted,
}

use Part::{Counted, Fixed, LongCounted};

/// The parts of a kind of record; none for an unknown kind.
const fn parts(opcode: u8) -> &'static [Part] {
    match opcode {
        op::HEADER | op::METADATA => &[Counted, Counted],
        op::FOOTER => &[Fixed(20)],
        op::SCHEMA => &[Fixed(2), Counted, Counted, Counted],
        op::CHANNEL => &[Fixed(4), Counted, Counted, Counted],
        op::MESSAGE => &[Fixed(22)],
        op::CHUNK => &[Fixed(28), Counted, LongCounted],
        op::MESSAGE_INDEX => &[Fixed(2), Counted],
        op::CHUNK_INDEX => &[Fixed(32), Counted, Fixed(8), Counted, Fixed(16)],
        op::ATTACHMENT => &[Fixed(16), Counted, Counted, LongCounted, Fixed(4)],
        op::ATTACHMENT_INDEX => &[Fixed(40), Counted, Counted],
        op::STATISTICS => &[Fixed(42), Counted],
        op::METADATA_INDEX => &[Fixed(16), Counted],
        op::SUMMARY_OFFSET => &[Fixed(17)],
        op::DATA_END => &[Fixed(4)],
        _ => &[],
    }
}

/// Whether a record's parts have room in its body. Later versions of the format may add more behind them.
pub(super) fn fits(opcode: u8, body: &[u8]) -> bool {
    match (opcode, end(opcode, body)) {
        // A single bit can turn a record of another kind into one that ends the file.
        (op::FOOTER | op::DATA_END, end) => end == Some(body.len()),
        (_, end) => end.is_some(),
    }
}

/// Whether a record's parts fill its body, which distinguishes it from arbitrary bytes.
pub(super) fn fills(opcode: u8, body: &[u8]) -> bool {
    let is_known = !parts(opcode).is_empty();
    let end = end(opcode, body);
    is_known && if opcode == op::MESSAGE { end.is_some() } else { end == Some(body.len()) }
}

/// Where the parts of a record end in its body.
fn end(opcode: u8, body: &[u8]) -> Option<usize> {
    let mut end = 0_usize;
    for part in parts(opcode) {
        let length = match part {
            Fixed(length) => *length,
            Counted => {
                let length = u32::from_le_bytes(*body.get(end..)?.first_chunk()?);
                4_usize.checked_add(usize::try_from(length).ok()?)?
            }
            LongCounted => {
                let length = u64::from_le_bytes(*body.get(end..)?.first_chunk()?);
                8_usize.checked_add(usize::try_from(length).ok()?)?
            }
        };
        end = end.checked_add(length).filter(|end| *end <= body.len())?;
    }
    Some(end)
}

/// The kind and the body of the record at the start of the bytes, if it is complete.
pub(super) fn split(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let (prefix, rest) = bytes.split_first_chunk()?;
    let Prefix { opcode, body_bytes } = Prefix::read(*prefix);
    let body = rest.get(..usize::try_from(body_bytes).ok()?)?;
    fits(opcode, body).then_some((opcode, body))
}

/// The claimed kind and length of a record.
#[derive(Clone, Copy)]
pub(super) struct Prefix {
    pub(super) opcode: u8,
    pub(super) body_bytes: u64,
}

impl Prefix {
    pub(super) fn read(bytes: [u8; PREFIX_BYTES]) -> Self {
        let [opcode, length @ ..] = bytes;
        Self { opcode, body_bytes: u64::from_le_bytes(length) }
    }

    /// The end of the record that begins there.
    pub(super) const fn end(self, offset: u64) -> Option<u64> {
        match offset.checked_add(PREFIX_BYTES as u64) {
            Some(start) => start.checked_add(self.body_bytes),
            None => None,
        }
    }
}
