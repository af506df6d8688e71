//! Bounded reading of regular files; other kinds of files are rejected.

use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::Path;

/// The byte-order mark that some editors write before a text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Opens a regular file for reading. Other kinds are rejected, since opening a pipe could block without end.
///
/// # Errors
/// If it cannot be opened, or is a folder, a pipe, a device or a socket.
pub fn open_plain(path: &Path) -> io::Result<File> {
    check_kind(std::fs::metadata(path)?.file_type())?;
    File::open(path)
}

fn check_kind(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let reason = format!("no plain file, but {}", kind_name(kind));
    Err(io::Error::new(io::ErrorKind::InvalidInput, reason))
}

fn kind_name(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    if kind.is_dir() { "a folder" } else { "a device" }
}

/// The bytes of a regular file. The bound holds in memory too: the file may grow while it is read.
///
/// # Errors
/// If it cannot be read, is not a regular file, or is longer.
pub fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_plain(path)?.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let reason = format!("longer than the {max_bytes} bytes that are read");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, reason));
    }
    Ok(bytes)
}

/// The text of a file of bounded length: UTF-8, or UTF-16 with a byte-order mark. The returned text does not contain
/// the mark.
///
/// All text files that users name are read by this function.
///
/// # Errors
/// If it cannot be read, is not a regular file, is longer, or is not text.
pub fn read_text_at_most(path: &Path, max_bytes: u64) -> io::Result<String> {
    text_of(read_at_most(path, max_bytes)?)
}

/// Decodes text, without its byte-order mark.
///
/// # Errors
/// If the bytes are not text, with the kind `InvalidData`.
pub fn text_of(bytes: Vec<u8>) -> io::Result<String> {
    let none = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    let order: fn([u8; 2]) -> u16 = match bytes.as_slice() {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => {
            let mut text = String::from_utf8(bytes).map_err(|error| none(no_text(&error)))?;
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

/// What bytes that are no text may be instead.
fn no_text(error: &std::string::FromUtf8Error) -> String {
    let kinds: [(&[u8], &str); 6] = [
        (b"\x89MCAP0\r\n", "a recording (MCAP)"),
        (b"redb\x1a\x0a\xa9\x0d\x0a", "a robot's journal"),
        (b"\x89PNG", "an image (PNG)"),
        (b"\xff\xd8\xff", "an image (JPEG)"),
        (b"P5", "an image (PGM)"),
        (b"PK\x03\x04", "an archive (ZIP, KMZ)"),
    ];
    let kind = kinds.iter().find(|(magic, _)| error.as_bytes().starts_with(magic));
    kind.map_or_else(|| format!("no UTF-8 text: {error}"), |(_, kind)| format!("this is {kind}, and no text"))
}

/// Checks that a file is regular and short enough, before other code reads it without a bound. A missing file is not an
/// error here; the other code reports it.
///
/// # Errors
/// If it is not a regular file, or longer.
pub fn check_plain(path: &Path, max_bytes: u64) -> io::Result<()> {
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(()) };
    check_kind(metadata.file_type())?;
    if metadata.len() > max_bytes {
        let reason = format!("longer than the {max_bytes} bytes that are read");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    Ok(())
}
