//! Reading: never more than a bound, whatever a path turns out to be.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// What some editors write before a text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// The bytes of a file, of which no more is ever in memory: a pipe or a device does not say how long it is.
///
/// # Errors
/// If it cannot be read, or is longer.
pub fn read_at_most(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        let reason = format!("longer than the {most_bytes} bytes that are read");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(bytes)
}

/// The text of a file, which is no longer than this: UTF-8, or UTF-16 that says so by its byte-order mark. The mark is not
/// part of the text.
///
/// Every text that a person names is read here.
///
/// # Errors
/// If it cannot be read, is longer, or is no text.
pub fn read_text_at_most(path: &Path, most_bytes: u64) -> io::Result<String> {
    text_of(read_at_most(path, most_bytes)?)
}

/// The text that bytes are, without a byte-order mark.
///
/// # Errors
/// If they are none, with the kind `InvalidData`.
pub fn text_of(bytes: Vec<u8>) -> io::Result<String> {
    let none = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    let order: fn([u8; 2]) -> u16 = match bytes.as_slice() {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => {
            let mut text =
                String::from_utf8(bytes).map_err(|error| none(format!("no UTF-8 text: {error}")))?;
            if text.starts_with(BYTE_ORDER_MARK) {
                text.drain(..BYTE_ORDER_MARK.len_utf8());
            }
            return Ok(text);
        }
    };
    let (units, rest) = bytes[2..].as_chunks::<2>();
    let units: Vec<u16> = units.iter().map(|&unit| order(unit)).collect();
    let text = String::from_utf16(&units).ok().filter(|_| rest.is_empty());
    text.ok_or_else(|| none("no UTF-16 text, as which its byte-order mark has it".to_owned()))
}

/// Whether a file that somebody else's code reads as a whole, without a bound, has an end that is near enough: one that is
/// not there yet is left to that code.
///
/// # Errors
/// If it is no plain file, as a device is not, or longer.
pub fn check_plain(path: &Path, most_bytes: u64) -> io::Result<()> {
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(()) };
    let wrong = |reason: String| Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    if !metadata.is_file() {
        return wrong("no plain file".to_owned());
    }
    if metadata.len() > most_bytes {
        return wrong(format!("longer than the {most_bytes} bytes that are read"));
    }
    Ok(())
}
