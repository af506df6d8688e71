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
    /// What of the weights is learned: Adam has moments for these.
    pub(super) learned: &'a [Parameter],
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

/// The tensors of each parameter; moments are of those that are learned.
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
    let mut add = |part: &str, parameter: &Parameter, values: &[f32]| {
        let Parameter { name, shape } = parameter;
        tensors.push(file::Tensor::of_floats(format!("{part}.{name}"), shape.clone(), values));
    };
    let [weights, best, first, second] = PARTS;
    for parameter in now.weights.shape().parameters() {
        add(weights, &parameter, now.weights.get(&parameter.name));
        add(best, &parameter, now.best.get(&parameter.name));
    }
    for (place, parameter) in now.learned.iter().enumerate() {
        add(first, parameter, &values(&now.adam.first[place]));
        add(second, parameter, &values(&now.adam.second[place]));
    }
    file::serialize(KIND, &header, &tensors)
}

pub(super) fn read<T: DeserializeOwned + PartialEq + Debug, E: DeserializeOwned>(
    path: &Path,
    training: &T,
    (shape, learned): (Shape, &[Parameter]),
    device: Device,
) -> Result<Checkpoint<E>, FileError> {
    file::read(KIND, path, |bytes| from_bytes(bytes, training, (shape, learned), device))
}

fn from_bytes<T: DeserializeOwned + PartialEq + Debug, E: DeserializeOwned>(
    bytes: &[u8],
    training: &T,
    (shape, learned): (Shape, &[Parameter]),
    device: Device,
) -> Result<Checkpoint<E>, String> {
    let (header, tensors): (Header<T, E>, _) = file::parse(KIND, bytes)?;
    if header.training != *training {
        return Err(format!(
            "a checkpoint of another training: {:?}; this one is {training:?}",
            header.training
        ));
    }
    let part = |part: &str, parameters: &[Parameter]| -> Result<Vec<Vec<f32>>, String> {
        parameters.iter().map(|it| tensors.floats(&format!("{part}.{}", it.name), &it.shape)).collect()
    };
    let weights = |name: &str, recipe| {
        let mut values = part(name, &shape.parameters())?.into_iter();
        Weights::build(shape, recipe, |_, _| values.next().unwrap_or_default())
    };
    let moments = |name: &str| -> Result<Vec<Tensor>, String> {
        let parameters = part(name, learned)?.into_iter().zip(learned);
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
