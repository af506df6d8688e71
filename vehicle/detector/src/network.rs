//! The network: a TorchScript module that libtorch runs.
//!
//! A module is a program. Load only modules from trusted sources: nothing here prevents one from running without end.

use std::collections::BTreeMap;
use std::io::Cursor;

pub use tch::Device;
use tch::{CModule, Kind, TchError, Tensor};

use crate::metadata::Metadata;
use crate::output::Output;
use crate::picture::{Picture, PixelFormat, Size};
use crate::prepare::{PrepareError, Prepared, prepare};
use crate::settings::{Classes, Resolution, Settings};
use crate::{FindError, Found, find};

/// A network that detects objects in images.
#[derive(Debug)]
pub struct Network {
    module: CModule,
    device: Device,
    input: Size,
    names: BTreeMap<u32, String>,
    class_count: u32,
}

/// Why a network cannot be used, or failed on an image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Not a module.
    #[error("not a TorchScript module that can be read: {0}")]
    Unreadable(String),
    /// Made for another task.
    #[error("a module for the task {0:?}: understood is \"detect\"")]
    Task(String),
    /// The size of its input is unknown.
    #[error("the module does not say the size of its input, as those of ultralytics do: it has to be given")]
    NoInput,
    /// An impossible input size.
    #[error("an input of {0} pixels: allowed are 1 to {max} columns and rows", max = Network::MAX_INPUT_PIXELS)]
    Input(Size),
    /// Its metadata and its output differ.
    #[error("the module names {named} classes, and its output has {given}")]
    Names {
        /// Number of classes in its file.
        named: usize,
        /// Number of classes in its output.
        given: u32,
    },
    /// An unknown class.
    #[error("class {class}: the module has {known}, from 0 on")]
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
    #[error("the module failed on an image of {input} pixels: {reason}")]
    Run {
        /// Columns and rows.
        input: Size,
        /// libtorch's message.
        reason: String,
    },
    /// Its output is invalid.
    #[error(transparent)]
    Find(#[from] FindError),
}

/// Sets the number of CPU threads of libtorch.
pub fn set_threads(threads: u16) {
    tch::set_num_threads(threads.into());
}

/// Its output.
struct Numbers {
    values: Vec<f32>,
    shape: Vec<i64>,
}

impl Network {
    /// Maximum number of columns or rows of its input: an image of this size is allocated before the network is known
    /// to work.
    pub const MAX_INPUT_PIXELS: u32 = 4096;

    /// Loads a module from the bytes of its file, on this device; `input` is needed if the file does not give the input
    /// size, or to use another one. The module is run once on a gray image, so that errors are found here.
    ///
    /// Run-time optimization of libtorch is switched off for the process, so that the same image always gives the same
    /// boxes.
    ///
    /// # Errors
    /// If it is not a module, or its output is not that of a detector.
    pub fn load(module: &[u8], input: Option<Size>, device: Device) -> Result<Self, NetworkError> {
        let unreadable = |error: TchError| NetworkError::Unreadable(gist(&error));
        tch::jit::f_set_profiling_mode(false).map_err(unreadable)?;
        let mut loaded =
            CModule::load_data_on_device(&mut Cursor::new(module), device).map_err(unreadable)?;
        loaded.f_set_eval().map_err(unreadable)?;
        let metadata = Metadata::of(module);
        if let Some(task) = metadata.task.as_ref().filter(|task| *task != "detect") {
            return Err(NetworkError::Task(task.chars().take(40).collect()));
        }
        let input = input.or_else(|| metadata.input()).ok_or(NetworkError::NoInput)?;
        if ![input.width_pixels, input.height_pixels]
            .iter()
            .all(|side| (1..=Self::MAX_INPUT_PIXELS).contains(side))
        {
            return Err(NetworkError::Input(input));
        }
        let mut network = Self { module: loaded, device, input, names: metadata.names, class_count: 0 };
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

    /// The name of a class, if the module's file has it.
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
        let numbers = self.run(&values)?;
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
        let numbers = self.run(&prepare(&gray, Resolution::Full, self.input)?.values)?;
        let (classes, _) = Output::classes_and_anchors(&numbers.shape).map_err(FindError::Output)?;
        Ok(u32::try_from(classes).unwrap_or(u32::MAX))
    }

    /// Runs it on an input of shape `[3, rows, columns]`.
    fn run(&self, values: &[f32]) -> Result<Numbers, NetworkError> {
        let (rows, columns) = (i64::from(self.input.height_pixels), i64::from(self.input.width_pixels));
        let failed = |error: TchError| NetworkError::Run { input: self.input, reason: gist(&error) };
        let _no_gradients = tch::no_grad_guard();
        let image = Tensor::f_from_slice(values)
            .and_then(|image| image.f_reshape([1, 3, rows, columns]))
            .and_then(|image| image.f_to_device(self.device))
            .map_err(failed)?;
        let output = self.module.forward_ts(&[image]).map_err(failed)?;
        let shape = shape(&output).map_err(failed)?;
        // Before anything is copied.
        let (classes, anchors) = Output::classes_and_anchors(&shape).map_err(FindError::Output)?;
        let output = output
            .f_to_device(Device::Cpu)
            .and_then(|output| output.f_to_kind(Kind::Float))
            .and_then(|output| output.f_contiguous())
            .map_err(failed)?;
        let mut values = vec![0.0; (4 + classes) * anchors];
        output.f_copy_data(&mut values, (4 + classes) * anchors).map_err(failed)?;
        Ok(Numbers { values, shape })
    }
}

/// `Tensor::size` panics on undefined tensors.
fn shape(tensor: &Tensor) -> Result<Vec<i64>, TchError> {
    Vec::<i64>::try_from(&tensor.f_internal_shape_as_tensor()?)
}

/// The message of a libtorch error, without its place in libtorch or the module.
fn gist(error: &TchError) -> String {
    const MOST_CHARACTERS: usize = 300;
    let text = match error {
        TchError::Torch(text) => text.clone(),
        other => other.to_string(),
    };
    // The message of a TorchScript exception follows its stack, that of libtorch precedes it.
    let raised =
        text.lines().rev().find(|line| line.split_once(':').is_some_and(|(name, _)| is_exception(name)));
    let line = raised.or_else(|| text.lines().find(|line| !line.trim().is_empty())).unwrap_or_default();
    line.trim().chars().take(MOST_CHARACTERS).collect()
}

/// Whether this is the name of an exception, as `RuntimeError` and `builtins.ValueError` are.
fn is_exception(name: &str) -> bool {
    name.chars().all(|letter| letter.is_alphanumeric() || letter == '.')
        && (name.ends_with("Error") || name.ends_with("Exception"))
}
