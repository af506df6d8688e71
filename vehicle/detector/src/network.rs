//! The network: a file that says how numbers become others, and what runs it.
//!
//! A TorchScript module is run by libtorch, an ONNX file by a runtime that is part of this program. A module is a program:
//! load only those from trusted sources. An ONNX file can neither read nor write anything else, but nothing here bounds
//! its time or memory.

#[cfg(feature = "onnx")]
mod onnx;
#[cfg(feature = "torch")]
mod torch;

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use crate::metadata::Metadata;
use crate::output::Output;
use crate::picture::{Picture, PixelFormat, Size};
use crate::prepare::{PrepareError, Prepared, prepare};
use crate::settings::{Classes, Processor, Resolution, Settings};
use crate::{FindError, Found, find};

/// A network that detects objects in images.
#[derive(Debug)]
pub struct Network {
    runtime: Box<dyn Runtime>,
    input: Size,
    names: BTreeMap<u32, String>,
    class_count: u32,
}

/// The format of a network's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A TorchScript module.
    TorchScript,
    /// ONNX, the format of many programs.
    Onnx,
}

/// Why a network cannot be used, or failed on an image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// A format that needs another build.
    #[error(
        "{format}, which this program was built without: build it from a checkout with `{command}`",
        command = .format.build()
    )]
    NotBuilt {
        /// The format of the file.
        format: Format,
    },
    /// Not a network.
    #[error("not {format} that can be read: {reason}")]
    Unreadable {
        /// What the file was taken for, by its name.
        format: Format,
        /// The message of the runtime.
        reason: String,
    },
    /// Its input is not an image.
    #[error(
        "a network with {0}: understood is one input of 32-bit floats, shape [1, 3, rows, columns], and one output"
    )]
    Interface(String),
    /// Made for another task.
    #[error("a network for the task {0:?}: understood is \"detect\"")]
    Task(String),
    /// The size of its input is unknown.
    #[error("the network does not say the size of its input, as those of ultralytics do: it has to be given")]
    NoInput,
    /// An impossible input size.
    #[error("an input of {0} pixels: allowed are 1 to {max} columns and rows", max = Network::MAX_INPUT_PIXELS)]
    Input(Size),
    /// Its file allows another input size alone.
    #[error("an input of {given} pixels: the network's is fixed, {fixed}")]
    Fixed {
        /// The size to be used.
        given: Size,
        /// The only possible size.
        fixed: Size,
    },
    /// Its metadata and its output differ.
    #[error("the network names {named} classes, and its output has {given}")]
    Names {
        /// Number of classes in its file.
        named: usize,
        /// Number of classes in its output.
        given: u32,
    },
    /// An unknown class.
    #[error("class {class}: the network has {known}, from 0 on")]
    Class {
        /// The given class.
        class: u32,
        /// Number of classes.
        known: u32,
    },
    /// The image cannot be prepared for it.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// It failed.
    #[error("the network failed on an image of {input} pixels: {reason}")]
    Run {
        /// Columns and rows.
        input: Size,
        /// The runtime's message.
        reason: String,
    },
    /// Its output is invalid.
    #[error(transparent)]
    Find(#[from] FindError),
}

/// What runs a network.
trait Runtime: fmt::Debug + Send {
    /// Runs it on an input of this size, shape `[1, 3, rows, columns]`.
    fn run(&self, values: Vec<f32>, input: Size) -> Result<Numbers, NetworkError>;
}

/// Its output.
struct Numbers {
    values: Vec<f32>,
    shape: Vec<i64>,
}

impl Format {
    /// The format of a file, by the ending of its name: ONNX if that is `.onnx`, otherwise a TorchScript module.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let is_onnx = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("onnx"));
        if is_onnx { Self::Onnx } else { Self::TorchScript }
    }

    /// Builds a program that reads it.
    const fn build(self) -> &'static str {
        match self {
            Self::TorchScript => "train/libtorch.sh && cargo build --release --features detector",
            Self::Onnx => "cargo build --release --features onnx",
        }
    }

    fn load(self, bytes: &[u8], processor: Processor) -> Result<(Box<dyn Runtime>, Metadata), NetworkError> {
        match self {
            #[cfg(feature = "torch")]
            Self::TorchScript => {
                let (module, metadata) = torch::Module::load(bytes, processor)?;
                Ok((Box::new(module), metadata))
            }
            #[cfg(feature = "onnx")]
            Self::Onnx => {
                let (graph, metadata) = onnx::Graph::load(bytes, processor)?;
                Ok((Box::new(graph), metadata))
            }
            #[cfg(not(all(feature = "torch", feature = "onnx")))]
            format => {
                let _ = (bytes, processor);
                Err(NetworkError::NotBuilt { format })
            }
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::TorchScript => "a TorchScript module",
            Self::Onnx => "an ONNX network",
        })
    }
}

impl Network {
    /// Maximum number of columns or rows of its input: an image of this size is allocated before the network is known
    /// to work.
    pub const MAX_INPUT_PIXELS: u32 = 4096;

    /// Loads a network from the bytes of its file; `input` is needed if the file does not give the input size, or to use
    /// another one. The network is run once on a gray image, so that errors are found here.
    ///
    /// # Errors
    /// If it is not a network, or its output is not that of a detector.
    pub fn load(
        format: Format,
        bytes: &[u8],
        input: Option<Size>,
        processor: Processor,
    ) -> Result<Self, NetworkError> {
        let (runtime, metadata) = format.load(bytes, processor)?;
        if let Some(task) = metadata.task.as_ref().filter(|task| *task != "detect") {
            return Err(NetworkError::Task(task.chars().take(40).collect()));
        }
        let input = input.or(metadata.input).or(metadata.fixed_input).ok_or(NetworkError::NoInput)?;
        if ![input.width_pixels, input.height_pixels]
            .iter()
            .all(|side| (1..=Self::MAX_INPUT_PIXELS).contains(side))
        {
            return Err(NetworkError::Input(input));
        }
        if let Some(fixed) = metadata.fixed_input.filter(|fixed| *fixed != input) {
            return Err(NetworkError::Fixed { given: input, fixed });
        }
        let mut network = Self { runtime, input, names: metadata.names, class_count: 0 };
        network.class_count = network.class_count()?;
        let named = network.names.len();
        if named != 0 && named != network.class_count as usize {
            return Err(NetworkError::Names { named, given: network.class_count });
        }
        Ok(network)
    }

    /// The size of its input.
    #[must_use]
    pub const fn input(&self) -> Size {
        self.input
    }

    /// Number of its classes, from 0 on.
    #[must_use]
    pub const fn classes(&self) -> u32 {
        self.class_count
    }

    /// The name of a class, if its file has it.
    #[must_use]
    pub fn name(&self, class: u32) -> Option<&str> {
        self.names.get(&class).map(String::as_str)
    }

    /// The first class with this name.
    #[must_use]
    pub fn class_named(&self, name: &str) -> Option<u32> {
        self.names.iter().find(|(_, known)| *known == name).map(|(&class, _)| class)
    }

    /// The detections in an image.
    ///
    /// # Errors
    /// If the settings are invalid, the image cannot be prepared, or the network fails. The network remains usable
    /// after an error.
    pub fn detect(&self, picture: &Picture<'_>, settings: &Settings) -> Result<Found, NetworkError> {
        settings.check().map_err(FindError::Settings)?;
        self.check_classes(&settings.classes)?;
        let Prepared { values, letterbox } = prepare(picture, settings.resolution, self.input)?;
        let numbers = self.runtime.run(values, self.input)?;
        let output = Output::new(&numbers.values, &numbers.shape).map_err(FindError::Output)?;
        Ok(find(&output, &letterbox, settings)?)
    }

    fn check_classes(&self, classes: &Classes) -> Result<(), NetworkError> {
        let Classes::Only(classes) = classes else { return Ok(()) };
        let known = self.class_count;
        match classes.last() {
            Some(&class) if class >= known => Err(NetworkError::Class { class, known }),
            _ => Ok(()),
        }
    }

    /// Number of classes in its output for a gray image.
    fn class_count(&self) -> Result<u32, NetworkError> {
        let size = Size { width_pixels: 1, height_pixels: 1 };
        let gray = Picture::new(size, PixelFormat::Mono8, &[114]).map_err(PrepareError::Picture)?;
        let values = prepare(&gray, Resolution::Full, self.input)?.values;
        let numbers = self.runtime.run(values, self.input)?;
        let (classes, _) = Output::classes_and_anchors(&numbers.shape).map_err(FindError::Output)?;
        Ok(u32::try_from(classes).unwrap_or(u32::MAX))
    }
}
