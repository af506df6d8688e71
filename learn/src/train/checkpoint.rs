//! A training that was stopped, as a file.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tch::{Device, Tensor};

use super::adam::Adam;
use super::data::Data;
use super::model::{tensor, values};
use super::trainer::{Epoch, Settings};
use crate::container::{self, Kind, write_whole};
use crate::shape::{Parameter, Shape};
use crate::weights::{Recipe, Weights};

const KIND: Kind = Kind { name: "checkpoint", format: "dragnet-checkpoint-1" };

/// Why a training cannot be kept or gone on with.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read.
    #[error("{path}: cannot read the checkpoint: {source}")]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It cannot be written; an older one is kept.
    #[error("{path}: cannot write the checkpoint: {source}")]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is not a checkpoint of this training.
    #[error("{path}: {reason}")]
    Content {
        /// Which.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
}

impl CheckpointError {
    pub(super) fn content(path: &Path, reason: String) -> Self {
        Self::Content { path: path.to_owned(), reason }
    }
}

/// What a training was at the end of an epoch.
pub(super) struct Checkpoint {
    pub(super) weights: Weights,
    pub(super) best: Weights,
    pub(super) adam: Adam,
    pub(super) history: Vec<Epoch>,
}

/// The same, to be written.
pub(super) struct View<'a> {
    pub(super) weights: &'a Weights,
    pub(super) best: &'a Weights,
    pub(super) adam: &'a Adam,
    pub(super) history: &'a [Epoch],
}

#[derive(Serialize, Deserialize)]
struct Header {
    settings: Settings,
    /// Of what is learned from: another number is another training.
    decisions: usize,
    expert: String,
    best: Recipe,
    history: Vec<Epoch>,
    steps: u64,
}

/// The four tensors of each parameter.
const PARTS: [&str; 4] = ["weights", "best", "first_moment", "second_moment"];

pub(super) fn write(
    path: &Path,
    settings: &Settings,
    data: &Data,
    now: &View<'_>,
) -> Result<(), CheckpointError> {
    let header = Header {
        settings: settings.clone(),
        decisions: data.len(),
        expert: data.source().to_string(),
        best: now.best.recipe().clone(),
        history: now.history.to_vec(),
        steps: now.adam.steps,
    };
    let bytes =
        to_bytes(&header, settings.shape, now).map_err(|reason| CheckpointError::content(path, reason))?;
    write_whole(path, &bytes).map_err(|source| CheckpointError::Write { path: path.to_owned(), source })
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
            tensors.push(container::Tensor::of_floats(format!("{part}.{name}"), shape.clone(), &values));
        }
    }
    container::serialize(KIND, header, &tensors)
}

pub(super) fn read(
    path: &Path,
    settings: &Settings,
    data: &Data,
    device: Device,
) -> Result<Checkpoint, CheckpointError> {
    let bytes = fs::read(path).map_err(|source| CheckpointError::Read { path: path.to_owned(), source })?;
    from_bytes(&bytes, settings, data, device).map_err(|reason| CheckpointError::content(path, reason))
}

fn from_bytes(bytes: &[u8], settings: &Settings, data: &Data, device: Device) -> Result<Checkpoint, String> {
    let (header, tensors): (Header, _) = container::parse(KIND, bytes)?;
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
