//! TorchScript modules, which libtorch runs.

use std::io::Cursor;

use tch::{CModule, Device, Kind, TchError, Tensor};

use super::{Format, NetworkError, Numbers, Runtime};
use crate::metadata::Metadata;
use crate::output::Output;
use crate::picture::Size;
use crate::settings::Processor;
use crate::{FindError, metadata};

/// A module and where it runs.
#[derive(Debug)]
pub(super) struct Module {
    module: CModule,
    device: Device,
}

impl Module {
    /// Loads a module from the bytes of its file.
    ///
    /// Threads and run-time optimization of libtorch are those of the process; the latter is switched off, so that the
    /// same image always gives the same boxes.
    pub(super) fn load(bytes: &[u8], processor: Processor) -> Result<(Self, Metadata), NetworkError> {
        let unreadable =
            |error: TchError| NetworkError::Unreadable { format: Format::TorchScript, reason: gist(&error) };
        tch::set_num_threads(processor.threads.into());
        let device = if processor.may_use_gpu { Device::cuda_if_available() } else { Device::Cpu };
        tch::jit::f_set_profiling_mode(false).map_err(unreadable)?;
        let mut module = CModule::load_data_on_device(&mut Cursor::new(bytes), device).map_err(unreadable)?;
        module.f_set_eval().map_err(unreadable)?;
        Ok((Self { module, device }, metadata::of_module(bytes)))
    }
}

impl Runtime for Module {
    fn run(&self, values: Vec<f32>, input: Size) -> Result<Numbers, NetworkError> {
        let (rows, columns) = (i64::from(input.height_pixels), i64::from(input.width_pixels));
        let failed = |error: TchError| NetworkError::Run { input, reason: gist(&error) };
        let _no_gradients = tch::no_grad_guard();
        let image = Tensor::f_from_slice(&values)
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
