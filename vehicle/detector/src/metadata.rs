//! What a network's file says of it: ultralytics' export writes a JSON object into the archive of a TorchScript module,
//! and texts into an ONNX file.

#[cfg(feature = "torch")]
mod archive;
#[cfg(feature = "onnx")]
mod python;

use std::collections::BTreeMap;

#[cfg(feature = "torch")]
pub(super) use archive::of_module;

use crate::picture::Size;

/// The metadata, all optional.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Metadata {
    /// The task of the network; only `detect` is supported.
    pub(super) task: Option<String>,
    /// The size of its input, if it was made for one.
    pub(super) input: Option<Size>,
    /// The size of its input, if it allows no other.
    pub(super) fixed_input: Option<Size>,
    /// By class.
    pub(super) names: BTreeMap<u32, String>,
}

#[cfg(any(feature = "torch", feature = "onnx"))]
const fn size([height_pixels, width_pixels]: [u32; 2]) -> Size {
    Size { width_pixels, height_pixels }
}

/// The metadata of an ONNX file, whose texts are found by their names. A text that is not understood is none.
#[cfg(feature = "onnx")]
pub(super) fn of_texts<'a>(text: impl Fn(&str) -> Option<&'a str>) -> Metadata {
    Metadata {
        task: text("task").map(str::to_owned),
        input: text("imgsz").and_then(python::pair).map(size),
        fixed_input: None,
        names: text("names").and_then(python::names).unwrap_or_default(),
    }
}
