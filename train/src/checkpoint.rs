//! A training that can be resumed, as a file.

use std::path::Path;

use dragnet_files::FileError;
use dragnet_learn::file::{self, Kind};
use dragnet_learn::shape::{Parameter, Shape};
use dragnet_learn::weights::{Recipe, Weights};
use serde::{Deserialize, Serialize};
use tch::{Device, Tensor};

use super::adam::Adam;
use super::data::Data;
use super::model::{tensor, values};
use super::settings::{Epoch, Settings};

/// The limit is enough for each parameter's four tensors, and for the history.
const KIND: Kind = Kind { name: "checkpoint", format: "dragnet-checkpoint-1", max_bytes: 1 << 29 };

/// The state of a training at the end of an epoch.
pub(super) struct Checkpoint {
    pub(super) weights: Weights,
    pub(super) best: Weights,
    pub(super) adam: Adam,
    pub(super) history: Vec<Epoch>,
}

/// The same by reference, for writing.
pub(super) struct View<'a> {
    pub(super) weights: &'a Weights,
    pub(super) best: &'a Weights,
    pub(super) adam: &'a Adam,
    pub(super) history: &'a [Epoch],
}

#[derive(Serialize, Deserialize)]
struct Header {
    settings: Settings,
    /// Number of training decisions, which identifies the data.
    decisions: usize,
    expert: String,
    best: Recipe,
    history: Vec<Epoch>,
    steps: u64,
}

/// The four tensors of each parameter.
const PARTS: [&str; 4] = ["weights", "best", "first_moment", "second_moment"];

pub(super) fn write(path: &Path, settings: &Settings, data: &Data, now: &View<'_>) -> Result<(), FileError> {
    let header = Header {
        settings: settings.clone(),
        decisions: data.len(),
        expert: data.source().to_string(),
        best: now.best.recipe().clone(),
        history: now.history.to_vec(),
        steps: now.adam.steps,
    };
    let bytes = to_bytes(&header, settings.shape, now).map_err(|reason| FileError::content(path, reason))?;
    dragnet_files::write(path, &bytes)
}

fn to_bytes(header: &Header, shape: Shape, now: &View<'_>) -> Result<Vec<u8>, String> {
    let mut tensors = Vec::new();
    for (place, Parameter { name, shape }) in shape.parameters().into_iter().enumerate() {
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
    file::serialize(KIND, header, &tensors)
}

pub(super) fn read(
    path: &Path,
    settings: &Settings,
    data: &Data,
    device: Device,
) -> Result<Checkpoint, FileError> {
    file::read(KIND, path, |bytes| from_bytes(bytes, settings, data, device))
}

fn from_bytes(bytes: &[u8], settings: &Settings, data: &Data, device: Device) -> Result<Checkpoint, String> {
    let (header, tensors): (Header, _) = file::parse(KIND, bytes)?;
    let (decisions, expert) = (data.len(), data.source().to_string());
    if header.settings != *settings || header.decisions != decisions || header.expert != expert {
        return Err(format!(
            "a checkpoint of another training: {} decisions of {}, {:?}; this one has {decisions} of {expert}, {settings:?}",
            header.decisions, header.expert, header.settings
        ));
    }
    let shape = settings.shape;
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
