//! The parts of a file, so that a test can change one of them.

use std::collections::HashMap;

use safetensors::SafeTensors;
use safetensors::tensor::{Dtype, TensorView};
use serde_json::Value;

const HEADER_KEY: &str = "dragnet";

/// Dragnet's header, and the tensors.
pub(crate) struct Parts {
    pub(crate) header: Value,
    pub(crate) tensors: Vec<Part>,
}

/// A tensor.
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) dtype: Dtype,
    pub(crate) shape: Vec<usize>,
    pub(crate) bytes: Vec<u8>,
}

impl Parts {
    pub(crate) fn of(file: &[u8]) -> Self {
        let (_, metadata) = SafeTensors::read_metadata(file).unwrap();
        let header = &metadata.metadata().as_ref().unwrap()[HEADER_KEY];
        let tensors = SafeTensors::deserialize(file).unwrap();
        let part = |(name, tensor): (&str, TensorView<'_>)| Part {
            name: name.to_owned(),
            dtype: tensor.dtype(),
            shape: tensor.shape().to_vec(),
            bytes: tensor.data().to_vec(),
        };
        Self { header: serde_json::from_str(header).unwrap(), tensors: tensors.iter().map(part).collect() }
    }

    /// The tensor of a name.
    pub(crate) fn get(&mut self, name: &str) -> &mut Part {
        self.tensors.iter_mut().find(|part| part.name == name).unwrap()
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let views = self.tensors.iter().map(|Part { name, dtype, shape, bytes }| {
            (name.as_str(), TensorView::new(*dtype, shape.clone(), bytes).unwrap())
        });
        let header = HashMap::from([(HEADER_KEY.to_owned(), self.header.to_string())]);
        safetensors::serialize(views, Some(header)).unwrap()
    }
}

/// The file with a change.
pub(crate) fn changed(file: &[u8], change: impl FnOnce(&mut Parts)) -> Vec<u8> {
    let mut parts = Parts::of(file);
    change(&mut parts);
    parts.bytes()
}
