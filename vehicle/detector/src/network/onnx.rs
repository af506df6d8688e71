//! ONNX files, which the crate `rten` runs: plain Rust, on the CPU, with the vector instructions of the machine.
//!
//! A damaged or hostile file must be an error, and not the end of the program. `rten` trusts the lengths that a file states
//! and follows graphs within graphs to any depth; [`structure`] checks both before. If it panics all the same, that is an
//! error of the network. Nothing bounds the memory or the time that a network takes.

mod operators;
mod structure;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use rten::{DataType, Dimension, Model, ModelOptions, RunOptions, ThreadPool, Value, ValueType};
use rten_tensor::Layout;

use super::{Format, NetworkError, Numbers, Runtime};
use crate::FindError;
use crate::metadata::{self, Metadata};
use crate::output::Output;
use crate::picture::Size;
use crate::settings::Processor;

/// A network and the threads that run it.
#[derive(Debug)]
pub(super) struct Graph {
    model: Model,
    threads: Arc<ThreadPool>,
}

impl Graph {
    /// Loads a network from the bytes of its file.
    pub(super) fn load(bytes: &[u8], processor: Processor) -> Result<(Self, Metadata), NetworkError> {
        let unreadable = |reason: String| NetworkError::Unreadable { format: Format::Onnx, reason };
        structure::check(bytes).map_err(|error| unreadable(error.to_string()))?;
        let model = guarded(|| {
            let mut options = ModelOptions::with_ops(operators::of_detectors());
            options.prepack_weights(true).load(bytes.to_vec()).map_err(|error| gist(&error.to_string()))
        })
        .map_err(unreadable)?;
        let fixed_input = image_input(&model).map_err(NetworkError::Interface)?;
        let metadata = Metadata { fixed_input, ..metadata::of_texts(|name| model.metadata().get(name)) };
        let threads = Arc::new(ThreadPool::with_num_threads(processor.threads.into()));
        Ok((Self { model, threads }, metadata))
    }
}

impl Runtime for Graph {
    fn run(&self, values: Vec<f32>, input: Size) -> Result<Numbers, NetworkError> {
        let shape = [1, 3, input.height_pixels as usize, input.width_pixels as usize];
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.threads)));
        let output = guarded(|| {
            let image = Value::from_shape(shape, values).map_err(|error| gist(&error.to_string()))?;
            self.model.run_one(image.into(), Some(options)).map_err(|error| gist(&error.to_string()))
        });
        let output = output.map_err(|reason| NetworkError::Run { input, reason })?;
        let shape: Vec<i64> =
            output.shape().iter().map(|&side| i64::try_from(side).unwrap_or(i64::MAX)).collect();
        // Three dimensions, or it is not understood.
        Output::classes_and_anchors(&shape).map_err(FindError::Output)?;
        let reason = "its output is none of 32-bit floats".to_owned();
        let (_, values) =
            output.into_shape_vec::<f32, 3>().map_err(|_| NetworkError::Run { input, reason })?;
        Ok(Numbers { values, shape })
    }
}

/// The size of the images that a network takes, if it is fixed; or why it takes none.
fn image_input(model: &Model) -> Result<Option<Size>, String> {
    let (inputs, outputs) = (model.input_ids(), model.output_ids());
    if (inputs.len(), outputs.len()) != (1, 1) {
        return Err(format!("inputs and outputs: {} and {}", inputs.len(), outputs.len()));
    }
    let kind = model.node_info(inputs[0]).and_then(|input| input.dtype());
    if kind.is_some_and(|kind| kind != ValueType::Tensor(DataType::Float)) {
        return Err("an input of other numbers".to_owned());
    }
    let Some(shape) = model.input_shape(0) else { return Ok(None) };
    let is = |dimension: &Dimension, wanted: usize| !matches!(dimension, Dimension::Fixed(size) if *size != wanted);
    match &shape[..] {
        [batch, channels, rows, columns] if is(batch, 1) && is(channels, 3) => {
            let (Dimension::Fixed(rows), Dimension::Fixed(columns)) = (rows, columns) else {
                return Ok(None);
            };
            let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
            Ok(Some(Size { width_pixels: side(*columns), height_pixels: side(*rows) }))
        }
        _ => {
            let sides: Vec<String> = shape.iter().map(side).collect();
            Err(format!("an input of shape [{}]", sides.join(", ")))
        }
    }
}

/// A number, or a name for any.
fn side(dimension: &Dimension) -> String {
    match dimension {
        Dimension::Fixed(size) => size.to_string(),
        Dimension::Symbolic(name) => gist(name),
    }
}

/// What `rten` returns, or what it said when it panicked.
fn guarded<T>(run: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(gist(text.unwrap_or("the runtime gave up")))
    })
}

/// One line of bounded length.
fn gist(text: &str) -> String {
    const MOST_CHARACTERS: usize = 300;
    let line = text.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
    line.trim().chars().filter(|letter| !letter.is_control()).take(MOST_CHARACTERS).collect()
}
