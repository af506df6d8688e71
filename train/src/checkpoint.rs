//! A training that can be resumed, as a file.

use std::fmt::Debug;
use std::path::Path;

use dragnet_files::FileError;
use dragnet_learn::file::{self, Kind};
use dragnet_learn::shape::{Parameter, Shape};
use dragnet_learn::weights::{Recipe, Weights};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use tch::{Device, Tensor};

use super::adam::Adam;
use super::model::{tensor, values};

/// The limit is enough for each parameter's four tensors, and for the history.
const KIND: Kind = Kind { name: "checkpoint", format: "dragnet-checkpoint-2", max_bytes: 1 << 29 };

/// The state of a training between two passes, each of which left an `E` in its history.
pub(super) struct Checkpoint<E> {
    pub(super) weights: Weights,
    pub(super) best: Weights,
    pub(super) adam: Adam,
    pub(super) history: Vec<E>,
}

/// The same by reference, for writing.
pub(super) struct View<'a, E> {
    pub(super) weights: &'a Weights,
    pub(super) best: &'a Weights,
    pub(super) adam: &'a Adam,
    pub(super) history: &'a [E],
}

/// `T` is what identifies a training: its settings, and what it learns from.
#[derive(Serialize, Deserialize)]
struct Header<T, E> {
    training: T,
    best: Recipe,
    history: Vec<E>,
    steps: u64,
}

/// The four tensors of each parameter.
const PARTS: [&str; 4] = ["weights", "best", "first_moment", "second_moment"];

pub(super) fn write<T: Serialize, E: Serialize>(
    path: &Path,
    training: &T,
    now: &View<'_, E>,
) -> Result<(), FileError> {
    let bytes = to_bytes(training, now).map_err(|reason| FileError::content(path, reason))?;
    dragnet_files::write(path, &bytes)
}

fn to_bytes<T: Serialize, E: Serialize>(training: &T, now: &View<'_, E>) -> Result<Vec<u8>, String> {
    let header = Header {
        training,
        best: now.best.recipe().clone(),
        history: now.history.iter().collect(),
        steps: now.adam.steps,
    };
    let mut tensors = Vec::new();
    for (place, Parameter { name, shape }) in now.weights.shape().parameters().into_iter().enumerate() {
        let parts = [
            now.weights.get(&name).to_vec(),
            now.best.get(&name).to_vec(),
            values(&now.adam.first[place]),
            values(&now.adam.second[place]),
        ];
        for (part, values) in PARTS.iter().zip(parts) {
            tensors.push(file::Tensor::of_floats(format!("{part}.{name}"), shape.clone(), &values));
        }
    }
    file::serialize(KIND, &header, &tensors)
}

pub(super) fn read<T: DeserializeOwned + PartialEq + Debug, E: DeserializeOwned>(
    path: &Path,
    training: &T,
    shape: Shape,
    device: Device,
) -> Result<Checkpoint<E>, FileError> {
    file::read(KIND, path, |bytes| from_bytes(bytes, training, shape, device))
}

fn from_bytes<T: DeserializeOwned + PartialEq + Debug, E: DeserializeOwned>(
    bytes: &[u8],
    training: &T,
    shape: Shape,
    device: Device,
) -> Result<Checkpoint<E>, String> {
    let (header, tensors): (Header<T, E>, _) = file::parse(KIND, bytes)?;
    if header.training != *training {
        return Err(format!(
            "a checkpoint of another training: {:?}; this one is {training:?}",
            header.training
        ));
    }
    let part = |part: &str| -> Result<Vec<Vec<f32>>, String> {
        let parameters = shape.parameters().into_iter();
        parameters
            .map(|Parameter { name, shape }| tensors.floats(&format!("{part}.{name}"), &shape))
            .collect()
    };
    let weights = |name: &str, recipe| {
        let mut values = part(name)?.into_iter();
        Weights::build(shape, recipe, |_, _| values.next().unwrap_or_default())
    };
    let moments = |name: &str| -> Result<Vec<Tensor>, String> {
        let parameters = part(name)?.into_iter().zip(shape.parameters());
        Ok(parameters.map(|(values, parameter)| tensor(&values, &parameter.shape, device)).collect())
    };
    let [weights_name, best, first, second] = PARTS;
    Ok(Checkpoint {
        weights: weights(weights_name, Recipe::default())?,
        best: weights(best, header.best)?,
        adam: Adam { steps: header.steps, first: moments(first)?, second: moments(second)? },
        history: header.history,
    })
}
