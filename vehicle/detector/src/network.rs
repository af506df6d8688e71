//! The network: a TorchScript module that libtorch runs.
//!
//! A module is a program. Load none of which you do not know who made it: nothing here keeps it from running for ever.

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

/// A network that finds objects in images.
#[derive(Debug)]
pub struct Network {
    module: CModule,
    device: Device,
    input: Size,
    names: BTreeMap<u32, String>,
    class_count: u32,
}

/// Why a network cannot be used, or says nothing of an image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Not a module.
    #[error("not a TorchScript module that can be read: {0}")]
    Unreadable(String),
    /// Made for something else.
    #[error("a module for the task {0:?}: understood is \"detect\"")]
    Task(String),
    /// Nobody says how large its images are.
    #[error("the module does not say the size of its input, as those of ultralytics do: it has to be given")]
    NoInput,
    /// Larger than any network's, or nothing at all.
    #[error("an input of {0} pixels: allowed are 1 to {max} columns and rows", max = Network::MAX_INPUT_PIXELS)]
    Input(Size),
    /// What it says of itself and what it does differ.
    #[error("the module names {named} classes, and its output has {given}")]
    Names {
        /// In its file.
        named: usize,
        /// In its output.
        given: u32,
    },
    /// A class that it does not know.
    #[error("class {class}: the module knows {known}, from 0 on")]
    Class {
        /// As asked for.
        class: u32,
        /// As many as there are.
        known: u32,
    },
    /// The image cannot be shown to it.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// It came to no end of its own.
    #[error("the module failed on an image of {input} pixels: {reason}")]
    Run {
        /// Columns and rows.
        input: Size,
        /// As libtorch says it.
        reason: String,
    },
    /// What it said says nothing of the image.
    #[error(transparent)]
    Find(#[from] FindError),
}

/// Lets libtorch use so many threads of the CPU.
pub fn set_threads(threads: u16) {
    tch::set_num_threads(threads.into());
}

/// What came out of it.
struct Numbers {
    values: Vec<f32>,
    shape: Vec<i64>,
}

impl Network {
    /// So many columns or rows may its input have: before it is known to be a network, an image is made for it.
    pub const MAX_INPUT_PIXELS: u32 = 4096;

    /// A module, as the bytes of its file, on this device; `input` where the file does not say how large its images are, or
    /// it takes other sizes too. It is shown a gray image, so that one that cannot work is found out here.
    ///
    /// From here on libtorch does not watch how modules run in order to run them in another way: the same image gives
    /// the same boxes the first time and the last.
    ///
    /// # Errors
    /// If it is no module, or what comes out of it is not the output of a detector.
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

    /// Of the images that it takes.
    #[must_use]
    pub const fn input(&self) -> Size {
        self.input
    }

    /// So many classes does it tell apart, from 0 on.
    #[must_use]
    pub const fn classes(&self) -> u32 {
        self.class_count
    }

    /// What a class is called, if the module's file says it.
    #[must_use]
    pub fn name(&self, class: u32) -> Option<&str> {
        self.names.get(&class).map(String::as_str)
    }

    /// The class of this name, the first of them.
    #[must_use]
    pub fn class_named(&self, name: &str) -> Option<u32> {
        self.names.iter().find(|(_, known)| *known == name).map(|(&class, _)| class)
    }

    /// What it finds in an image.
    ///
    /// # Errors
    /// If the settings ask for what cannot be, the image cannot be shown to it, or it fails on it. It can be asked of
    /// the next image all the same.
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

    /// As many as its output has, of a gray image.
    fn class_count(&self) -> Result<u32, NetworkError> {
        let size = Size { width_pixels: 1, height_pixels: 1 };
        let gray = Picture::new(size, PixelFormat::Mono8, &[114]).map_err(PrepareError::Picture)?;
        let numbers = self.run(&prepare(&gray, Resolution::Full, self.input)?.values)?;
        let (classes, _) = Output::classes_and_anchors(&numbers.shape).map_err(FindError::Output)?;
        Ok(u32::try_from(classes).unwrap_or(u32::MAX))
    }

    /// Of an input of shape `[3, rows, columns]`.
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

/// `Tensor::size` panics of tensors that have none.
fn shape(tensor: &Tensor) -> Result<Vec<i64>, TchError> {
    Vec::<i64>::try_from(&tensor.f_internal_shape_as_tensor()?)
}

/// What an error of libtorch says, without where in libtorch or the module it happened.
fn gist(error: &TchError) -> String {
    const MOST_CHARACTERS: usize = 300;
    let text = match error {
        TchError::Torch(text) => text.clone(),
        other => other.to_string(),
    };
    // An exception of TorchScript stands below where it came from, one of libtorch's own above.
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
