//! Files of tensors: safetensors with one entry of Dragnet's in the header's metadata. Equal content gives equal bytes.

use std::collections::HashMap;
use std::path::Path;

use dragnet_files::{FileError, read_at_most};
use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensorError, SafeTensors};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The one key of the header.
const HEADER_KEY: &str = "dragnet";

/// A kind of file: its name in error messages, and the format version that this program reads and writes.
#[derive(Clone, Copy)]
pub struct Kind {
    /// The content in words, such as `weights`.
    pub name: &'static str,
    /// The `format` in the header.
    pub format: &'static str,
    /// Maximum size of a file, bytes.
    pub max_bytes: u64,
}

/// Reads a file of a kind, and parses it with `parse`.
///
/// # Errors
/// If it cannot be read, or `parse` fails.
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

/// A tensor to write.
pub struct Tensor {
    /// Unique within a file.
    pub name: String,
    /// Type of a value.
    pub dtype: Dtype,
    /// Values along each dimension.
    pub shape: Vec<usize>,
    /// The values, little-endian, row-major.
    pub bytes: Vec<u8>,
}

/// The header: the format, and the content of the kind.
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
    /// A tensor of `f32`.
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

/// Parses a file: returns the header's content and the tensors.
///
/// # Errors
/// If the bytes are not a file of this kind, are truncated, or have another format version.
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
    /// Number of tensors.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Whether a tensor of this name exists.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.0.tensor(name).is_ok()
    }

    /// The bytes of the tensor with this name, type and shape.
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

    /// The values of the `f32` tensor with this name and shape.
    ///
    /// # Errors
    /// If there is none.
    pub fn floats(&self, name: &str, shape: &[usize]) -> Result<Vec<f32>, String> {
        let bytes = self.get(name, Dtype::F32, shape)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }
}
