//! The network of [`dragnet_learn::network`] in libtorch, which computes its gradients.

use dragnet_search::seed::{Purpose, Stream, stream};
use rand::RngExt;
use tch::{Device, Kind, Tensor};

use super::batch::{Batch, Neighbors, int};
use dragnet_learn::graph::Graph;
use dragnet_learn::network::{LEAST_SUM, LOGIT_SCALE, SCORE_LEAK, SUM_LOG_RANGE};
use dragnet_learn::shape::{HEADS, Shape};
use dragnet_learn::weights::{Recipe, Weights};

/// A network in training.
#[derive(Debug)]
pub struct Model {
    shape: Shape,
    /// In the order of [`Shape::parameters`].
    parameters: Vec<(String, Tensor)>,
    device: Device,
}

/// Initial shares that remain after one cell, of the first and the last decay channel.
const FIRST_FADE: (f64, f64) = (0.5, 0.95);

impl Model {
    /// An untrained network: matrices are drawn by Glorot and Bengio (2010), biases are 0.
    #[must_use]
    pub fn new(shape: Shape, seed: u64, device: Device) -> Self {
        let mut random = stream(seed, Purpose::Training, 0);
        let parameters = shape.parameters().into_iter().map(|parameter| {
            let values = first_values(&parameter.name, &parameter.shape, &mut random);
            (parameter.name, learnable(&values, &parameter.shape, device))
        });
        Self { shape, parameters: parameters.collect(), device }
    }

    /// The network of given weights, to continue training or to compare.
    #[must_use]
    pub fn of(weights: &Weights, device: Device) -> Self {
        let shape = weights.shape();
        let parameters = shape.parameters().into_iter().map(|parameter| {
            let tensor = learnable(weights.get(&parameter.name), &parameter.shape, device);
            (parameter.name, tensor)
        });
        Self { shape, parameters: parameters.collect(), device }
    }

    /// The current weights.
    ///
    /// # Errors
    /// If one is no longer finite.
    pub fn weights(&self, recipe: Recipe) -> Result<Weights, String> {
        Weights::build(self.shape, recipe, |name, _| values(self.get(name)))
    }

    /// Logits of one graph, shape `[nodes]`, as computed by [`dragnet_learn::network::Network::logits`].
    #[must_use]
    pub fn logits_of(&self, graph: &Graph) -> Vec<f32> {
        let batch = Batch::of_graphs(&[graph], self.device);
        tch::no_grad(|| values(&self.logits(&batch)))
    }

    pub(super) const fn device(&self) -> Device {
        self.device
    }

    pub(super) fn parameters(&self) -> &[(String, Tensor)] {
        &self.parameters
    }

    fn get(&self, name: &str) -> &Tensor {
        let found = self.parameters.iter().find(|(known, _)| known == name);
        // Names come from the shape, and so do the parameters.
        &found.unwrap_or(&self.parameters[0]).1
    }

    fn linear(&self, name: &str, input: &Tensor) -> Tensor {
        input.linear(self.get(&format!("{name}.weight")), Some(self.get(&format!("{name}.bias"))))
    }

    /// Logits, shape `[graphs, nodes]`; those of padding have no meaning.
    pub(super) fn logits(&self, batch: &Batch) -> Tensor {
        let mut channels = self.linear("encoder", &batch.features).leaky_relu();
        for layer in 0..self.shape.layers {
            channels = self.attend(&format!("attention.{layer}"), &channels, &batch.neighbors);
        }
        if self.shape.levels > 0 {
            channels = self.through_levels(channels, batch);
        }
        if self.shape.decay_channels > 0 {
            let decaying = self.linear("decay", &channels).leaky_relu() * &batch.is_node;
            let faded = batch.carry(decaying, Some(&self.get("decay.factor").sigmoid()));
            channels = Tensor::cat(&[channels, faded], 1);
        }
        let mixed = self.linear("mix", &channels).leaky_relu();
        let mut inputs = vec![mixed];
        if self.shape.sum_channels > 0 {
            let (least, most) = SUM_LOG_RANGE;
            let values = self.linear("sum", &inputs[0]).clamp(f64::from(least), f64::from(most)).exp();
            let sums = batch.carry(values * &batch.is_candidate, None);
            inputs.push((sums + f64::from(LEAST_SUM)).log());
        }
        inputs.push(batch.features.shallow_clone());
        let inputs = Tensor::cat(&inputs, 1);
        let head = self.linear("head", &inputs).leaky_relu();
        let logits = self.linear("logit", &Tensor::cat(&[head, inputs], 1)) * f64::from(LOGIT_SCALE);
        logits.narrow(0, 0, batch.graphs * batch.nodes).view([batch.graphs, batch.nodes])
    }

    /// The channels of cells with what the coarser graphs bring.
    fn through_levels(&self, cells: Tensor, batch: &Batch) -> Tensor {
        let mut channels = vec![cells];
        for (number, level) in (1..).zip(&batch.levels) {
            let below = &channels[number - 1];
            let sums = Tensor::zeros([level.size.size()[0], below.size()[1]], (Kind::Float, self.device));
            let mean = sums.index_add(0, &level.piece, below) / &level.parts;
            let inputs = Tensor::cat(&[&mean, &level.size], 1);
            let mut gathered = self.linear(&format!("gather.{number}"), &inputs).leaky_relu();
            for name in self.shape.gathering(number) {
                gathered = self.attend(&name, &gathered, &level.neighbors);
            }
            channels.push(gathered);
        }
        for (number, level) in batch.levels.iter().enumerate().rev() {
            let spread = self.linear(&format!("spread.{number}"), &channels[number + 1]).leaky_relu();
            let mut under = &channels[number] + spread.index_select(0, &level.piece);
            let neighbors = number.checked_sub(1).map_or(&batch.neighbors, |it| &batch.levels[it].neighbors);
            for name in self.shape.refining(number) {
                under = self.attend(&name, &under, neighbors);
            }
            channels[number] = under;
        }
        channels.swap_remove(0)
    }

    /// A layer's channels, with its input added.
    fn attend(&self, name: &str, channels: &Tensor, neighbors: &Neighbors) -> Tensor {
        let get = |part: &str| self.get(&format!("{name}.{part}"));
        let (rows, slots) = (channels.size()[0], neighbors.slots);
        let (heads, width) = (int(HEADS), channels.size()[1] / int(HEADS));
        let projected = channels.linear(get("weight"), None::<&Tensor>);
        let of_heads = projected.view([rows, heads, width]);
        let score =
            |vector: &Tensor| (&of_heads * vector).sum_dim_intlist([-1_i64].as_slice(), false, Kind::Float);
        let source = score(get("source")).index_select(0, &neighbors.rows).view([rows, slots, heads]);
        let scores = source + score(get("target")).unsqueeze(1) + &neighbors.inverse_distance * get("edge");
        let scores = scores.maximum(&(&scores * f64::from(SCORE_LEAK)));
        let attention = (scores + &neighbors.is_missing).softmax(1, Kind::Float) * &neighbors.is_there;
        let values = projected.index_select(0, &neighbors.rows).view([rows, slots, heads, width]);
        let sum = (values * attention.unsqueeze(-1)).sum_dim_intlist([1_i64].as_slice(), false, Kind::Float);
        channels + (sum.view([rows, heads * width]) + get("bias")).leaky_relu()
    }
}

fn first_values(name: &str, shape: &[usize], random: &mut Stream) -> Vec<f32> {
    let count: usize = shape.iter().product();
    if name == "decay.factor" {
        let (first, last) = FIRST_FADE;
        let left = |place: usize| first + (last - first) * place as f64 / (count.max(2) - 1) as f64;
        return (0..count).map(|place| logit(left(place))).collect();
    }
    if shape.len() < 2 {
        return vec![0.0; count];
    }
    #[expect(clippy::cast_possible_truncation, reason = "parameters are f32")]
    let limit = (6.0 / (shape[0] + shape[1]) as f64).sqrt() as f32;
    (0..count).map(|_| limit * (2.0 * random.random::<f32>() - 1.0)).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "parameters are f32")]
fn logit(share: f64) -> f32 {
    (share / (1.0 - share)).ln() as f32
}

fn learnable(values: &[f32], shape: &[usize], device: Device) -> Tensor {
    tensor(values, shape, device).set_requires_grad(true)
}

/// A tensor of these values, row-major.
pub(super) fn tensor(values: &[f32], shape: &[usize], device: Device) -> Tensor {
    let shape: Vec<i64> = shape.iter().copied().map(int).collect();
    Tensor::from_slice(values).view(shape.as_slice()).to_device(device)
}

/// The values of a tensor of `f32`, row-major.
pub(super) fn values(tensor: &Tensor) -> Vec<f32> {
    let tensor = tensor.detach().to_device(Device::Cpu).contiguous().view(-1);
    let mut values = vec![0.0; tensor.numel()];
    tensor.copy_data(&mut values, tensor.numel());
    values
}
