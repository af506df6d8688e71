//! A network's parameters as a file: safetensors, with a record of how they were trained.

use std::path::Path;

use dragnet_files::FileError;
use serde::{Deserialize, Serialize};

use crate::file::{self, Kind, Tensor};
use crate::graph::feature_names;
use crate::shape::{Parameter, Shape};

/// The limit is enough for 16 million parameters; the built-in networks have 8,000.
const KIND: Kind = Kind { name: "weights", format: "dragnet-weights-2", max_bytes: 1 << 26 };

#[derive(Serialize, Deserialize)]
struct Header {
    /// [`feature_names`] of the program that made the file.
    features: Vec<String>,
    shape: Shape,
    recipe: Recipe,
}

/// A complete set of parameters: each is present, has the shape of [`Shape::parameters`], and is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    shape: Shape,
    recipe: Recipe,
    /// In the order of [`Shape::parameters`].
    tensors: Vec<(String, Vec<f32>)>,
}

/// How the weights were trained.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// The expert that was imitated.
    pub expert: String,
    /// Scenarios that it was recorded on.
    pub scenarios: Vec<String>,
    /// Number of decisions that they were trained on.
    pub decisions: u64,
    /// Seed of the training.
    pub seed: u64,
    /// Number of passes over the decisions.
    pub epochs: u32,
    /// Mean loss on validation trajectories, nats.
    pub held_out_loss: f64,
    /// Version and commit of the program.
    pub program: String,
    /// If the expert scored only cells with a path shorter than this, cells: the network chooses among those.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_cells: Option<f32>,
    /// Number of its own searches that the network learned from after that, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_searches: Option<u64>,
}

impl Weights {
    /// Weights of a shape; `values` gives the values of each parameter.
    ///
    /// # Errors
    /// If a parameter has another number of values, or one that is not finite.
    pub fn build(
        shape: Shape,
        recipe: Recipe,
        mut values: impl FnMut(&str, &[usize]) -> Vec<f32>,
    ) -> Result<Self, String> {
        if !shape.is_valid() {
            return Err(format!("no network has the sizes {shape:?}"));
        }
        let parameters = shape.parameters().into_iter().map(|parameter| {
            let values = values(&parameter.name, &parameter.shape);
            check(&parameter.name, &parameter.shape, &values)?;
            Ok((parameter.name, values))
        });
        Ok(Self { shape, recipe, tensors: parameters.collect::<Result<_, String>>()? })
    }

    /// Reads a weights file.
    ///
    /// # Errors
    /// If the file cannot be read, is truncated, has another format, shape or feature set, or contains a number that is
    /// not finite.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        file::read(KIND, path, Self::from_bytes)
    }

    /// Weights from the bytes of a file.
    ///
    /// # Errors
    /// As for [`Weights::load`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (header, tensors): (Header, _) = file::parse(KIND, bytes)?;
        let known = feature_names(header.shape.features());
        if header.features != known {
            let (found, known) = (header.features.join(", "), known.join(", "));
            return Err(format!("weights for the features {found}; this program has {known}"));
        }
        let Header { shape, recipe, .. } = header;
        if !shape.is_valid() {
            return Err(format!("no network has the sizes {shape:?}"));
        }
        let read = shape.parameters().into_iter().map(|Parameter { name, shape }| {
            let values = tensors.floats(&name, &shape).map_err(|what| format!("parameter {what}"))?;
            check(&name, &shape, &values)?;
            Ok((name, values))
        });
        let read = read.collect::<Result<Vec<_>, String>>()?;
        if tensors.count() != read.len() {
            return Err(format!(
                "{} parameters; a network of these sizes has {}",
                tensors.count(),
                read.len()
            ));
        }
        Ok(Self { shape, recipe, tensors: read })
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// If the weights cannot be serialized.
    pub fn to_bytes(&self) -> Result<Vec<u8>, String> {
        let header = Header {
            features: feature_names(self.shape.features()).into_iter().map(str::to_owned).collect(),
            shape: self.shape,
            recipe: self.recipe.clone(),
        };
        let parameters = self.shape.parameters().into_iter().zip(&self.tensors);
        let tensors: Vec<Tensor> = parameters
            .map(|(parameter, (_, values))| Tensor::of_floats(parameter.name, parameter.shape, values))
            .collect();
        file::serialize(KIND, &header, &tensors)
    }

    /// Sizes of the network.
    #[must_use]
    pub const fn shape(&self) -> Shape {
        self.shape
    }

    /// How the weights were trained.
    #[must_use]
    pub const fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The values of a parameter, row-major; empty for an unknown name.
    #[must_use]
    pub fn get(&self, name: &str) -> &[f32] {
        self.tensors.iter().find(|(known, _)| known == name).map_or(&[], |(_, values)| values)
    }
}

fn check(name: &str, shape: &[usize], values: &[f32]) -> Result<(), String> {
    let expected: usize = shape.iter().product();
    if values.len() != expected {
        return Err(format!("parameter {name} has {} values; expected {expected}", values.len()));
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => Err(format!("parameter {name} holds {} at place {place}", values[place])),
        None => Ok(()),
    }
}
