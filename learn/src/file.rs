//! Files of tensors: safetensors, whose header carries one text of ours, so that the same content gives the same bytes.

use std::collections::HashMap;
use std::fs::{File, FileType};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensorError, SafeTensors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tempfile::Builder;

/// The one key of the header.
const HEADER_KEY: &str = "dragnet";

/// What a kind of file is called in messages, and the version that this program reads and writes.
#[derive(Clone, Copy)]
pub struct Kind {
    /// `weights`, as in "no weights of Dragnet".
    pub name: &'static str,
    /// Stands in the header as `format`.
    pub format: &'static str,
    /// Longer files are not read.
    pub max_bytes: u64,
}

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be read.
    #[error("{path}: cannot read the {kind}: {source}")]
    Read {
        /// Which.
        path: PathBuf,
        /// What it should hold.
        kind: &'static str,
        /// Why.
        source: io::Error,
    },
    /// It cannot be written; an older one is kept, and nothing of the new one.
    #[error("{path}: cannot write: {source}")]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It holds something else.
    #[error("{path}: {reason}")]
    Content {
        /// Which.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        reason: String,
    },
}

impl FileError {
    /// A file that holds something else.
    #[must_use]
    pub fn content(path: &Path, reason: String) -> Self {
        Self::Content { path: path.to_owned(), reason }
    }
}

/// Reads a file of a kind, as `parse` makes sense of it.
///
/// # Errors
/// If it cannot be read, or `parse` says what is wrong.
pub fn read<T>(
    kind: Kind,
    path: &Path,
    parse: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Result<T, FileError> {
    let bytes = read_at_most(path, kind.max_bytes).map_err(|source| FileError::Read {
        path: path.to_owned(),
        kind: kind.name,
        source,
    })?;
    parse(&bytes).map_err(|reason| FileError::content(path, reason))
}

/// Opens a plain file to be read. Whoever opens a pipe waits for somebody who writes to it, maybe for ever.
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

/// The bytes of a plain file, of which no more is ever in memory: it may grow while it is read.
///
/// # Errors
/// If it cannot be read, is no plain file, or is longer.
pub fn read_at_most(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_plain(path)?.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        let reason = format!("longer than the {max_bytes} bytes that are read");
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
/// If it cannot be read, is no plain file, is longer, or is no text.
pub fn read_text_at_most(path: &Path, max_bytes: u64) -> io::Result<String> {
    text_of(read_at_most(path, max_bytes)?)
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
pub fn check_plain(path: &Path, max_bytes: u64) -> io::Result<()> {
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(()) };
    check_kind(metadata.file_type())?;
    if metadata.len() > max_bytes {
        let reason = format!("longer than the {max_bytes} bytes that are read");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    Ok(())
}

/// What some editors write before a text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Writes a file as a whole or not at all: under its name is all of it, or the one before, even after a power cut.
///
/// # Errors
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    // Not private, as temporary files are: it becomes a file like any other.
    let unfinished = Builder::new().prefix(".unfinished-").make_in(folder, |path| File::create_new(path));
    let written = unfinished.and_then(|mut file| {
        file.write_all(bytes)?;
        // Otherwise the name may outlive a power cut that the content does not.
        file.as_file().sync_all()?;
        Ok(file.persist(path)?)
    });
    written.map(drop).map_err(|source| FileError::Write { path: path.to_owned(), source })
}

/// A tensor to be written.
pub struct Tensor {
    /// Each of a file has another.
    pub name: String,
    /// Type of a value.
    pub dtype: Dtype,
    /// Values along each dimension.
    pub shape: Vec<usize>,
    /// Little-endian, row-major.
    pub bytes: Vec<u8>,
}

/// The header as it is written: the format, and what the kind says of itself.
#[derive(Serialize, Deserialize)]
struct Header<T> {
    format: String,
    #[serde(flatten)]
    content: T,
}

#[derive(Deserialize)]
struct Version {
    format: String,
}

impl Tensor {
    /// Of `f32`.
    #[must_use]
    pub fn of_floats(name: String, shape: Vec<usize>, values: &[f32]) -> Self {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        Self { name, dtype: Dtype::F32, shape, bytes }
    }
}

/// The bytes of a file.
///
/// # Errors
/// If a tensor has another number of bytes than its shape and type need.
pub fn serialize(kind: Kind, content: &impl Serialize, tensors: &[Tensor]) -> Result<Vec<u8>, String> {
    let views = tensors.iter().map(|tensor| {
        let view = TensorView::new(tensor.dtype, tensor.shape.clone(), &tensor.bytes);
        Ok((tensor.name.as_str(), view.map_err(|error| error.to_string())?))
    });
    let views = views.collect::<Result<Vec<_>, String>>()?;
    let header = Header { format: kind.format.to_owned(), content };
    let header = serde_json::to_string(&header).map_err(|error| error.to_string())?;
    let header = HashMap::from([(HEADER_KEY.to_owned(), header)]);
    safetensors::serialize(views, Some(header)).map_err(|error| error.to_string())
}

/// What a file says of itself, and its tensors.
///
/// # Errors
/// What is wrong with the bytes: no such file, a truncated one, or one of another version.
pub fn parse<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<(T, Tensors<'_>), String> {
    let name = kind.name;
    let broken = |error: SafeTensorError| format!("no {name} file, or a truncated one: {error}");
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
    let text = metadata.metadata().as_ref().and_then(|header| header.get(HEADER_KEY));
    let text = text.ok_or_else(|| format!("no {name} of Dragnet: the header has no key {HEADER_KEY:?}"))?;
    let unreadable = |error: serde_json::Error| format!("the header's {HEADER_KEY:?}: {error}");
    let Version { format } = serde_json::from_str(text).map_err(unreadable)?;
    if format != kind.format {
        return Err(format!("format {format:?}: this program reads {:?}", kind.format));
    }
    let header: Header<T> = serde_json::from_str(text).map_err(unreadable)?;
    Ok((header.content, Tensors(tensors)))
}

/// The tensors of a file.
pub struct Tensors<'a>(SafeTensors<'a>);

impl Tensors<'_> {
    /// How many.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Whether there is one of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.tensor(name).is_ok()
    }

    /// The bytes of a tensor that has this type and shape.
    ///
    /// # Errors
    /// If there is none.
    pub fn get(&self, name: &str, dtype: Dtype, shape: &[usize]) -> Result<Vec<u8>, String> {
        let tensor = self.0.tensor(name).map_err(|_| format!("{name} is missing"))?;
        if tensor.dtype() != dtype || tensor.shape() != shape {
            let (found, found_shape) = (tensor.dtype(), tensor.shape());
            return Err(format!("{name} is {found:?} {found_shape:?}; expected {dtype:?} {shape:?}"));
        }
        Ok(tensor.data().to_vec())
    }

    /// Values of a tensor of `f32` that has this shape.
    ///
    /// # Errors
    /// If there is none.
    pub fn floats(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, String> {
        let bytes = self.get(name, Dtype::F32, shape)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }
}
